#include "hal/store/sqlite/sqlite_store.hpp"

#include <sqlite3.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "hal/store/sqlite/sql_text.hpp"

namespace ilp {
namespace {

// Pages kept in memory; with the statements and a large blob's handle this fits the arena of the flight profile.
constexpr const char* settings[] = {
    "PRAGMA page_size=4096",          "PRAGMA journal_mode=WAL",
    "PRAGMA synchronous=FULL",        "PRAGMA cache_size=-3072",
    "PRAGMA cache_spill=ON",          "PRAGMA journal_size_limit=8388608",
    "PRAGMA temp_store=MEMORY",       "PRAGMA mmap_size=0",
    "PRAGMA foreign_keys=OFF",        "PRAGMA trusted_schema=OFF",
    "PRAGMA wal_autocheckpoint=1000",
};

void bind_element(sqlite3_stmt* statement, int column, const FieldInfo& field, const unsigned char* from) {
  switch (field.type) {
    case FieldType::u8:
      sqlite3_bind_int64(statement, column, *from);
      return;
    case FieldType::u16: {
      std::uint16_t value;
      std::memcpy(&value, from, sizeof(value));
      sqlite3_bind_int64(statement, column, value);
      return;
    }
    case FieldType::blob:
    case FieldType::u32: {
      std::uint32_t value;
      std::memcpy(&value, from, sizeof(value));
      sqlite3_bind_int64(statement, column, value);
      return;
    }
    case FieldType::i32: {
      std::int32_t value;
      std::memcpy(&value, from, sizeof(value));
      sqlite3_bind_int64(statement, column, value);
      return;
    }
    case FieldType::i64: {
      std::int64_t value;
      std::memcpy(&value, from, sizeof(value));
      sqlite3_bind_int64(statement, column, value);
      return;
    }
    case FieldType::f32: {
      float value;
      std::memcpy(&value, from, sizeof(value));
      // SQLite stores a NaN as NULL.
      sqlite3_bind_double(statement, column, static_cast<double>(value));
      return;
    }
    case FieldType::f64: {
      double value;
      std::memcpy(&value, from, sizeof(value));
      sqlite3_bind_double(statement, column, value);
      return;
    }
    case FieldType::text: {
      const auto* text = reinterpret_cast<const char*>(from);
      const auto length = static_cast<int>(strnlen(text, field.count));
      sqlite3_bind_text(statement, column, text, length, SQLITE_STATIC);
      return;
    }
  }
}

double column_number(sqlite3_stmt* statement, int column) {
  if (sqlite3_column_type(statement, column) == SQLITE_NULL) return std::numeric_limits<double>::quiet_NaN();
  return sqlite3_column_double(statement, column);
}

template <typename T>
void assign(unsigned char* to, T value) {
  std::memcpy(to, &value, sizeof(value));
}

void read_element(sqlite3_stmt* statement, int column, const FieldInfo& field, unsigned char* to) {
  const std::int64_t integer = sqlite3_column_int64(statement, column);
  switch (field.type) {
    case FieldType::u8:
      return assign(to, static_cast<std::uint8_t>(integer));
    case FieldType::u16:
      return assign(to, static_cast<std::uint16_t>(integer));
    case FieldType::blob:
    case FieldType::u32:
      return assign(to, static_cast<std::uint32_t>(integer));
    case FieldType::i32:
      return assign(to, static_cast<std::int32_t>(integer));
    case FieldType::i64:
      return assign(to, integer);
    case FieldType::f32:
      return assign(to, static_cast<float>(column_number(statement, column)));
    case FieldType::f64:
      return assign(to, column_number(statement, column));
    case FieldType::text: {
      std::memset(to, 0, field.count);
      const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement, column));
      if (text != nullptr) std::memcpy(to, text, strnlen(text, field.count - 1U));
      return;
    }
  }
}

std::size_t element_size(const FieldInfo& field) {
  switch (field.type) {
    case FieldType::u8:
    case FieldType::text:
      return 1;
    case FieldType::u16:
      return 2;
    case FieldType::i64:
    case FieldType::f64:
      return 8;
    default:
      return 4;
  }
}

