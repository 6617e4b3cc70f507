#include "hal/store/sqlite/sqlite_store.hpp"

#include <sqlite3.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <utility>

#include "fsw/base/argument.hpp"
#include "hal/store/checksums.hpp"
#include "hal/store/record_bytes.hpp"
#include "hal/store/sql_columns.hpp"
#include "hal/store/sqlite/checked_vfs.hpp"
#include "hal/store/sqlite/columns.hpp"
#include "hal/store/sqlite/disk_file.hpp"
#include "hal/store/sqlite/log_mark.hpp"
#include "hal/store/sqlite/page_checksum.hpp"
#include "hal/store/sqlite/reserve.hpp"
#include "hal/store/sqlite/sql_text.hpp"
#include "hal/store/sqlite/sqlite_memory.hpp"

namespace ilp {
namespace {

// Pages kept in memory; with the statements and a large blob's handle this fits the arena of the flight profile.
constexpr const char* settings[] = {
    "PRAGMA page_size=4096",     "PRAGMA journal_mode=WAL", "PRAGMA synchronous=FULL",
    "PRAGMA cache_size=-3072",   "PRAGMA cache_spill=ON",   "PRAGMA journal_size_limit=8388608",
    "PRAGMA temp_store=MEMORY",  "PRAGMA mmap_size=0",      "PRAGMA foreign_keys=OFF",
    "PRAGMA trusted_schema=OFF",
};

/// The log is copied when it has so many frames: a commit that does it takes little longer than the others.
constexpr int frames_to_copy = 250;

/// Half of it is more than a log has that nobody holds, on any disk.
constexpr std::int64_t least_log_room = 4 * frames_to_copy * static_cast<std::int64_t>(frame_bytes);

/// SQLite calls it after every commit. If copying fails it is tried again after the next one.
int note_commit(void* log_bytes, sqlite3* database, const char* name, int frames) {
  *static_cast<std::int64_t*>(log_bytes) = std::int64_t{frames} * static_cast<std::int64_t>(frame_bytes);
  if (frames >= frames_to_copy) static_cast<void>(sqlite3_wal_checkpoint(database, name));
  return SQLITE_OK;
}

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

}  // namespace

/// SQLite calls it while another connection has a lock; `attempt` counts from 0 for each lock. 0 gives up.
int SqliteStore::wait_for_lock(void* lock, int attempt) {
  auto& wait = *static_cast<LockWait*>(lock);
  const std::int64_t now = monotonic_ns();
  if (attempt == 0) wait.waits_since_ns = now;
  if (wait.taken_since_ns != 0 || now - wait.waits_since_ns >= wait.longest_wait_ns) return 0;
  sqlite3_vfs* disk = sqlite3_vfs_find(nullptr);
  disk->xSleep(disk, lock_nap_us);
  return 1;
}

SqliteStore::~SqliteStore() {
  close();
}

Status SqliteStore::fault(int code) {
  const int extended = database_ != nullptr ? sqlite3_extended_errcode(database_) : code;
  // If the schema could not be read SQLite reports general errors.
  if ((code == SQLITE_ERROR || code == SQLITE_IOERR) && damaged()) return {StatusCode::store_damaged, code, extended};
  switch (code & 0xFF) {
    case SQLITE_NOMEM:
      return {StatusCode::arena_exhausted, sqlite_arena_number, refused_sqlite_bytes()};
    case SQLITE_FULL:
      return {StatusCode::store_full, known_bytes_, limit_bytes_ > 0 ? limit_bytes_ : known_bytes_};
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      damaged_ = true;
      return {StatusCode::store_damaged, code, extended};
    case SQLITE_IOERR:
      if (extended == SQLITE_IOERR_DATA) {
        damaged_ = true;
        return {StatusCode::store_damaged, code, extended};
      }
      // There is no room for the index of the log, which is a file of its own.
      if (extended == SQLITE_IOERR_SHMSIZE) return {StatusCode::store_full, known_bytes_, known_bytes_};
      return {StatusCode::store_error, code, extended};
    case SQLITE_BUSY:
      return {StatusCode::store_locked, locked_ms()};
    default:
      return {StatusCode::store_error, code, extended};
  }
}

bool SqliteStore::damaged() const {
  return damaged_ || (database_ != nullptr && refused_reads() != refused_at_open_);
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
  refused_at_open_ = refused_reads();
  full_at_look_ = writes_without_room();
  int code = register_checked_vfs();
  if (code == SQLITE_OK) code = sqlite3_open_v2(path, &database_, flags, checked_vfs);
  if (code == SQLITE_OK) return {};
  const Status status = fault(code);
  close();
  return status;
}

Status SqliteStore::check_database(bool may_create) {
  int checked = 0;
  int code = sqlite3_file_control(database_, "main", fcntl_pages_are_checked, &checked);
  // A new database reserves room for its checksums at the end of each page. A database without that room is not ours.
  int reserved = static_cast<int>(page_checksum_bytes);
  if (code == SQLITE_OK && checked != 0) {
    code = sqlite3_file_control(database_, "main", SQLITE_FCNTL_RESERVE_BYTES, &reserved);
  }
  if (code != SQLITE_OK) return fault(code);
  ILP_TRY(check_schema(may_create));
  return checked != 0 ? Status{} : Status{StatusCode::store_schema, 0, schema_fingerprint()};
}

Status SqliteStore::open(const char* path) {
  ILP_TRY(check_log_at_rest(path));
  ILP_TRY(connect(path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE));
  sqlite3_busy_handler(database_, wait_for_lock, &lock_);
  Status status = check_database(true);
  if (status.ok() && sqlite3_db_readonly(database_, "main") != 0) status = {StatusCode::store_error, SQLITE_READONLY};
  for (const char* setting : settings) {
    if (status.ok()) status = execute(setting);
  }
  sqlite3_wal_hook(database_, note_commit, &log_bytes_);
  if (status.ok()) status = create_schema();
  if (status.ok()) status = prepare_all();
  if (!status.ok()) {
    close();
    return status;
  }
  return {};
}

Status SqliteStore::limit(std::int64_t bytes) {
  if (database_ == nullptr || bytes <= 0) return out_of_range(Argument::capacity, bytes);
  static_cast<void>(usage());
  limit_bytes_ = bytes;
  const char* const path = sqlite3_db_filename(database_, "main");
  struct statvfs disk {};
  if (path != nullptr && *path != 0 && statvfs(path, &disk) == 0) {
    const std::int64_t room = known_bytes_ + reserved_bytes(path) +
                              static_cast<std::int64_t>(disk.f_bavail) * static_cast<std::int64_t>(disk.f_frsize);
    const std::int64_t log = std::min(room / 2, 2 * sqlite_log_bytes);
    if (limit_bytes_ > room - log) limit_bytes_ = room - log;
    // One half is for the log, and the other one for copying it.
    reserve_bytes_ = log / 2;
    log_room_ = std::max(reserve_bytes_, least_log_room);
  }
  return mind_reserve();
}

Status SqliteStore::check() {
  if (database_ == nullptr) return out_of_range(Argument::database);
  sqlite3_stmt* statement = nullptr;
  const std::int64_t failed_before = failed_reads();
  ILP_TRY(prepare("PRAGMA quick_check(1)", statement));
  const int code = sqlite3_step(statement);
  const auto* const verdict = code == SQLITE_ROW ? sqlite3_column_text(statement, 0) : nullptr;
  const bool sound = verdict != nullptr && std::strcmp(reinterpret_cast<const char*>(verdict), "ok") == 0;
  const Status status = code == SQLITE_ROW ? Status{} : fault(code);
  sqlite3_finalize(statement);
  ILP_TRY(status);
  // What could not be read has a place in its list of damage too.
  if (!sound && failed_reads() != failed_before) return {StatusCode::store_error, SQLITE_IOERR, SQLITE_IOERR_READ};
  return sound ? Status{} : fault(SQLITE_CORRUPT);
}

Status SqliteStore::open_read_only(const char* path) {
  ILP_TRY(check_log_at_rest(path));
  return connect_read_only(path, true);
}

Status SqliteStore::open_damaged(const char* path, std::int64_t cache_kib) {
  ILP_TRY(connect_read_only(path, false));
  return use_cache(cache_kib);
}

Status SqliteStore::use_cache(std::int64_t kib) {
  FixedText<64> sql;
  sql.add("PRAGMA cache_size=").add(-kib);
  return execute(sql.c_str());
}

Status SqliteStore::connect_read_only(const char* path, bool sound) {
  FixedText<limits::max_path_bytes> log;
  log.add(path).add("-wal");
  if (log.overflow()) return {StatusCode::capacity_exceeded, 0, limits::max_path_bytes};
  ILP_TAKE(const bool log_exists, look_for(log.c_str()));
  // SQLite opens the log of every database that has one, and makes it if there is none, unless it is told that there is
  // no writer.
  UriText uri;
  if (!log_exists) unchanging_file(path, uri);
  const bool alone = !log_exists && !uri.overflow();
  ILP_TRY(connect(alone ? uri.c_str() : path, SQLITE_OPEN_READONLY | (alone ? SQLITE_OPEN_URI : 0)));
  sqlite3_busy_handler(database_, wait_for_lock, &lock_);
  Status status = sound ? check_database(false) : Status{};
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
         {&record.put, &record.get, &record.next, &record.last, &record.previous, &record.erase, &record.count}) {
      finish(*statement);
    }
    for (BlobStatements& blob : record.blobs) {
      finish(blob.size);
      finish(blob.create);
      finish(blob.erase);
    }
  }
  for (sqlite3_stmt** statement : {&begin_, &commit_, &rollback_, &data_version_, &page_count_, &free_count_}) {
    finish(*statement);
  }
  FixedText<limits::max_path_bytes> path;
  const char* const name =
      database_ != nullptr && reserve_bytes_ > 0 ? sqlite3_db_filename(database_, "main") : nullptr;
  if (name != nullptr) path.add(name);
  sqlite3_close(database_);
  database_ = nullptr;
  // The last one has copied the log and removed it.
  FixedText<limits::max_path_bytes> log;
  log.add(path.c_str()).add(log_suffix);
  if (path.size() > 0 && !log.overflow()) {
    const Result<bool> log_exists = look_for(log.c_str());
    if (log_exists.ok() && !log_exists.value()) give_up_reserve(path.c_str());
  }
  limit_bytes_ = reserve_bytes_ = log_bytes_ = held_log_bytes_ = 0;
  log_room_ = sqlite_log_bytes;
  disk_is_full_ = false;
  news_ = {};
  lock_file_.close();
  lock_ = {};
  damaged_ = false;
  synchronise_ = Synchronise::in_commit;
  unsynchronised_ = synchronising_failed_ = false;
  flushed_version_ = -1;
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
    for_each_blob(info, [&](const FieldInfo& field, std::size_t) {
      SqlText blob_sql;
      add_blob_table("CREATE TABLE ", info, field, "(\"id\" INTEGER PRIMARY KEY, \"checksums\" BLOB, \"data\" BLOB)",
                     blob_sql);
      if (status.ok()) status = execute(blob_sql.c_str());
    });
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
  // One text after the other, so that the stack holds one of them.
  SqlText sql;
  const auto prepare_text = [&](sqlite3_stmt*& statement) -> Status {
    ILP_ASSERT(!sql.overflow(), static_cast<int>(info.type));
    const Status status = prepare(sql.c_str(), statement);
    sql.clear();
    return status;
  };
  insert_or_update(info, sql);
  ILP_TRY(prepare_text(s.put));
  select(info, "WHERE id=?", sql);
  ILP_TRY(prepare_text(s.get));
  select(info, "WHERE id>? ORDER BY id LIMIT 1", sql);
  ILP_TRY(prepare_text(s.next));
  select(info, "ORDER BY id DESC LIMIT 1", sql);
  ILP_TRY(prepare_text(s.last));
  sql.add("DELETE FROM \"").add(info.name).add("\" WHERE id=?");
  ILP_TRY(prepare_text(s.erase));
  sql.add("SELECT count(*) FROM \"").add(info.name).add("\"");
  ILP_TRY(prepare_text(s.count));
  Status status;
  for_each_blob(info, [&](const FieldInfo& field, std::size_t index) {
    add_blob_table("SELECT length(data) FROM ", info, field, " WHERE id=?", sql);
    if (status.ok()) status = prepare_text(s.blobs[index].size);
    // Id, bytes of the checksums, bytes of the data.
    add_blob_table("INSERT OR REPLACE INTO ", info, field, "(id, checksums, data) VALUES(?, zeroblob(?), zeroblob(?))",
                   sql);
    if (status.ok()) status = prepare_text(s.blobs[index].create);
    add_blob_table("DELETE FROM ", info, field, " WHERE id=?", sql);
    if (status.ok()) status = prepare_text(s.blobs[index].erase);
  });
  return status;
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
  sqlite3_stmt* page_size = nullptr;
  Status status = prepare("PRAGMA page_size", page_size);
  if (status.ok()) status = integer_of(page_size, page_bytes_);
  sqlite3_finalize(page_size);
  ILP_TRY(status);
  static_cast<void>(usage());
  return integer_of(data_version_, seen_version_);
}

