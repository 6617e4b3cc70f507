#include "hal/store/sqlite/sql_text.hpp"

#include "fsw/base/crc.hpp"
#include "fsw/records/records.hpp"
#include "hal/store/sql_columns.hpp"

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

}  // namespace

void create_table(const RecordInfo& info, SqlText& sql) {
  add_table_definition(info, sql_type, sql);
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
  for_each_column(info, [&](const FieldInfo&, const char*, std::int64_t) { sql.add("?,"); });
  sql.add("?)");
  add_replacement(info, sql);
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