const FieldInfo* find_blob_field(const RecordInfo& info, const char* name) {
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    if (field.type == FieldType::blob && std::strcmp(field.name, name) == 0) return &field;
  }
  return nullptr;
}

std::uint32_t blob_bytes(const void* record, const FieldInfo& field) {
  Blob blob;
  std::memcpy(&blob, static_cast<const unsigned char*>(record) + field.offset, sizeof(blob));
  return blob.bytes;
}

std::int64_t id_of(const void* record) {
  std::int64_t id;
  std::memcpy(&id, record, sizeof(id));
  return id;
}

}  // namespace

SqliteStore::~SqliteStore() {
  close();
}

Status SqliteStore::fault(int code) const {
  const int extended = database_ != nullptr ? sqlite3_extended_errcode(database_) : code;
  switch (code & 0xFF) {
    case SQLITE_NOMEM:
      return {StatusCode::arena_exhausted, 1, extended};
    case SQLITE_FULL:
      return {StatusCode::store_full, 0, extended};
    default:
      return {StatusCode::store_error, code, extended};
  }
}

Status SqliteStore::execute(const char* sql) {
  const int code = sqlite3_exec(database_, sql, nullptr, nullptr, nullptr);
  return code == SQLITE_OK ? Status{} : fault(code);
}

Status SqliteStore::prepare(const char* sql, sqlite3_stmt*& statement) {
  const int code = sqlite3_prepare_v3(database_, sql, -1, SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
  return code == SQLITE_OK ? Status{} : fault(code);
}

Status SqliteStore::run(sqlite3_stmt* statement) {
  const int code = sqlite3_step(statement);
  const Status status = code == SQLITE_DONE || code == SQLITE_ROW ? Status{} : fault(code);
  sqlite3_reset(statement);
  sqlite3_clear_bindings(statement);
  return status;
}

Status SqliteStore::integer_of(sqlite3_stmt* statement, std::int64_t& value) {
  const int code = sqlite3_step(statement);
  if (code == SQLITE_ROW) value = sqlite3_column_int64(statement, 0);
  sqlite3_reset(statement);
  return code == SQLITE_ROW ? Status{} : fault(code);
}

Status SqliteStore::connect(const char* path, int flags) {
  close();
  const int code = sqlite3_open_v2(path, &database_, flags, nullptr);
  if (code == SQLITE_OK) return {};
  const Status status = fault(code);
  close();
  return status;
}

Status SqliteStore::open(const char* path) {
  ILP_TRY(connect(path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE));
  // Another process may hold the write lock for the length of a transaction.
  sqlite3_busy_timeout(database_, 2000);
  Status status = check_schema(true);
  for (const char* setting : settings) {
    if (status.ok()) status = execute(setting);
  }
  if (status.ok()) status = create_schema();
  if (status.ok()) status = prepare_all();
  if (!status.ok()) {
    close();
    return status;
  }
  sqlite3_update_hook(
      database_,
      [](void* self, int operation, const char* database, const char* table, sqlite3_int64 row) {
        on_update(self, operation, database, table, row);
      },
      this);
  return {};
}

Status SqliteStore::open_read_only(const char* path) {
  ILP_TRY(connect(path, SQLITE_OPEN_READONLY));
  sqlite3_busy_timeout(database_, 2000);
  Status status = check_schema(false);
  if (status.ok()) status = prepare_all();
  if (!status.ok()) close();
  return status;
}

void SqliteStore::close() {
  const auto finish = [](sqlite3_stmt*& statement) {
    sqlite3_finalize(statement);
    statement = nullptr;
  };
  for (Statements& record : statements_) {
    for (sqlite3_stmt** statement :
         {&record.put, &record.get, &record.next, &record.last, &record.erase, &record.count}) {
      finish(*statement);
    }
    for (BlobStatements& blob : record.blobs) {
      finish(blob.create);
      finish(blob.erase);
      blob.field = nullptr;
    }
  }
  for (sqlite3_stmt** statement : {&begin_, &commit_, &rollback_, &data_version_, &page_count_, &free_count_}) {
    finish(*statement);
  }
  sqlite3_close(database_);
  database_ = nullptr;
  in_transaction_ = false;
  uncommitted_ = 0;
  changed_ = 0;
}

Status SqliteStore::check_schema(bool may_create) {
  sqlite3_stmt* statement = nullptr;
  std::int64_t version = 0;
  Status status = prepare("PRAGMA user_version", statement);
  if (status.ok()) status = integer_of(statement, version);
  sqlite3_finalize(statement);
  ILP_TRY(status);
  if (version == schema_fingerprint()) return {};
  std::int64_t tables = 0;
  statement = nullptr;
  status = prepare("SELECT count(*) FROM sqlite_master", statement);
  if (status.ok()) status = integer_of(statement, tables);
  sqlite3_finalize(statement);
  ILP_TRY(status);
  if (may_create && version == 0 && tables == 0) return {};
  return {StatusCode::store_schema, version, schema_fingerprint()};
}

Status SqliteStore::create_schema() {
  if (check_schema(false).ok()) return {};
  // One transaction: power may fail between any two instructions.
  ILP_TRY(execute("BEGIN IMMEDIATE"));
  Status status;
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count) && status.ok(); ++t) {
    const RecordInfo& info = record_info(static_cast<RecordType>(t));
    SqlText sql;
    create_table(info, sql);
    status = execute(sql.c_str());
    for (std::size_t f = 0; f < info.field_count && status.ok(); ++f) {
      if (info.fields[f].type != FieldType::blob) continue;
      SqlText blob_sql;
      create_blob_table(info, info.fields[f], blob_sql);
      status = execute(blob_sql.c_str());
    }
  }
  if (status.ok()) {
    FixedText<64> sql;
    sql.add("PRAGMA user_version=").add(std::int64_t{schema_fingerprint()});
    status = execute(sql.c_str());
  }
  if (status.ok()) status = execute("COMMIT");
  if (!status.ok()) static_cast<void>(execute("ROLLBACK"));
  return status;
}