Status SqliteStore::take_news() {
  return std::exchange(news_, Status{});
}

/// Before every transaction.
Status SqliteStore::make_room() {
  const char* const path = sqlite3_db_filename(database_, "main");
  const bool full = disk_is_full_ || writes_without_room() != full_at_look_ ||
                    (reserve_bytes_ > 0 && path != nullptr && reserved_bytes(path) < reserve_bytes_);
  const bool is_long = 2 * log_bytes_ > log_room_;
  // Another process has started it over if it is shorter.
  if (!is_long || log_bytes_ < held_log_bytes_) held_log_bytes_ = 0;
  // A try writes all that was copied to the disk: while the log has room, only after it has grown.
  const bool was_tried =
      held_log_bytes_ > 0 && log_bytes_ <= log_room_ && log_bytes_ - held_log_bytes_ < log_room_ / 32;
  Status status;
  if ((is_long && !was_tried) || (full && log_bytes_ > 0)) status = start_log_over();
  if (full || writes_without_room() != full_at_look_) ILP_TRY(mind_reserve());
  return log_bytes_ > log_room_ ? status : Status{};
}

/// The room that the log has on the disk is then used again.
Status SqliteStore::start_log_over() {
  int frames = 0, copied = -1;
  // It does not wait for readers, which may stay for long.
  sqlite3_busy_handler(database_, nullptr, nullptr);
  const int code = sqlite3_wal_checkpoint_v2(database_, nullptr, SQLITE_CHECKPOINT_RESTART, &frames, &copied);
  sqlite3_busy_handler(database_, wait_for_lock, &lock_);
  if (code == SQLITE_OK) {
    log_bytes_ = held_log_bytes_ = 0;
    return {};
  }
  if (code != SQLITE_BUSY) return fault(code);
  // Another process writes, or copies it itself.
  if (copied < 0 || copied == frames) return {};
  if (2 * log_bytes_ > log_room_) {
    if (held_log_bytes_ == 0) news_ = {StatusCode::store_log_held, log_bytes_, log_room_};
    held_log_bytes_ = log_bytes_;
  }
  return {StatusCode::store_full, log_bytes_, log_room_};
}

