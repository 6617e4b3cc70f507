// Types that describe records and their fields. The rows of fsw/records/records.inc give one table of fields per
// record.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "fsw/base/enumeration.hpp"
#include "fsw/base/flag.hpp"

namespace ilp {

enum class FieldType : std::uint8_t { u8, u16, u32, i32, i64, f32, f64, text, blob };

/// Bytes of one element, in memory and in the serial form. For a blob they are those of its size field.
[[nodiscard]] constexpr std::size_t element_bytes(FieldType type) {
  switch (type) {
    case FieldType::u8:
    case FieldType::text:
      return 1;
    case FieldType::u16:
      return 2;
    case FieldType::u32:
    case FieldType::i32:
    case FieldType::f32:
    case FieldType::blob:
      return 4;
    case FieldType::i64:
    case FieldType::f64:
      return 8;
  }
  return 1;
}

/// A column whose bytes are only in the store, where they are read and written in parts. The struct has their number.
struct Blob {
  std::uint32_t bytes = 0;
};

struct FieldInfo {
  const char* name;
  FieldType type;
  std::uint16_t offset;  ///< offset in the struct, bytes
  std::uint16_t count;   ///< number of array elements; for text the capacity in bytes, terminator included
  const char* unit;      ///< "" for pure numbers
  const char* description;
  EnumValues values;  ///< rows of the enumeration; empty for other fields
};

/// The tables of the store, in the order of fsw/records/records.inc.
enum class RecordType : std::uint8_t {
#define RECORD(number, record, name, ...) name = (number),
#include "fsw/records/records.inc"
  count
};

/// One bit per RecordType, for sets of tables.
using RecordMask = std::uint64_t;
[[nodiscard]] constexpr RecordMask mask_of(RecordType type) {
  return RecordMask{1} << static_cast<unsigned>(type);
}
template <typename... Types>
[[nodiscard]] constexpr RecordMask mask_of(RecordType first, Types... rest) {
  return mask_of(first) | (mask_of(rest) | ... | RecordMask{0});
}

/// The number after which the ids of a table begin in a later store epoch.
enum class Numbering : std::uint8_t {
  by_record,   ///< IdentityRecord::record_base
  by_keyframe  ///< IdentityRecord::keyframe_base, for tables whose ids are numbers of keyframes or strips
};

/// The first field of every record is `std::int64_t id`, its primary key, at offset 0.
struct RecordInfo {
  RecordType type;
  const char* name;
  Numbering numbering;
  const char* description;
  std::uint16_t bytes;  ///< sizeof the struct
  std::uint16_t field_count;
  const FieldInfo* fields;
};

namespace detail {

/// The field type of a member's type. `bool` has none, because an octet from a file or a link may be neither 0 nor 1; a
/// Flag replaces it.
template <typename T>
constexpr FieldType field_type() {
  using E = std::remove_cv_t<std::remove_all_extents_t<T>>;
  if constexpr (std::is_same_v<E, Blob>) {
    return FieldType::blob;
  } else if constexpr (std::is_same_v<E, char>) {
    return FieldType::text;
  } else if constexpr (std::is_enum_v<E>) {
    static_assert(sizeof(E) == 1, "enumerations of records are one byte");
    return FieldType::u8;
  } else if constexpr (std::is_same_v<E, std::uint8_t> || std::is_same_v<E, Flag>) {
    return FieldType::u8;
  } else if constexpr (std::is_same_v<E, std::uint16_t>) {
    return FieldType::u16;
  } else if constexpr (std::is_same_v<E, std::uint32_t>) {
    return FieldType::u32;
  } else if constexpr (std::is_same_v<E, std::int32_t>) {
    return FieldType::i32;
  } else if constexpr (std::is_same_v<E, std::int64_t>) {
    return FieldType::i64;
  } else if constexpr (std::is_same_v<E, float>) {
    return FieldType::f32;
  } else {
    static_assert(std::is_same_v<E, double>, "no field type for this member");
    return FieldType::f64;
  }
}

template <typename T>
constexpr EnumValues field_values() {
  if constexpr (std::is_enum_v<T>) return values_of(T{});
  return {};
}

template <typename T>
constexpr std::uint16_t field_count() {
  static_assert(std::rank_v<T> <= 1);
  return std::is_array_v<T> ? static_cast<std::uint16_t>(std::extent_v<T>) : std::uint16_t{1};
}

}  // namespace detail

/// A row of a field table, for a member of the struct `R`.
#define ILP_FIELD(member, unit, description, values)                                                                \
  ::ilp::FieldInfo {                                                                                                \
#member, ::ilp::detail::field_type < decltype(R::member)>(), static_cast < std::uint16_t>(offsetof(R, member)), \
        ::ilp::detail::field_count < decltype(R::member)>(), unit, description, values                              \
  }

}  // namespace ilp
