#include "hal/store/sqlite/session.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <cstring>
#include <ctime>

#include "fsw/base/argument.hpp"
#include "hal/store/sql_columns.hpp"
#include "hal/store/sqlite/checked_vfs.hpp"
#include "hal/store/sqlite/disk_file.hpp"
#include "hal/store/sqlite/log_mark.hpp"
#include "hal/store/sqlite/page_checksum.hpp"
#include "hal/store/sqlite/reserve.hpp"
#include "hal/store/sqlite/sql_text.hpp"
#include "hal/store/sqlite/sqlite_memory.hpp"

namespace ilp::sqlite {
namespace {

// Pages kept in memory; with the statements and a large blob's handle this fits the arena of the flight profile.
constexpr const char* settings[] = {
    "PRAGMA page_size=4096",     "PRAGMA journal_mode=WAL", "PRAGMA synchronous=FULL",
    "PRAGMA cache_size=-3072",   "PRAGMA cache_spill=ON",   "PRAGMA journal_size_limit=8388608",
    "PRAGMA temp_store=MEMORY",  "PRAGMA mmap_size=0",      "PRAGMA foreign_keys=OFF",
    "PRAGMA trusted_schema=OFF",
};

using UriText = FixedText<3 * limits::max_path_bytes + 32>;

void unchanging_file(const char* path, UriText& uri) {
  constexpr char digits[] = "0123456789ABCDEF";
  uri.add(*path == '/' ? "file://" : "file:");
  for (const char* c = path; *c != 0; ++c) {
    if (*c != '%' && *c != '?' && *c != '#') {
      uri.add(*c);
      continue;
    }
    const auto octet = static_cast<unsigned char>(*c);
    uri.add('%').add(digits[octet >> 4U]).add(digits[octet & 15U]);
  }
  uri.add("?immutable=1");
}

/// A log that another process is writing may look damaged for a moment.
Status check_log_at_rest(const char* path) {
  Status log = check_log(path);
  for (int again = 0; again < 3 && !log.ok(); ++again) {
    sqlite3_sleep(20);
    log = check_log(path);
  }
  return log;
}

/// Another process may hold the write lock for the length of a transaction, most often for less than a millisecond.
/// SQLite's own waits grow to 100 ms, which is a step of many others.
constexpr int lock_nap_us = 100;

constexpr std::int64_t ns_per_millisecond = 1'000'000;

std::int64_t monotonic_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

Status connect(Session& s, const char* path, int flags) {
  close(s);
  s.refused_at_open = refused_reads();
  s.log.full_at_look = writes_without_capacity();
  int code = register_checked_vfs();
  if (code == SQLITE_OK) code = sqlite3_open_v2(path, &s.database, flags, checked_vfs);
  if (code == SQLITE_OK) code = sqlite3_busy_handler(s.database, on_busy, &s.lock);
  if (code == SQLITE_OK) return {};
  const Status status = fault(s, code);
  close(s);
  return status;
}

Status check_schema(Session& s, bool may_create) {
  sqlite3_stmt* statement = nullptr;
  std::int64_t version = 0;
  Status status = prepare(s, "PRAGMA user_version", statement);
  if (status.ok()) status = integer_of(s, statement, version);
  sqlite3_finalize(statement);
  ILP_TRY(status);
  if (version == schema_fingerprint()) return {};
  std::int64_t tables = 0;
  statement = nullptr;
  status = prepare(s, "SELECT count(*) FROM sqlite_master", statement);
  if (status.ok()) status = integer_of(s, statement, tables);
  sqlite3_finalize(statement);
  ILP_TRY(status);
  if (may_create && version == 0 && tables == 0) return {};
  return {StatusCode::store_schema, version, schema_fingerprint()};
}

Status check_database(Session& s, bool may_create) {
  int checked = 0;
  int code = sqlite3_file_control(s.database, "main", fcntl_pages_are_checked, &checked);
  // A new database reserves room for its checksums at the end of each page. A database without that room is not ours.
  int reserved = static_cast<int>(page_checksum_bytes);
  if (code == SQLITE_OK && checked != 0) {
    code = sqlite3_file_control(s.database, "main", SQLITE_FCNTL_RESERVE_BYTES, &reserved);
  }
  if (code != SQLITE_OK) return fault(s, code);
  ILP_TRY(check_schema(s, may_create));
  return checked != 0 ? Status{} : Status{StatusCode::store_schema, 0, schema_fingerprint()};
}

Status create_schema(Session& s) {
  if (check_schema(s, false).ok()) return {};
  // One transaction: power may fail between any two instructions.
  ILP_TRY(execute(s, "BEGIN IMMEDIATE"));
  Status status;
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count) && status.ok(); ++t) {
    const RecordInfo& info = record_info(static_cast<RecordType>(t));
    SqlText sql;
    create_table(info, sql);
    status = execute(s, sql.c_str());
    for_each_blob(info, [&](const FieldInfo& field, std::size_t) {
      SqlText blob_sql;
      add_blob_table("CREATE TABLE ", info, field, "(\"id\" INTEGER PRIMARY KEY, \"checksums\" BLOB, \"data\" BLOB)",
                     blob_sql);
      if (status.ok()) status = execute(s, blob_sql.c_str());
    });
  }
  if (status.ok()) {
    FixedText<64> sql;
    sql.add("PRAGMA user_version=").add(std::int64_t{schema_fingerprint()});
    status = execute(s, sql.c_str());
  }
  if (status.ok()) status = execute(s, "COMMIT");
  if (!status.ok()) static_cast<void>(execute(s, "ROLLBACK"));
  return status;
}

