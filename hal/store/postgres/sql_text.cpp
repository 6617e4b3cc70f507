#include "hal/store/postgres/sql_text.hpp"

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
  add_blob_table("INSERT INTO ", info, field, " SELECT $1::bigint,$2::bigint,''::bytea,''::bytea WHERE NOT EXISTS(",
                 sql);
  add_blob_table("SELECT FROM ", info, field,
                 " WHERE id=$1::bigint AND bytes=$2::bigint) ON CONFLICT(id) DO UPDATE SET bytes=excluded.bytes,"
                 "checksums=excluded.checksums,data=excluded.data",
                 sql);
}

}  // namespace

void create_table(const RecordInfo& info, SqlText& sql) {
  add_table_definition(info, sql_type, sql);
}

void create_blob_table(const RecordInfo& info, const FieldInfo& field, SqlText& sql) {
  add_blob_table("CREATE TABLE ", info, field, "(id bigint PRIMARY KEY, bytes bigint, checksums bytea, data bytea)",
                 sql);
}

// External: they are not compressed.
void keep_blob_external(const RecordInfo& info, const FieldInfo& field, SqlText& sql) {
  add_blob_table("ALTER TABLE ", info, field, " ALTER data SET STORAGE EXTERNAL, ALTER checksums SET STORAGE EXTERNAL",
                 sql);
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
      return add_blob_table("INSERT INTO ", info, field,
                            " VALUES($1,$2,$3,$4) ON CONFLICT(id) DO UPDATE SET bytes=excluded.bytes,"
                            "checksums=excluded.checksums,data=excluded.data",
                            sql);
    case BlobVerb::read:
      return add_blob_table(
          "SELECT bytes,checksums,substring(data FROM 1 FOR $2::bigint::int),octet_length(data)::bigint FROM ", info,
          field, " WHERE id=$1", sql);
    default:
      return add_blob_table("DELETE FROM ", info, field, " WHERE id=$1", sql);
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
      add_blob_table("+pg_relation_size('", info, field, "')+(SELECT coalesce(sum(bytes),0) FROM ", sql);
      add_blob_table("", info, field, ")", sql);
    });
  }
  sql.add(")::bigint");
}

std::int64_t schema_fingerprint() {
  SqlText sql;
  return table_fingerprint(sql_type, sql);
}

}  // namespace ilp::postgres
