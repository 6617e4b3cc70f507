#include "hal/store/sqlite/columns.hpp"

#include <sqlite3.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "hal/store/checksums.hpp"
#include "hal/store/sql_columns.hpp"

namespace ilp {
namespace {

template <typename T>
T value_at(const unsigned char* from) {
  T value;
  std::memcpy(&value, from, sizeof(value));
  return value;
}

void bind_element(sqlite3_stmt* statement, int column, const FieldInfo& field, const unsigned char* from) {
  switch (field.type) {
    case FieldType::u8:
      sqlite3_bind_int64(statement, column, *from);
      return;
    case FieldType::u16:
      sqlite3_bind_int64(statement, column, value_at<std::uint16_t>(from));
      return;
    case FieldType::blob:
    case FieldType::u32:
      sqlite3_bind_int64(statement, column, value_at<std::uint32_t>(from));
      return;
    case FieldType::i32:
      sqlite3_bind_int64(statement, column, value_at<std::int32_t>(from));
      return;
    case FieldType::i64:
      sqlite3_bind_int64(statement, column, value_at<std::int64_t>(from));
      return;
    case FieldType::f32:
      // SQLite stores a NaN as NULL.
      sqlite3_bind_double(statement, column, static_cast<double>(value_at<float>(from)));
      return;
    case FieldType::f64:
      sqlite3_bind_double(statement, column, value_at<double>(from));
      return;
    case FieldType::text: {
      const auto* text = reinterpret_cast<const char*>(from);
      const auto length = static_cast<int>(strnlen(text, field.count - 1U));
      sqlite3_bind_text(statement, column, text, length, SQLITE_STATIC);
      return;
    }
  }
}

template <typename Integer>
bool read_integer(sqlite3_stmt* statement, int column, unsigned char* to) {
  if (sqlite3_column_type(statement, column) != SQLITE_INTEGER) return false;
  const std::int64_t stored = sqlite3_column_int64(statement, column);
  const auto value = static_cast<Integer>(stored);
  std::memcpy(to, &value, sizeof(value));
  return static_cast<std::int64_t>(value) == stored;
}

template <typename Float>
bool read_float(sqlite3_stmt* statement, int column, unsigned char* to) {
  const int type = sqlite3_column_type(statement, column);
  if (type != SQLITE_NULL && type != SQLITE_FLOAT) return false;
  const double stored =
      type == SQLITE_NULL ? std::numeric_limits<double>::quiet_NaN() : sqlite3_column_double(statement, column);
  if (std::fabs(stored) > static_cast<double>(std::numeric_limits<Float>::max()) && std::isfinite(stored)) return false;
  const auto value = static_cast<Float>(stored);
  std::memcpy(to, &value, sizeof(value));
  return type == SQLITE_NULL || static_cast<double>(value) == stored;
}

bool read_text(sqlite3_stmt* statement, int column, const FieldInfo& field, unsigned char* to) {
  std::memset(to, 0, field.count);
  if (sqlite3_column_type(statement, column) != SQLITE_TEXT) return false;
  const auto* const text = reinterpret_cast<const char*>(sqlite3_column_text(statement, column));
  const auto length = static_cast<std::size_t>(sqlite3_column_bytes(statement, column));
  if (text == nullptr || length >= field.count || strnlen(text, length) != length) return false;
  std::memcpy(to, text, length);
  return true;
}

bool read_element(sqlite3_stmt* statement, int column, const FieldInfo& field, unsigned char* to) {
  switch (field.type) {
    case FieldType::u8:
      return read_integer<std::uint8_t>(statement, column, to);
    case FieldType::u16:
      return read_integer<std::uint16_t>(statement, column, to);
    case FieldType::blob:
    case FieldType::u32:
      return read_integer<std::uint32_t>(statement, column, to);
    case FieldType::i32:
      return read_integer<std::int32_t>(statement, column, to);
    case FieldType::i64:
      return read_integer<std::int64_t>(statement, column, to);
    case FieldType::f32:
      return read_float<float>(statement, column, to);
    case FieldType::f64:
      return read_float<double>(statement, column, to);
    case FieldType::text:
      return read_text(statement, column, field, to);
  }
  return false;
}

}  // namespace

void bind_record(sqlite3_stmt* statement, const RecordInfo& info, const void* record) {
  int column = 1;
  const auto* const from = static_cast<const unsigned char*>(record);
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    for (std::size_t i = 0; i < column_count(field); ++i) {
      bind_element(statement, column++, field, from + field.offset + i * element_bytes(field.type));
    }
  }
  sqlite3_bind_int64(statement, column, record_checksum(info, record));
}

bool read_record(sqlite3_stmt* statement, const RecordInfo& info, void* record) {
  int column = 0;
  bool fits = true;
  auto* const to = static_cast<unsigned char*>(record);
  for (std::size_t f = 0; f < info.field_count && fits; ++f) {
    const FieldInfo& field = info.fields[f];
    for (std::size_t i = 0; i < column_count(field) && fits; ++i) {
      fits = read_element(statement, column++, field, to + field.offset + i * element_bytes(field.type));
    }
  }
  return fits && sqlite3_column_type(statement, column) == SQLITE_INTEGER &&
         sqlite3_column_int64(statement, column) == static_cast<std::int64_t>(record_checksum(info, record));
}

}  // namespace ilp
