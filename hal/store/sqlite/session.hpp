// A database that SQLite has open: its connection, statements, transaction and write-ahead log. The functions without
// a description are those of SqliteStore.
#pragma once

#include <array>
#include <span>

#include "hal/store/record_bytes.hpp"
#include "hal/store/sqlite/lock_file.hpp"
#include "hal/store/store.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace ilp {

/// When a commit is synchronised, so that it outlasts a power cut. The log is a sequence: with a commit, all earlier
/// ones of every process are synchronised too.
enum class Synchronise : std::uint8_t {
  in_commit,      ///< within it: what anybody can read is on the disk
  behind_commit,  ///< before commit() returns, but the other processes may write meanwhile
  later           ///< with flush(), or with a later commit of any process
};

/// The write-ahead log is copied into the database and started over long before it reaches this size, and cut to it.
/// While a reader prevents that, the log grows up to this size, and by one transaction more.
inline constexpr std::int64_t sqlite_log_bytes = 8 << 20;

}  // namespace ilp

namespace ilp::sqlite {

/// What SQLite's busy handler knows.
struct LockWait {
  std::int64_t waits_since_ns = 0;  ///< on the monotonic clock, for the lock that it waited for last
  std::int64_t longest_wait_ns = 2'000'000'000;
  std::int64_t taken_since_ns = 0;  ///< 0: the lock of the writers is not known to be taken
};

struct BlobStatements {
  sqlite3_stmt *size = nullptr, *erase = nullptr;
  sqlite3_stmt* create = nullptr;  ///< or replace, with zero bytes
};
struct RecordStatements {
  sqlite3_stmt *put = nullptr, *get = nullptr, *next = nullptr, *last = nullptr, *erase = nullptr, *count = nullptr;
  sqlite3_stmt* previous = nullptr;  ///< prepared at its first use
  std::array<BlobStatements, max_blob_fields> blobs{};
};
struct Statements {
  std::array<RecordStatements, static_cast<std::size_t>(RecordType::count)> records{};
  sqlite3_stmt *begin = nullptr, *commit = nullptr, *rollback = nullptr;
  sqlite3_stmt *data_version = nullptr, *page_count = nullptr, *free_count = nullptr;
};

struct OpenTransaction {
  bool open = false;
  Status doomed;  ///< the fault that made a commit of this transaction impossible
  RecordMask uncommitted = 0;
};

struct WriteAheadLog {
  Synchronise when = Synchronise::in_commit;
  bool unsynchronised = false;  ///< a commit of this process may not be on the disk
  bool synchronising_failed = false;
  std::int64_t flushed_version = -1;  ///< the commits of others that are on the disk (data_version)
  std::int64_t bytes = 0;             ///< after the latest commit
  std::int64_t held_bytes = 0;        ///< when a reader last kept it; 0: it was not kept
  std::int64_t capacity = sqlite_log_bytes;
  std::int64_t reserve_bytes = 0;
  bool disk_is_full = false;  ///< it has no room for the reserve
  std::int64_t full_at_look = 0;
  Status updates;
};

struct Session {
  sqlite3* database = nullptr;
  LockWait lock;
  LockFile lock_file;
  Statements statements;
  OpenTransaction transaction;
  WriteAheadLog log;
  bool damaged = false;
  std::int64_t refused_at_open = 0;
  std::int64_t known_bytes = 0;  ///< size of the database at the last query
  std::int64_t limit_bytes = 0;  ///< 0: none
  std::int64_t seen_version = 0;
  RecordMask changed = 0;
};

Status open(Session& s, const char* path);
Status open_read_only(Session& s, const char* path);
/// For saving the readable part: nothing is written, and a damaged log is read as far as SQLite can.
Status open_damaged(Session& s, const char* path, std::int64_t cache_kib);
/// Sets the memory for pages.
Status use_cache(Session& s, std::int64_t kib);
void close(Session& s);
Status check(Session& s);
[[nodiscard]] bool damaged(const Session& s);
StoreUsage usage(Session& s);

/// How long begin() waits for the transactions of other processes, at most, before it is `store_locked` (a = ms for
/// which the lock was taken); 2 s after open(). From then on it does not wait, until it has found the lock free.
inline void wait_for_writers(Session& s, std::int64_t milliseconds) {
  s.lock.longest_wait_ns = 1'000'000 * milliseconds;
}
/// For how long begin() has not got the lock, in ms; 0: it had it at the latest call.
[[nodiscard]] std::int64_t locked_ms(const Session& s);
/// As LockFile::holder().
[[nodiscard]] int lock_holder(Session& s);
/// SQLite's busy handler: called while another connection has a lock. `attempt` counts from 0 for each lock; the answer
/// 0 abandons the call.
int on_busy(void* lock, int attempt);

Status limit(Session& s, std::int64_t bytes);
Status synchronise(Session& s, Synchronise when);
Status flush(Session& s);
/// The same for what this connection has committed.
inline Status flush_own(Session& s) {
  return s.log.unsynchronised ? flush(s) : Status{};
}
/// Before every transaction.
Status make_room(Session& s);
/// SQLite calls it after every commit. If copying fails it is tried again after the next one.
int note_commit(void* log_bytes, sqlite3* database, const char* name, int frames);

Status fault(Session& s, int code);
Status execute(Session& s, const char* sql);
Status prepare(Session& s, const char* sql, sqlite3_stmt*& statement);
Status run(Session& s, sqlite3_stmt* statement);
Status integer_of(Session& s, sqlite3_stmt* statement, std::int64_t& value);

Status writable(Session& s);
/// Call it after every write: a fault makes a commit impossible.
Status written(Session& s, const RecordInfo& info, Status status);
Status get(Session& s, const RecordInfo& info, std::int64_t id, void* record);
/// The record with the largest id below `before`, or of all if `bounded` is false; otherwise as next().
Status previous(Session& s, const RecordInfo& info, std::int64_t before, bool bounded, void* record);

Status write_blob(Session& s, const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                  std::span<const std::uint8_t> bytes);
Status read_blob(Session& s, const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                 std::span<std::uint8_t> bytes);
/// For saving the rest of a damaged blob: reading the chunk at `offset` returns `record_damaged` until it is written
/// again.
Status mark_chunk_damaged(Session& s, const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset);

}  // namespace ilp::sqlite
