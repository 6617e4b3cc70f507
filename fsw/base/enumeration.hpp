// Enumerations whose values have names and meanings, one row per value. Enumerators, documents, names in mission files
// and displays on the ground are made from the rows.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>

namespace ilp {

struct EnumValue {
  std::uint8_t number;  ///< permanent: used on the link and in stored records
  const char* name;
  const char* meaning;  ///< "" where the name is clear by itself
};

/// All values of one enumeration, in the order of their rows.
using EnumValues = std::span<const EnumValue>;

/// Finds the row of a number or a name. Returns the null pointer if no row has it.
[[nodiscard]] constexpr const EnumValue* find_value(EnumValues values, std::uint64_t number) {
  for (const EnumValue& value : values) {
    if (value.number == number) return &value;
  }
  return nullptr;
}

[[nodiscard]] inline const EnumValue* find_value(EnumValues values, const char* name) {
  for (const EnumValue& value : values) {
    if (std::strcmp(value.name, name) == 0) return &value;
  }
  return nullptr;
}

inline constexpr EnumValue boolean_values[] = {{0, "false", ""}, {1, "true", ""}};

/// The name of a value; "?" for a number that no row has.
template <typename Enumeration>
[[nodiscard]] constexpr const char* name_of(Enumeration value) {
  const EnumValue* const found = find_value(values_of(value), static_cast<std::uint8_t>(value));
  return found != nullptr ? found->name : "?";
}

/// The meaning of a value, or its name if the row has no meaning; "unknown" for a number that no row has.
template <typename Enumeration>
[[nodiscard]] constexpr const char* words_of(Enumeration value) {
  const EnumValue* const found = find_value(values_of(value), static_cast<std::uint8_t>(value));
  if (found == nullptr) return "unknown";
  return found->meaning[0] != 0 ? found->meaning : found->name;
}

}  // namespace ilp

#define ILP_ENUM_PARENTHESES ()
#define ILP_ENUM_EXPAND(...) ILP_ENUM_2(ILP_ENUM_2(ILP_ENUM_2(ILP_ENUM_2(ILP_ENUM_2(__VA_ARGS__)))))
#define ILP_ENUM_2(...) ILP_ENUM_3(ILP_ENUM_3(ILP_ENUM_3(ILP_ENUM_3(__VA_ARGS__))))
#define ILP_ENUM_3(...) ILP_ENUM_4(ILP_ENUM_4(ILP_ENUM_4(ILP_ENUM_4(__VA_ARGS__))))
#define ILP_ENUM_4(...) __VA_ARGS__
#define ILP_ENUM_EACH(row, ...) ILP_ENUM_EXPAND(ILP_ENUM_STEP(row, __VA_ARGS__))
#define ILP_ENUM_STEP(row, first, ...) row first __VA_OPT__(ILP_ENUM_AGAIN ILP_ENUM_PARENTHESES(row, __VA_ARGS__))
#define ILP_ENUM_AGAIN() ILP_ENUM_STEP
#define ILP_ENUM_ENUMERATOR(number, name, meaning) name = (number),
#define ILP_ENUM_ROW(number, name, meaning) ::ilp::EnumValue{number, #name, meaning},

/// Declares `enum class name` of one octet from at most 100 rows (number, name, meaning). Its last enumerator is
/// `count`, which is one above the number of the last row.
#define ILP_ENUMERATION(name, ...)                                                                \
  enum class name : std::uint8_t { ILP_ENUM_EACH(ILP_ENUM_ENUMERATOR, __VA_ARGS__) count };       \
  inline constexpr ::ilp::EnumValue name##_values[] = {ILP_ENUM_EACH(ILP_ENUM_ROW, __VA_ARGS__)}; \
  [[nodiscard]] constexpr ::ilp::EnumValues values_of(name) {                                     \
    return name##_values;                                                                         \
  }