Status prepare_record(Session& s, const RecordInfo& info) {
  RecordStatements& record = s.statements.records[static_cast<std::size_t>(info.type)];
  // One text after the other, so that the stack holds one of them.
  SqlText sql;
  const auto prepare_text = [&](sqlite3_stmt*& statement) -> Status {
    ILP_ASSERT(!sql.overflow(), static_cast<int>(info.type));
    const Status status = prepare(s, sql.c_str(), statement);
    sql.clear();
    return status;
  };
  insert_or_update(info, sql);
  ILP_TRY(prepare_text(record.put));
  select(info, "WHERE id=?", sql);
  ILP_TRY(prepare_text(record.get));
  select(info, "WHERE id>? ORDER BY id LIMIT 1", sql);
  ILP_TRY(prepare_text(record.next));
  select(info, "ORDER BY id DESC LIMIT 1", sql);
  ILP_TRY(prepare_text(record.last));
  sql.add("DELETE FROM \"").add(info.name).add("\" WHERE id=?");
  ILP_TRY(prepare_text(record.erase));
  sql.add("SELECT count(*) FROM \"").add(info.name).add("\"");
  ILP_TRY(prepare_text(record.count));
  Status status;
  for_each_blob(info, [&](const FieldInfo& field, std::size_t index) {
    add_blob_table("SELECT length(data) FROM ", info, field, " WHERE id=?", sql);
    if (status.ok()) status = prepare_text(record.blobs[index].size);
    // Id, bytes of the checksums, bytes of the data.
    add_blob_table("INSERT OR REPLACE INTO ", info, field, "(id, checksums, data) VALUES(?, zeroblob(?), zeroblob(?))",
                   sql);
    if (status.ok()) status = prepare_text(record.blobs[index].create);
    add_blob_table("DELETE FROM ", info, field, " WHERE id=?", sql);
    if (status.ok()) status = prepare_text(record.blobs[index].erase);
  });
  return status;
}

Status prepare_all(Session& s) {
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    ILP_TRY(prepare_record(s, record_info(static_cast<RecordType>(t))));
  }
  ILP_TRY(prepare(s, "BEGIN IMMEDIATE", s.statements.begin));
  ILP_TRY(prepare(s, "COMMIT", s.statements.commit));
  ILP_TRY(prepare(s, "ROLLBACK", s.statements.rollback));
  ILP_TRY(prepare(s, "PRAGMA data_version", s.statements.data_version));
  ILP_TRY(prepare(s, "PRAGMA page_count", s.statements.page_count));
  ILP_TRY(prepare(s, "PRAGMA freelist_count", s.statements.free_count));
  static_cast<void>(usage(s));
  return integer_of(s, s.statements.data_version, s.seen_version);
}