/// Makes the reserve again when there is room for it. Without it the database does not grow: the log may need all there
/// is.
Status SqliteStore::mind_reserve() {
  full_at_look_ = writes_without_room();
  const char* const path = sqlite3_db_filename(database_, "main");
  const Status made = reserve_bytes_ > 0 && path != nullptr ? make_reserve(path, reserve_bytes_) : Status{};
  disk_is_full_ = made.is(StatusCode::store_full);
  if (!made.ok() && !disk_is_full_) reserve_bytes_ = 0;
  return limit_bytes_ > 0 ? limit_pages(disk_is_full_ ? usage().bytes : limit_bytes_) : Status{};
}

Status SqliteStore::limit_pages(std::int64_t bytes) {
  FixedText<64> sql;
  sql.add("PRAGMA max_page_count=").add(std::max<std::int64_t>((bytes + page_bytes_ - 1) / page_bytes_, 1));
  return execute(sql.c_str());
}

Status SqliteStore::begin() {
  if (database_ == nullptr || in_transaction_) return out_of_range(Argument::database);
  ILP_TRY(make_room());
  const Status begun = run(begin_);
  if (!begun.is(StatusCode::store_locked)) lock_.taken_since_ns = 0;
  if (begun.is(StatusCode::store_locked) && lock_.taken_since_ns == 0) {
    lock_.taken_since_ns = lock_.waits_since_ns;
    return {StatusCode::store_locked, locked_ms()};
  }
  ILP_TRY(begun);
  in_transaction_ = true;
  doomed_ = {};
  uncommitted_ = 0;
  return {};
}

