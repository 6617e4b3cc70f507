#include "hal/store/postgres/sql_text.hpp"

#include "fsw/base/crc.hpp"
#include "fsw/records/records.hpp"
#include "hal/store/record_bytes.hpp"
#include "hal/store/sql_columns.hpp"

namespace ilp::postgres {
namespace {

constexpr std::size_t record_count = static_cast<std::size_t>(RecordType::count);

const char* sql_type(FieldType type) {
  switch (type) {
    case FieldType::f32:
      return "real";
    case FieldType::f64:
      return "double precision";
    case FieldType::text:
      return "text";
    default:
      return "bigint";
  }
}

void add_table(const RecordInfo& info, SqlText& sql) {
  sql.add('"').add(info.name).add('"');
}

void insert_or_update(const RecordInfo& info, SqlText& sql) {
  sql.add("INSERT INTO ");
  add_table(info, sql);
  sql.add('(');
  add_columns(info, sql);
  sql.add(") VALUES(");
  std::int64_t columns = 0;
  for_each_column(info, [&](const FieldInfo&, const char*, std::int64_t number) {
    sql.add('$').add(number + 1).add(',');
    columns = number + 1;
  });
  sql.add('$').add(columns + 1).add(')');
  add_replacement(info, sql);
}

void select(const RecordInfo& info, const char* where, SqlText& sql) {
  sql.add("SELECT ");
  add_columns(info, sql);
  sql.add(" FROM ");
  add_table(info, sql);
  sql.add(where);
}

// A row that has this size already is left alone, because its bytes stay.
void resize_blob(const RecordInfo& info, const FieldInfo& field, SqlText& sql) {
  sql.add("INSERT INTO ");
  add_blob_table(info, field, sql);
  sql.add(" SELECT $1::bigint,$2::bigint,''::bytea,''::bytea WHERE NOT EXISTS(SELECT FROM ");
  add_blob_table(info, field, sql);
  sql.add(
      " WHERE id=$1::bigint AND bytes=$2::bigint) ON CONFLICT(id) DO UPDATE SET bytes=excluded.bytes,"
      "checksums=excluded.checksums,data=excluded.data");
}

void fill_blob(const RecordInfo& info, const FieldInfo& field, SqlText& sql) {
  sql.add("INSERT INTO ");
  add_blob_table(info, field, sql);
  sql.add(
      " VALUES($1,$2,$3,$4) ON CONFLICT(id) DO UPDATE SET bytes=excluded.bytes,checksums=excluded.checksums,"
      "data=excluded.data");
}

}  // namespace

void create_table(const RecordInfo& info, SqlText& sql) {
  add_table_definition(info, sql_type, sql);
}

void create_blob_table(const RecordInfo& info, const FieldInfo& field, SqlText& sql) {
  sql.add("CREATE TABLE ");
  add_blob_table(info, field, sql);
  sql.add("(id bigint PRIMARY KEY, bytes bigint, checksums bytea, data bytea)");
}

// External: they are not compressed.
void keep_blob_external(const RecordInfo& info, const FieldInfo& field, SqlText& sql) {
  sql.add("ALTER TABLE ");
  add_blob_table(info, field, sql);
  sql.add(" ALTER data SET STORAGE EXTERNAL, ALTER checksums SET STORAGE EXTERNAL");
}

void row_statement(RowVerb verb, const RecordInfo& info, SqlText& sql) {
  switch (verb) {
    case RowVerb::put:
      return insert_or_update(info, sql);
    case RowVerb::get:
      return select(info, " WHERE id=$1", sql);
    case RowVerb::next:
      return select(info, " WHERE id>$1 ORDER BY id LIMIT $2", sql);
    case RowVerb::last:
      return select(info, " ORDER BY id DESC LIMIT 1", sql);
    case RowVerb::erase:
      sql.add("DELETE FROM ");
      add_table(info, sql);
      sql.add(" WHERE id=$1");
      return;
    default:
      sql.add("SELECT count(*) FROM ");
      add_table(info, sql);
  }
}

void blob_statement(BlobVerb verb, const RecordInfo& info, const FieldInfo& field, SqlText& sql) {
  switch (verb) {
    case BlobVerb::resize:
      return resize_blob(info, field, sql);
    case BlobVerb::fill:
      return fill_blob(info, field, sql);
    case BlobVerb::read:
      sql.add("SELECT bytes,checksums,substring(data FROM 1 FOR $2::bigint::int),octet_length(data)::bigint FROM ");
      add_blob_table(info, field, sql);
      sql.add(" WHERE id=$1");
      return;
    default:
      sql.add("DELETE FROM ");
      add_blob_table(info, field, sql);
      sql.add(" WHERE id=$1");
  }
}

void create_store_table(SqlText& sql) {
  sql.add("CREATE TABLE ilp_store(fingerprint bigint, commits bigint");
  for (std::size_t t = 0; t < record_count; ++t) {
    sql.add(", \"").add(record_info(static_cast<RecordType>(t)).name).add("\" bigint");
  }
  sql.add(')');
}

void fill_store_table(SqlText& sql) {
  sql.add("INSERT INTO ilp_store VALUES(").add(schema_fingerprint()).add(",0");
  for (std::size_t t = 0; t < record_count; ++t) sql.add(",0");
  sql.add(')');
}

void look_at_changes(SqlText& sql) {
  sql.add("SELECT commits");
  for (std::size_t t = 0; t < record_count; ++t) {
    sql.add(",\"").add(record_info(static_cast<RecordType>(t)).name).add('"');
  }
  sql.add(" FROM ilp_store");
}

void note_changes(SqlText& sql) {
  sql.add("WITH moved AS(UPDATE ilp_store SET commits=commits+1");
  for (std::size_t t = 0; t < record_count; ++t) {
    const char* const name = record_info(static_cast<RecordType>(t)).name;
    sql.add(",\"").add(name).add("\"=CASE WHEN $1::bigint>>").add(static_cast<std::int64_t>(t));
    sql.add("&1=1 THEN commits+1 ELSE \"").add(name).add("\" END");
  }
  sql.add(
      " RETURNING commits) SELECT commits,CASE WHEN $2::bigint=1 THEN "
      "pg_notify('ilp',commits::text||' '||$1::bigint::text) END FROM moved");
}

void used_bytes(SqlText& sql) {
  sql.add("SELECT (");
  for (std::size_t t = 0; t < record_count; ++t) {
    const RecordInfo& info = record_info(static_cast<RecordType>(t));
    if (t != 0) sql.add('+');
    sql.add("pg_relation_size('");
    add_table(info, sql);
    sql.add("')");
    for_each_blob(info, [&](const FieldInfo& field, std::size_t) {
      sql.add("+pg_relation_size('");
      add_blob_table(info, field, sql);
      sql.add("')+(SELECT coalesce(sum(bytes),0) FROM ");
      add_blob_table(info, field, sql);
      sql.add(')');
    });
  }
  sql.add(")::bigint");
}

std::int64_t schema_fingerprint() {
  auto crc = static_cast<std::uint32_t>(schema_version);
  for (std::size_t t = 0; t < record_count; ++t) {
    const RecordInfo& info = record_info(static_cast<RecordType>(t));
    SqlText sql;
    create_table(info, sql);
    // The columns do not show the width of a number or the capacity of a text.
    for (std::size_t f = 0; f < info.field_count; ++f) {
      sql.add(' ').add(static_cast<std::int64_t>(info.fields[f].type)).add(' ').add(std::int64_t{info.fields[f].count});
    }
    crc = crc32({reinterpret_cast<const std::uint8_t*>(sql.c_str()), sql.size()}, crc);
  }
  return crc;
}

}  // namespace ilp::postgres