Status connect_read_only(Session& s, const char* path, bool valid) {
  FixedText<limits::max_path_bytes> log;
  log.add(path).add("-wal");
  if (log.overflow()) return {StatusCode::capacity_exceeded, 0, limits::max_path_bytes};
  ILP_TAKE(const bool log_exists, look_for(log.c_str()));
  // SQLite opens the log of every database that has one, and makes it if there is none, unless it is told that there is
  // no writer.
  UriText uri;
  if (!log_exists) unchanging_file(path, uri);
  const bool alone = !log_exists && !uri.overflow();
  ILP_TRY(connect(s, alone ? uri.c_str() : path, SQLITE_OPEN_READONLY | (alone ? SQLITE_OPEN_URI : 0)));
  Status status = valid ? check_database(s, false) : Status{};
  if (status.ok()) status = prepare_all(s);
  if (!status.ok()) close(s);
  return status;
}

}  // namespace

int on_busy(void* lock, int attempt) {
  auto& wait = *static_cast<LockWait*>(lock);
  const std::int64_t now = monotonic_ns();
  if (attempt == 0) wait.waits_since_ns = now;
  if (wait.taken_since_ns != 0 || now - wait.waits_since_ns >= wait.longest_wait_ns) return 0;
  sqlite3_vfs* disk = sqlite3_vfs_find(nullptr);
  disk->xSleep(disk, lock_nap_us);
  return 1;
}

Status fault(Session& s, int code) {
  const int extended = s.database != nullptr ? sqlite3_extended_errcode(s.database) : code;
  // If the schema could not be read SQLite reports general errors.
  if ((code == SQLITE_ERROR || code == SQLITE_IOERR) && damaged(s)) return {StatusCode::store_damaged, code, extended};
  switch (code & 0xFF) {
    case SQLITE_NOMEM:
      return {StatusCode::arena_exhausted, sqlite_arena_number, refused_sqlite_bytes()};
    case SQLITE_FULL:
      return {StatusCode::store_full, s.known_bytes, s.limit_bytes > 0 ? s.limit_bytes : s.known_bytes};
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      s.damaged = true;
      return {StatusCode::store_damaged, code, extended};
    case SQLITE_IOERR:
      if (extended == SQLITE_IOERR_DATA) {
        s.damaged = true;
        return {StatusCode::store_damaged, code, extended};
      }
      // There is no room for the index of the log, which is a file of its own.
      if (extended == SQLITE_IOERR_SHMSIZE) return {StatusCode::store_full, s.known_bytes, s.known_bytes};
      return {StatusCode::store_error, code, extended};
    case SQLITE_BUSY:
      return {StatusCode::store_locked, locked_ms(s)};
    default:
      return {StatusCode::store_error, code, extended};
  }
}

bool damaged(const Session& s) {
  return s.damaged || (s.database != nullptr && refused_reads() != s.refused_at_open);
}

Status execute(Session& s, const char* sql) {
  const int code = sqlite3_exec(s.database, sql, nullptr, nullptr, nullptr);
  return code == SQLITE_OK ? Status{} : fault(s, code);
}

