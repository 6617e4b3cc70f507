#include "hal/store/postgres/columns.hpp"

#include <cstring>
#include <type_traits>

#include "hal/store/checksums.hpp"
#include "hal/store/sql_columns.hpp"

namespace ilp::postgres {
namespace {

/// As which type the server keeps a number.
template <typename Number>
using Stored = std::conditional_t<std::is_floating_point_v<Number>, Number, std::int64_t>;

void bind_element(const FieldInfo& field, const unsigned char* from, Parameters& parameters) {
  if (field.type == FieldType::text) {
    const auto* const text = reinterpret_cast<const char*>(from);
    parameters.add_bytes(text, strnlen(text, field.count - 1U));
    return;
  }
  visit_number(field.type, from, [&](auto number) { parameters.add(Stored<decltype(number)>{number}); });
}

bool read_text(const Rows& rows, int row, int column, const FieldInfo& field, unsigned char* to) {
  std::memset(to, 0, field.count);
  std::span<const std::uint8_t> text;
  if (!rows.bytes(row, column, text) || text.size() >= field.count) return false;
  if (!text.empty()) std::memcpy(to, text.data(), text.size());
  return strnlen(reinterpret_cast<const char*>(to), field.count) == text.size();
}

bool read_element(const Rows& rows, int row, int column, const FieldInfo& field, unsigned char* to) {
  if (field.type == FieldType::text) return read_text(rows, row, column, field, to);
  return visit_number(field.type, to, [&](auto number) {
    Stored<decltype(number)> stored{};
    if (!rows.number(row, column, stored)) return false;
    number = static_cast<decltype(number)>(stored);
    std::memcpy(to, &number, sizeof(number));
    return std::is_floating_point_v<decltype(number)> || stored == number;
  });
}

}  // namespace

void bind_record(const RecordInfo& info, const void* record, Parameters& parameters) {
  const auto* const from = static_cast<const unsigned char*>(record);
  for_each_element(info,
                   [&](const FieldInfo& field, std::size_t offset) { bind_element(field, from + offset, parameters); });
  parameters.add(std::int64_t{record_checksum(info, record)});
}

void canonical_record(const RecordInfo& info, const void* record, void* as_read) {
  const auto* const from = static_cast<const unsigned char*>(record);
  auto* const to = static_cast<unsigned char*>(as_read);
  std::memset(to, 0, info.bytes);
  for_each_element(info, [&](const FieldInfo& field, std::size_t offset) {
    if (field.type == FieldType::text) {
      const auto* const text = reinterpret_cast<const char*>(from + offset);
      std::memcpy(to + offset, text, strnlen(text, field.count - 1U));
      return;
    }
    visit_number(field.type, from + offset, [&](auto number) {
      if (number == 0) number = 0;
      std::memcpy(to + offset, &number, sizeof(number));
    });
  });
}

bool read_record(const RecordInfo& info, const Rows& rows, int row, void* record) {
  int column = 0;
  bool fits = true;
  auto* const to = static_cast<unsigned char*>(record);
  for_each_element(info, [&](const FieldInfo& field, std::size_t offset) {
    fits = fits && read_element(rows, row, column++, field, to + offset);
  });
  std::int64_t sum = 0;
  return fits && rows.number(row, column, sum) && sum == std::int64_t{record_checksum(info, record)};
}

}  // namespace ilp::postgres
