// SQL text that is the same for every database: names of tables and columns, definitions of tables.
//
// A record has a column per array element (`name_0`, ...), followed by `record_checksum`. A blob field becomes the
// column `name_bytes` and a table of its own, `record_name`, so that changing a record never rewrites its blob.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fsw/base/crc.hpp"
#include "fsw/base/text.hpp"
#include "fsw/records/records.hpp"

namespace ilp {

/// Column with record_checksum() of the row. It is no field of the record.
inline constexpr const char* checksum_column = "\"record_checksum\"";

/// Columns of a field: 1 for a text, else one for each element.
[[nodiscard]] inline std::uint16_t column_count(const FieldInfo& field) {
  return field.type == FieldType::text ? std::uint16_t{1} : field.count;
}

/// Calls visit(field, column, number) for each column but the checksum; numbers count from 0. `column` is the name in
/// quotes, because some names are words of SQL.
template <typename Visit>
void for_each_column(const RecordInfo& info, Visit visit) {
  std::int64_t number = 0;
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    for (std::uint16_t i = 0; i < column_count(field); ++i) {
      FixedText<96> column;
      column.add('"').add(field.name);
      if (field.type == FieldType::blob) column.add("_bytes");
      if (column_count(field) > 1) column.add('_').add(std::int64_t{i});
      visit(field, column.add('"').c_str(), number++);
    }
  }
}

/// Calls visit(field, offset) for the same columns in the same order; `offset` is that of the column's element in the
/// record, in bytes.
template <typename Visit>
void for_each_element(const RecordInfo& info, Visit visit) {
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    for (std::size_t i = 0; i < column_count(field); ++i) visit(field, field.offset + i * element_bytes(field.type));
  }
}

/// Adds the names of all columns with commas between them; the checksum is last.
template <std::size_t capacity>
void add_columns(const RecordInfo& info, FixedText<capacity>& sql) {
  for_each_column(info, [&](const FieldInfo&, const char* column, std::int64_t) { sql.add(column).add(','); });
  sql.add(checksum_column);
}

/// Adds the clause after the values of a new row by which they replace those of a row with the same id.
template <std::size_t capacity>
void add_replacement(const RecordInfo& info, FixedText<capacity>& sql) {
  sql.add(" ON CONFLICT(id) DO UPDATE SET ");
  for_each_column(info, [&](const FieldInfo&, const char* column, std::int64_t number) {
    if (number != 0) sql.add(column).add("=excluded.").add(column).add(',');
  });
  sql.add(checksum_column).add("=excluded.").add(checksum_column);
}

/// Adds the CREATE TABLE statement. type() returns the database's name of a field's type.
template <std::size_t capacity>
void add_table_definition(const RecordInfo& info, const char* (*type)(FieldType), FixedText<capacity>& sql) {
  sql.add("CREATE TABLE \"").add(info.name).add("\"(");
  for_each_column(info, [&](const FieldInfo& field, const char* column, std::int64_t number) {
    if (number != 0) sql.add(", ");
    sql.add(column).add(' ').add(type(field.type)).add(number == 0 ? " PRIMARY KEY" : "");
  });
  sql.add(", ").add(checksum_column).add(' ').add(type(FieldType::u32)).add(')');
}

/// Adds the name of the table that holds the blobs of a field.
inline void blob_table_name(const RecordInfo& info, const char* field, FixedText<96>& name) {
  name.add(info.name).add('_').add(field);
}

/// Adds `before`, the quoted name of the blob field's table, and `behind`.
template <std::size_t capacity>
void add_blob_table(const char* before, const RecordInfo& info, const FieldInfo& field, const char* behind,
                    FixedText<capacity>& sql) {
  FixedText<96> name;
  blob_table_name(info, field.name, name);
  sql.add(before).add('"').add(name.c_str()).add('"').add(behind);
}

/// Returns a CRC over the definitions of all tables, which changes with any field. `sql` is scratch with the capacity
/// for the definition of one table.
template <std::size_t capacity>
[[nodiscard]] std::uint32_t table_fingerprint(const char* (*type)(FieldType), FixedText<capacity>& sql) {
  auto crc = static_cast<std::uint32_t>(schema_version);
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    const RecordInfo& info = record_info(static_cast<RecordType>(t));
    sql.clear();
    add_table_definition(info, type, sql);
    // The columns do not show the width of a number or the capacity of a text.
    for (std::size_t f = 0; f < info.field_count; ++f) {
      sql.add(' ').add(static_cast<std::int64_t>(info.fields[f].type)).add(' ').add(std::int64_t{info.fields[f].count});
    }
    crc = crc32({reinterpret_cast<const std::uint8_t*>(sql.c_str()), sql.size()}, crc);
  }
  return crc;
}

}  // namespace ilp