std::int64_t SqliteStore::locked_ms() const {
  if (lock_.taken_since_ns == 0) return 0;
  return std::max<std::int64_t>((monotonic_ns() - lock_.taken_since_ns) / ns_per_millisecond, 1);
}

int SqliteStore::lock_holder() {
  return database_ == nullptr ? 0 : lock_file_.holder(sqlite3_db_filename(database_, "main"));
}

Status SqliteStore::commit() {
  Status status = writable();
  if (status.ok()) status = run(commit_);
  if (!status.ok()) {
    rollback();
    return status;
  }
  in_transaction_ = false;
  changed_ |= uncommitted_;
  unsynchronised_ = unsynchronised_ || uncommitted_ != 0;
  // The commit is done. If this fails, it is for flush() to say so.
  if (synchronise_ == Synchronise::behind_commit && uncommitted_ != 0) static_cast<void>(flush());
  uncommitted_ = 0;
  return {};
}

void SqliteStore::rollback() {
  if (!in_transaction_) return;
  in_transaction_ = false;
  uncommitted_ = 0;
  if (sqlite3_get_autocommit(database_) == 0) static_cast<void>(run(rollback_));
}

Status SqliteStore::writable() {
  if (!in_transaction_) return out_of_range(Argument::transaction);
  // On some faults SQLite rolls back by itself; without a transaction every further write would commit on its own.
  if (doomed_.ok() && sqlite3_get_autocommit(database_) != 0) doomed_ = {StatusCode::store_error, SQLITE_ABORT};
  return doomed_;
}