Status SqliteStore::prepare_record(const RecordInfo& info) {
  Statements& s = statements_[static_cast<std::size_t>(info.type)];
  SqlText put_sql;
  SqlText get_sql;
  SqlText next_sql;
  SqlText last_sql;
  SqlText erase_sql;
  SqlText count_sql;
  insert_or_update(info, put_sql);
  select(info, "WHERE id=?", get_sql);
  select(info, "WHERE id>? ORDER BY id LIMIT 1", next_sql);
  select(info, "ORDER BY id DESC LIMIT 1", last_sql);
  erase_sql.add("DELETE FROM ").add(info.name).add(" WHERE id=?");
  count_sql.add("SELECT count(*) FROM ").add(info.name);
  ILP_ASSERT(!put_sql.overflow() && !get_sql.overflow(), static_cast<int>(info.type));
  ILP_TRY(prepare(put_sql.c_str(), s.put));
  ILP_TRY(prepare(get_sql.c_str(), s.get));
  ILP_TRY(prepare(next_sql.c_str(), s.next));
  ILP_TRY(prepare(last_sql.c_str(), s.last));
  ILP_TRY(prepare(erase_sql.c_str(), s.erase));
  ILP_TRY(prepare(count_sql.c_str(), s.count));
  std::size_t blobs = 0;
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    if (field.type != FieldType::blob) continue;
    ILP_ASSERT(blobs < max_blob_fields, blobs);
    BlobStatements& blob = s.blobs[blobs++];
    FixedText<96> table;
    blob_table_name(info, field, table);
    SqlText create_sql;
    SqlText drop_sql;
    create_sql.add("INSERT OR REPLACE INTO ").add(table.c_str()).add("(id, data) VALUES(?, zeroblob(?))");
    drop_sql.add("DELETE FROM ").add(table.c_str()).add(" WHERE id=?");
    blob.field = &field;
    ILP_TRY(prepare(create_sql.c_str(), blob.create));
    ILP_TRY(prepare(drop_sql.c_str(), blob.erase));
  }
  return {};
}

Status SqliteStore::prepare_all() {
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    ILP_TRY(prepare_record(record_info(static_cast<RecordType>(t))));
  }
  ILP_TRY(prepare("BEGIN IMMEDIATE", begin_));
  ILP_TRY(prepare("COMMIT", commit_));
  ILP_TRY(prepare("ROLLBACK", rollback_));
  ILP_TRY(prepare("PRAGMA data_version", data_version_));
  ILP_TRY(prepare("PRAGMA page_count", page_count_));
  ILP_TRY(prepare("PRAGMA freelist_count", free_count_));
  return integer_of(data_version_, seen_version_);
}