Status prepare(Session& s, const char* sql, sqlite3_stmt*& statement) {
  const int code = sqlite3_prepare_v3(s.database, sql, -1, SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
  return code == SQLITE_OK ? Status{} : fault(s, code);
}

Status run(Session& s, sqlite3_stmt* statement) {
  const int code = sqlite3_step(statement);
  const Status status = code == SQLITE_DONE || code == SQLITE_ROW ? Status{} : fault(s, code);
  sqlite3_reset(statement);
  sqlite3_clear_bindings(statement);
  return status;
}

Status integer_of(Session& s, sqlite3_stmt* statement, std::int64_t& value) {
  const int code = sqlite3_step(statement);
  if (code == SQLITE_ROW) value = sqlite3_column_int64(statement, 0);
  sqlite3_reset(statement);
  return code == SQLITE_ROW ? Status{} : fault(s, code);
}

Status open(Session& s, const char* path) {
  ILP_TRY(check_log_at_rest(path));
  ILP_TRY(connect(s, path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE));
  Status status = check_database(s, true);
  if (status.ok() && sqlite3_db_readonly(s.database, "main") != 0) status = {StatusCode::store_error, SQLITE_READONLY};
  for (const char* setting : settings) {
    if (status.ok()) status = execute(s, setting);
  }
  sqlite3_wal_hook(s.database, note_commit, &s.log.bytes);
  if (status.ok()) status = create_schema(s);
  if (status.ok()) status = prepare_all(s);
  if (!status.ok()) {
    close(s);
    return status;
  }
  return {};
}

Status check(Session& s) {
  if (s.database == nullptr) return out_of_range(Argument::database);
  sqlite3_stmt* statement = nullptr;
  const std::int64_t failed_before = failed_reads();
  ILP_TRY(prepare(s, "PRAGMA quick_check(1)", statement));
  const int code = sqlite3_step(statement);
  const auto* const verdict = code == SQLITE_ROW ? sqlite3_column_text(statement, 0) : nullptr;
  const bool valid = verdict != nullptr && std::strcmp(reinterpret_cast<const char*>(verdict), "ok") == 0;
  const Status status = code == SQLITE_ROW ? Status{} : fault(s, code);
  sqlite3_finalize(statement);
  ILP_TRY(status);
  // What could not be read has a place in its list of damage too.
  if (!valid && failed_reads() != failed_before) return {StatusCode::store_error, SQLITE_IOERR, SQLITE_IOERR_READ};
  return valid ? Status{} : fault(s, SQLITE_CORRUPT);
}

Status open_read_only(Session& s, const char* path) {
  ILP_TRY(check_log_at_rest(path));
  return connect_read_only(s, path, true);
}

Status open_damaged(Session& s, const char* path, std::int64_t cache_kib) {
  ILP_TRY(connect_read_only(s, path, false));
  return use_cache(s, cache_kib);
}

Status use_cache(Session& s, std::int64_t kib) {
  FixedText<64> sql;
  sql.add("PRAGMA cache_size=").add(-kib);
  return execute(s, sql.c_str());
}

void close(Session& s) {
  while (s.database != nullptr) {  // bound: the statements that were prepared
    sqlite3_stmt* const statement = sqlite3_next_stmt(s.database, nullptr);
    if (statement == nullptr) break;
    sqlite3_finalize(statement);
  }
  s.statements = {};
  FixedText<limits::max_path_bytes> path;
  const char* const name =
      s.database != nullptr && s.log.reserve_bytes > 0 ? sqlite3_db_filename(s.database, "main") : nullptr;
  if (name != nullptr) path.add(name);
  sqlite3_close(s.database);
  s.database = nullptr;
  // The last one has copied the log and removed it.
  FixedText<limits::max_path_bytes> log;
  log.add(path.c_str()).add(log_suffix);
  if (path.size() > 0 && !log.overflow()) {
    const Result<bool> log_exists = look_for(log.c_str());
    if (log_exists.ok() && !log_exists.value()) release_reserve(path.c_str());
  }
  s.lock_file.close();
  s.lock = {};
  s.transaction = {};
  s.log = {};
  s.damaged = false;
  s.limit_bytes = 0;
  s.changed = 0;
}

std::int64_t locked_ms(const Session& s) {
  if (s.lock.taken_since_ns == 0) return 0;
  return std::max<std::int64_t>((monotonic_ns() - s.lock.taken_since_ns) / ns_per_millisecond, 1);
}

int lock_holder(Session& s) {
  return s.database == nullptr ? 0 : s.lock_file.holder(sqlite3_db_filename(s.database, "main"));
}

StoreUsage usage(Session& s) {
  std::int64_t pages = 0;
  std::int64_t free_pages = 0;
  if (s.database == nullptr || !integer_of(s, s.statements.page_count, pages).ok() ||
      !integer_of(s, s.statements.free_count, free_pages).ok()) {
    return {s.known_bytes, 0, s.limit_bytes};
  }
  constexpr auto bytes = static_cast<std::int64_t>(page_bytes);
  s.known_bytes = pages * bytes;
  return {s.known_bytes, free_pages * bytes, s.limit_bytes};
}

}  // namespace ilp::sqlite
