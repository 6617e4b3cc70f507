#include "hal/store/sqlite/sql_text.hpp"

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
  SqlText sql;
  const std::uint32_t crc = table_fingerprint(sql_type, sql);
  // SQLite keeps user_version as a signed 32-bit number; 0 means a fresh database.
  return static_cast<std::int32_t>(crc & 0x7FFFFFFEU) + 1;
}

}  // namespace ilp