void SqliteStore::on_update(void* self, int operation, const char* database, const char* table, std::int64_t row) {
  static_cast<void>(operation);
  static_cast<void>(database);
  static_cast<void>(row);
  auto& store = *static_cast<SqliteStore*>(self);
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    const auto type = static_cast<RecordType>(t);
    if (std::strcmp(record_info(type).name, table) == 0) store.uncommitted_ |= mask_of(type);
  }
}

Status SqliteStore::begin() {
  if (database_ == nullptr || in_transaction_) return {StatusCode::invalid_argument, 1};
  ILP_TRY(run(begin_));
  in_transaction_ = true;
  uncommitted_ = 0;
  return {};
}

Status SqliteStore::commit() {
  if (!in_transaction_) return {StatusCode::invalid_argument, 1};
  const Status status = run(commit_);
  if (!status.ok()) {
    rollback();
    return status;
  }
  in_transaction_ = false;
  changed_ |= uncommitted_;
  uncommitted_ = 0;
  return {};
}

void SqliteStore::rollback() {
  if (!in_transaction_) return;
  in_transaction_ = false;
  uncommitted_ = 0;
  // SQLite may have rolled back by itself, on a full disk for one.
  if (sqlite3_get_autocommit(database_) == 0) static_cast<void>(run(rollback_));
}

Status SqliteStore::read_row(const RecordInfo& info, sqlite3_stmt* statement, void* record) {
  const int code = sqlite3_step(statement);
  Status status;
  if (code == SQLITE_ROW) {
    int column = 0;
    auto* to = static_cast<unsigned char*>(record);
    for (std::size_t f = 0; f < info.field_count; ++f) {
      const FieldInfo& field = info.fields[f];
      for (std::size_t i = 0; i < column_count(field); ++i) {
        read_element(statement, column++, field, to + field.offset + i * element_size(field));
      }
    }
  } else {
    status = code == SQLITE_DONE ? Status{StatusCode::not_found} : fault(code);
  }
  sqlite3_reset(statement);
  return status;
}

Status SqliteStore::get(const RecordInfo& info, std::int64_t id, void* record) {
  sqlite3_stmt* statement = statements_[static_cast<std::size_t>(info.type)].get;
  sqlite3_bind_int64(statement, 1, id);
  const Status status = read_row(info, statement, record);
  return status.is(StatusCode::not_found) ? Status{StatusCode::not_found, id} : status;
}

Status SqliteStore::next(const RecordInfo& info, std::int64_t after, void* record) {
  sqlite3_stmt* statement = statements_[static_cast<std::size_t>(info.type)].next;
  sqlite3_bind_int64(statement, 1, after);
  return read_row(info, statement, record);
}

Status SqliteStore::last(const RecordInfo& info, void* record) {
  return read_row(info, statements_[static_cast<std::size_t>(info.type)].last, record);
}

Status SqliteStore::count(const RecordInfo& info, std::int64_t& records) {
  return integer_of(statements_[static_cast<std::size_t>(info.type)].count, records);
}

Status SqliteStore::put_blobs(const RecordInfo& info, const void* record, std::int64_t id, bool existed,
                              const void* before) {
  for (const BlobStatements& blob : statements_[static_cast<std::size_t>(info.type)].blobs) {
    if (blob.field == nullptr) break;
    const std::uint32_t bytes = blob_bytes(record, *blob.field);
    const std::uint32_t bytes_before = existed ? blob_bytes(before, *blob.field) : 0;
    if (bytes == bytes_before) continue;
    sqlite3_stmt* statement = bytes == 0 ? blob.erase : blob.create;
    sqlite3_bind_int64(statement, 1, id);
    if (bytes != 0) sqlite3_bind_int64(statement, 2, bytes);
    ILP_TRY(run(statement));
  }
  return {};
}