Status SqliteStore::written(const RecordInfo& info, Status status) {
  if (!status.ok()) {
    doomed_ = status;
    return status;
  }
  uncommitted_ |= mask_of(info.type);
  return {};
}

Status SqliteStore::read_row(const RecordInfo& info, sqlite3_stmt* statement, void* record) {
  const int code = sqlite3_step(statement);
  Status status;
  if (code == SQLITE_ROW) {
    alignas(8) unsigned char row[limits::max_record_bytes] = {};
    if (read_record(statement, info, row)) {
      std::memcpy(record, row, info.bytes);
    } else {
      status = {StatusCode::record_damaged, sqlite3_column_int64(statement, 0), static_cast<std::int64_t>(info.type)};
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
  const Status status = read_row(info, statement, record);
  // In a damaged index a walk could run in a circle for ever.
  const bool goes_back =
      (status.ok() && id_of(record) <= after) || (status.is(StatusCode::record_damaged) && status.a <= after);
  return goes_back ? fault(SQLITE_CORRUPT) : status;
}

Status SqliteStore::last(const RecordInfo& info, void* record) {
  return read_row(info, statements_[static_cast<std::size_t>(info.type)].last, record);
}

Status SqliteStore::previous(const RecordInfo& info, std::int64_t before, bool bounded, void* record) {
  if (!bounded) return last(info, record);
  sqlite3_stmt*& statement = statements_[static_cast<std::size_t>(info.type)].previous;
  if (statement == nullptr) {
    SqlText sql;
    select(info, "WHERE id<? ORDER BY id DESC LIMIT 1", sql);
    ILP_TRY(prepare(sql.c_str(), statement));
  }
  sqlite3_bind_int64(statement, 1, before);
  return read_row(info, statement, record);
}

Status SqliteStore::count(const RecordInfo& info, std::int64_t& records) {
  return integer_of(statements_[static_cast<std::size_t>(info.type)].count, records);
}

Status SqliteStore::put_blob(const BlobStatements& statements, std::int64_t id, std::uint32_t bytes) {
  // The size comes from the table itself, because the record that is replaced may be damaged.
  sqlite3_bind_int64(statements.size, 1, id);
  const int code = sqlite3_step(statements.size);
  const std::int64_t bytes_before = code == SQLITE_ROW ? sqlite3_column_int64(statements.size, 0) : 0;
  const Status found = code == SQLITE_ROW || code == SQLITE_DONE ? Status{} : fault(code);
  sqlite3_reset(statements.size);
  ILP_TRY(found);
  if (bytes == bytes_before) return {};
  sqlite3_stmt* const statement = bytes == 0 ? statements.erase : statements.create;
  sqlite3_bind_int64(statement, 1, id);
  if (bytes != 0) {
    sqlite3_bind_int64(statement, 2, static_cast<std::int64_t>(chunk_count(bytes) * sizeof(std::uint32_t)));
    sqlite3_bind_int64(statement, 3, bytes);
  }
  return run(statement);
}

Status SqliteStore::put_blobs(const RecordInfo& info, const void* record, std::int64_t id) {
  const Statements& s = statements_[static_cast<std::size_t>(info.type)];
  Status status;
  for_each_blob(info, [&](const FieldInfo& field, std::size_t index) {
    if (status.ok()) status = put_blob(s.blobs[index], id, blob_bytes(record, field));
  });
  return status;
}

Status SqliteStore::put_fields(const RecordInfo& info, const void* record) {
  sqlite3_stmt* statement = statements_[static_cast<std::size_t>(info.type)].put;
  bind_record(statement, info, record);
  return run(statement);
}

Status SqliteStore::put(const RecordInfo& info, const void* record) {
  ILP_TRY(writable());
  Status status = put_blobs(info, record, id_of(record));
  if (status.ok()) status = put_fields(info, record);
  return written(info, status);
}

Status SqliteStore::erase_row(const RecordInfo& info, std::int64_t id) {
  const Statements& s = statements_[static_cast<std::size_t>(info.type)];
  for (const BlobStatements& blob : s.blobs) {
    if (blob.erase == nullptr) break;
    sqlite3_bind_int64(blob.erase, 1, id);
    ILP_TRY(run(blob.erase));
  }
  sqlite3_bind_int64(s.erase, 1, id);
  return run(s.erase);
}

Status SqliteStore::erase(const RecordInfo& info, std::int64_t id) {
  ILP_TRY(writable());
  const Status status = erase_row(info, id);
  if (status.ok() && sqlite3_changes(database_) == 0) return {StatusCode::not_found, id};
  return written(info, status);
}

Status SqliteStore::poll(RecordMask& changed) {
  std::int64_t version = 0;
  ILP_TRY(integer_of(data_version_, version));
  changed = changed_;
  changed_ = 0;
  // Another process has written. The table is not known, so all of them count as changed.
  if (version != seen_version_) changed = ~RecordMask{0};
  seen_version_ = version;
  return {};
}

bool SqliteStore::changed_by_others() {
  std::int64_t version = 0;
  return integer_of(data_version_, version).ok() && version != seen_version_;
}

StoreUsage SqliteStore::usage() {
  std::int64_t pages = 0;
  std::int64_t free_pages = 0;
  if (database_ == nullptr || !integer_of(page_count_, pages).ok() || !integer_of(free_count_, free_pages).ok()) {
    return {known_bytes_, 0, limit_bytes_};
  }
  known_bytes_ = pages * page_bytes_;
  return {known_bytes_, free_pages * page_bytes_, limit_bytes_};
}

}  // namespace ilp
