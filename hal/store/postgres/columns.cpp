#include "hal/store/postgres/columns.hpp"

#include <cstring>

#include "hal/store/checksums.hpp"
#include "hal/store/sql_columns.hpp"

namespace ilp::postgres {
namespace {

template <typename T>
T value_at(const unsigned char* from) {
  T value;
  std::memcpy(&value, from, sizeof(value));
  return value;
}

void bind_element(const FieldInfo& field, const unsigned char* from, Parameters& parameters) {
  switch (field.type) {
    case FieldType::u8:
      parameters.add(std::int64_t{*from});
      return;
    case FieldType::u16:
      parameters.add(std::int64_t{value_at<std::uint16_t>(from)});
      return;
    case FieldType::blob:
    case FieldType::u32:
      parameters.add(std::int64_t{value_at<std::uint32_t>(from)});
      return;
    case FieldType::i32:
      parameters.add(std::int64_t{value_at<std::int32_t>(from)});
      return;
    case FieldType::i64:
      parameters.add(value_at<std::int64_t>(from));
      return;
    case FieldType::f32:
      parameters.add(value_at<float>(from));
      return;
    case FieldType::f64:
      parameters.add(value_at<double>(from));
      return;
    case FieldType::text: {
      const auto* const text = reinterpret_cast<const char*>(from);
      parameters.add_bytes(text, strnlen(text, field.count - 1U));
      return;
    }
  }
}

template <typename Integer>
bool read_integer(const Rows& rows, int row, int column, unsigned char* to) {
  std::int64_t stored = 0;
  if (!rows.integer(row, column, stored)) return false;
  const auto value = static_cast<Integer>(stored);
  std::memcpy(to, &value, sizeof(value));
  return static_cast<std::int64_t>(value) == stored;
}

template <typename Float>
bool read_real(const Rows& rows, int row, int column, unsigned char* to) {
  Float value = 0;
  if (!rows.real(row, column, value)) return false;
  std::memcpy(to, &value, sizeof(value));
  return true;
}

bool read_text(const Rows& rows, int row, int column, const FieldInfo& field, unsigned char* to) {
  std::memset(to, 0, field.count);
  std::span<const std::uint8_t> text;
  if (!rows.bytes(row, column, text) || text.size() >= field.count) return false;
  if (!text.empty()) std::memcpy(to, text.data(), text.size());
  return strnlen(reinterpret_cast<const char*>(to), field.count) == text.size();
}

bool read_element(const Rows& rows, int row, int column, const FieldInfo& field, unsigned char* to) {
  switch (field.type) {
    case FieldType::u8:
      return read_integer<std::uint8_t>(rows, row, column, to);
    case FieldType::u16:
      return read_integer<std::uint16_t>(rows, row, column, to);
    case FieldType::blob:
    case FieldType::u32:
      return read_integer<std::uint32_t>(rows, row, column, to);
    case FieldType::i32:
      return read_integer<std::int32_t>(rows, row, column, to);
    case FieldType::i64:
      return read_integer<std::int64_t>(rows, row, column, to);
    case FieldType::f32:
      return read_real<float>(rows, row, column, to);
    case FieldType::f64:
      return read_real<double>(rows, row, column, to);
    case FieldType::text:
      return read_text(rows, row, column, field, to);
  }
  return false;
}

}  // namespace

void bind_record(const RecordInfo& info, const void* record, Parameters& parameters) {
  const auto* const from = static_cast<const unsigned char*>(record);
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    for (std::size_t i = 0; i < column_count(field); ++i) {
      bind_element(field, from + field.offset + i * element_bytes(field.type), parameters);
    }
  }
  parameters.add(std::int64_t{record_checksum(info, record)});
}

void canonical_record(const RecordInfo& info, const void* record, void* as_read) {
  const auto* const from = static_cast<const unsigned char*>(record);
  auto* const to = static_cast<unsigned char*>(as_read);
  std::memset(to, 0, info.bytes);
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    if (field.type == FieldType::text) {
      const auto* const text = reinterpret_cast<const char*>(from + field.offset);
      std::memcpy(to + field.offset, text, strnlen(text, field.count - 1U));
    } else {
      std::memcpy(to + field.offset, from + field.offset, field.count * element_bytes(field.type));
    }
    for (std::size_t i = 0; i < field.count; ++i) {
      unsigned char* const at = to + field.offset + i * element_bytes(field.type);
      const bool zero = (field.type == FieldType::f32 && value_at<float>(at) == 0) ||
                        (field.type == FieldType::f64 && value_at<double>(at) == 0);
      if (zero) std::memset(at, 0, element_bytes(field.type));
    }
  }
}

bool read_record(const RecordInfo& info, const Rows& rows, int row, void* record) {
  int column = 0;
  bool fits = true;
  auto* const to = static_cast<unsigned char*>(record);
  for (std::size_t f = 0; f < info.field_count && fits; ++f) {
    const FieldInfo& field = info.fields[f];
    for (std::size_t i = 0; i < column_count(field) && fits; ++i) {
      fits = read_element(rows, row, column++, field, to + field.offset + i * element_bytes(field.type));
    }
  }
  std::int64_t sum = 0;
  return fits && rows.integer(row, column, sum) && sum == std::int64_t{record_checksum(info, record)};
}

}  // namespace ilp::postgres