Status SqliteStore::put(const RecordInfo& info, const void* record) {
  if (!in_transaction_) return {StatusCode::invalid_argument, 1};
  const Statements& s = statements_[static_cast<std::size_t>(info.type)];
  const std::int64_t id = id_of(record);
  if (s.blobs[0].field != nullptr) {
    alignas(8) unsigned char before[limits::max_record_bytes];
    const Status found = get(info, id, before);
    if (!found.ok() && !found.is(StatusCode::not_found)) return found;
    ILP_TRY(put_blobs(info, record, id, found.ok(), before));
  }
  int column = 1;
  const auto* from = static_cast<const unsigned char*>(record);
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    for (std::size_t i = 0; i < column_count(field); ++i) {
      bind_element(s.put, column++, field, from + field.offset + i * element_size(field));
    }
  }
  return run(s.put);
}

Status SqliteStore::erase(const RecordInfo& info, std::int64_t id) {
  if (!in_transaction_) return {StatusCode::invalid_argument, 1};
  const Statements& s = statements_[static_cast<std::size_t>(info.type)];
  for (const BlobStatements& blob : s.blobs) {
    if (blob.field == nullptr) break;
    sqlite3_bind_int64(blob.erase, 1, id);
    ILP_TRY(run(blob.erase));
  }
  sqlite3_bind_int64(s.erase, 1, id);
  ILP_TRY(run(s.erase));
  return sqlite3_changes(database_) > 0 ? Status{} : Status{StatusCode::not_found, id};
}

Status SqliteStore::open_blob(const RecordInfo& info, const char* field, std::int64_t id, bool writable,
                              std::size_t offset, std::size_t bytes, sqlite3_blob*& blob) {
  const FieldInfo* found = find_blob_field(info, field);
  if (found == nullptr) return {StatusCode::invalid_argument, 2};
  FixedText<96> table;
  blob_table_name(info, *found, table);
  const int code = sqlite3_blob_open(database_, "main", table.c_str(), "data", id, writable ? 1 : 0, &blob);
  if (code != SQLITE_OK) {
    const Status status = fault(code);
    sqlite3_blob_close(blob);
    blob = nullptr;
    // SQLite answers a missing row with its general error.
    return code == SQLITE_ERROR ? Status{StatusCode::not_found, id} : status;
  }
  const auto size = static_cast<std::size_t>(sqlite3_blob_bytes(blob));
  if (offset > size || bytes > size - offset) {
    sqlite3_blob_close(blob);
    blob = nullptr;
    return {StatusCode::invalid_argument, 3, static_cast<std::int64_t>(size)};
  }
  return {};
}

Status SqliteStore::write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                               std::span<const std::uint8_t> bytes) {
  if (!in_transaction_) return {StatusCode::invalid_argument, 1};
  sqlite3_blob* blob = nullptr;
  ILP_TRY(open_blob(info, field, id, true, offset, bytes.size(), blob));
  const int code = sqlite3_blob_write(blob, bytes.data(), static_cast<int>(bytes.size()), static_cast<int>(offset));
  const int closed = sqlite3_blob_close(blob);
  if (code != SQLITE_OK) return fault(code);
  return closed == SQLITE_OK ? Status{} : fault(closed);
}

Status SqliteStore::read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                              std::span<std::uint8_t> bytes) {
  sqlite3_blob* blob = nullptr;
  ILP_TRY(open_blob(info, field, id, false, offset, bytes.size(), blob));
  const int code = sqlite3_blob_read(blob, bytes.data(), static_cast<int>(bytes.size()), static_cast<int>(offset));
  sqlite3_blob_close(blob);
  return code == SQLITE_OK ? Status{} : fault(code);
}

Status SqliteStore::poll(RecordMask& changed) {
  std::int64_t version = 0;
  ILP_TRY(integer_of(data_version_, version));
  changed = changed_;
  changed_ = 0;
  // Another process has written: which table is not told, so all of them.
  if (version != seen_version_) changed = ~RecordMask{0};
  seen_version_ = version;
  return {};
}

StoreUsage SqliteStore::usage() {
  StoreUsage result;
  std::int64_t pages = 0;
  std::int64_t free_pages = 0;
  if (database_ == nullptr || !integer_of(page_count_, pages).ok() || !integer_of(free_count_, free_pages).ok())
    return result;
  result.bytes = pages * page_bytes_;
  result.free_bytes = free_pages * page_bytes_;
  return result;
}

}  // namespace ilp
