#include "hal/store/sqlite/sql_text.hpp"

#include <cstring>
#include <span>

#include "fsw/base/crc.hpp"
#include "fsw/records/records.hpp"

namespace ilp {
namespace {

const char* sql_type(FieldType type) {
  switch (type) {
    case FieldType::f32:
    case FieldType::f64:
      return "REAL";
    case FieldType::text:
      return "TEXT";
    default:
      return "INTEGER";
  }
}

/// Calls visit(field, column, first). Names are quoted because some are words of SQL.
template <typename Visit>
void for_each_column(const RecordInfo& info, Visit visit) {
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    for (std::uint16_t i = 0; i < column_count(field); ++i) {
      FixedText<96> column;
      column.add('"').add(field.name);
      if (field.type == FieldType::blob) column.add("_bytes");
      if (column_count(field) > 1) column.add('_').add(std::int64_t{i});
      visit(field, column.add('"').c_str(), f == 0);
    }
  }
}

// The checksum of the whole row. It is no field of the record.
constexpr const char* checksum_column = "\"record_checksum\"";

void add_columns(const RecordInfo& info, SqlText& sql) {
  for_each_column(info, [&](const FieldInfo&, const char* column, bool) { sql.add(column).add(','); });
  sql.add(checksum_column);
}

void add_blob_table(const RecordInfo& info, const FieldInfo& field, SqlText& sql) {
  FixedText<96> name;
  blob_table_name(info, field.name, name);
  sql.add('"').add(name.c_str()).add('"');
}

}  // namespace

void blob_table_name(const RecordInfo& info, const char* field, FixedText<96>& name) {
  name.add(info.name).add('_').add(field);
}

void create_table(const RecordInfo& info, SqlText& sql) {
  sql.add("CREATE TABLE \"").add(info.name).add("\"(");
  for_each_column(info, [&](const FieldInfo& field, const char* column, bool first) {
    if (!first) sql.add(", ");
    sql.add(column).add(' ').add(sql_type(field.type)).add(first ? " PRIMARY KEY" : "");
  });
  sql.add(", ").add(checksum_column).add(" INTEGER)");
}

void create_blob_table(const RecordInfo& info, const FieldInfo& field, SqlText& sql) {
  sql.add("CREATE TABLE ");
  add_blob_table(info, field, sql);
  sql.add("(\"id\" INTEGER PRIMARY KEY, \"checksums\" BLOB, \"data\" BLOB)");
}

void replace_blob(const RecordInfo& info, const FieldInfo& field, SqlText& sql) {
  sql.add("INSERT OR REPLACE INTO ");
  add_blob_table(info, field, sql);
  sql.add("(id, checksums, data) VALUES(?, zeroblob(?), zeroblob(?))");
}

void blob_size(const RecordInfo& info, const FieldInfo& field, SqlText& sql) {
  sql.add("SELECT length(data) FROM ");
  add_blob_table(info, field, sql);
  sql.add(" WHERE id=?");
}

void delete_blob(const RecordInfo& info, const FieldInfo& field, SqlText& sql) {
  sql.add("DELETE FROM ");
  add_blob_table(info, field, sql);
  sql.add(" WHERE id=?");
}

void insert_or_update(const RecordInfo& info, SqlText& sql) {
  sql.add("INSERT INTO \"").add(info.name).add("\"(");
  add_columns(info, sql);
  sql.add(") VALUES(");
  for_each_column(info, [&](const FieldInfo&, const char*, bool) { sql.add("?,"); });
  sql.add("?) ON CONFLICT(id) DO UPDATE SET ");
  for_each_column(info, [&](const FieldInfo&, const char* column, bool first) {
    if (!first) sql.add(column).add("=excluded.").add(column).add(',');
  });
  sql.add(checksum_column).add("=excluded.").add(checksum_column);
}

void select(const RecordInfo& info, const char* where, SqlText& sql) {
  sql.add("SELECT ");
  add_columns(info, sql);
  sql.add(" FROM \"").add(info.name).add("\" ").add(where);
}

std::int32_t schema_fingerprint() {
  std::uint32_t crc = static_cast<std::uint32_t>(schema_version);
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    const RecordInfo& info = record_info(static_cast<RecordType>(t));
    SqlText sql;
    create_table(info, sql);
    // The columns do not show the width of a number or the capacity of a text.
    for (std::size_t f = 0; f < info.field_count; ++f) {
      sql.add(' ').add(static_cast<std::int64_t>(info.fields[f].type)).add(' ').add(std::int64_t{info.fields[f].count});
    }
    crc = crc32({reinterpret_cast<const std::uint8_t*>(sql.c_str()), sql.size()}, crc);
  }
  // SQLite keeps user_version as a signed 32-bit number; 0 means a fresh database.
  return static_cast<std::int32_t>(crc & 0x7FFFFFFEU) + 1;
}

}  // namespace ilp
