#include "hal/store/sqlite/columns.hpp"

#include <sqlite3.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "hal/store/checksums.hpp"
#include "hal/store/sql_columns.hpp"

namespace ilp {
namespace {

void bind_element(sqlite3_stmt* statement, int column, const FieldInfo& field, const unsigned char* from) {
  if (field.type == FieldType::text) {
    const auto* text = reinterpret_cast<const char*>(from);
    sqlite3_bind_text(statement, column, text, static_cast<int>(strnlen(text, field.count - 1U)), SQLITE_STATIC);
    return;
  }
  visit_number(field.type, from, [&](auto number) {
    if constexpr (std::is_floating_point_v<decltype(number)>) {
      // SQLite stores a NaN as NULL.
      sqlite3_bind_double(statement, column, static_cast<double>(number));
    } else {
      sqlite3_bind_int64(statement, column, number);
    }
  });
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
  if (field.type == FieldType::text) return read_text(statement, column, field, to);
  return visit_number(field.type, to, [&](auto number) {
    if constexpr (std::is_floating_point_v<decltype(number)>) {
      return read_float<decltype(number)>(statement, column, to);
    } else {
      return read_integer<decltype(number)>(statement, column, to);
    }
  });
}

}  // namespace

void bind_record(sqlite3_stmt* statement, const RecordInfo& info, const void* record) {
  int column = 1;
  const auto* const from = static_cast<const unsigned char*>(record);
  for_each_element(info, [&](const FieldInfo& field, std::size_t offset) {
    bind_element(statement, column++, field, from + offset);
  });
  sqlite3_bind_int64(statement, column, record_checksum(info, record));
}

bool read_record(sqlite3_stmt* statement, const RecordInfo& info, void* record) {
  int column = 0;
  bool fits = true;
  auto* const to = static_cast<unsigned char*>(record);
  for_each_element(info, [&](const FieldInfo& field, std::size_t offset) {
    fits = fits && read_element(statement, column++, field, to + offset);
  });
  return fits && sqlite3_column_type(statement, column) == SQLITE_INTEGER &&
         sqlite3_column_int64(statement, column) == static_cast<std::int64_t>(record_checksum(info, record));
}

}  // namespace ilp
