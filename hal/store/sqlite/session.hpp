// An open SQLite database: its connection, statements, transaction and write-ahead log. Functions without a comment are
// described at SqliteStore.
#pragma once

#include <array>
#include <span>

#include "hal/store/record_bytes.hpp"
#include "hal/store/sqlite/lock_file.hpp"
#include "hal/store/store.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace ilp {

/// When a commit is synchronised with the disk, so that it outlasts a power cut. A synchronisation includes all earlier
/// commits of every process, because the log is sequential.
enum class Synchronise : std::uint8_t {
  in_commit,      ///< during the commit: everything that a process can read is on the disk
  behind_commit,  ///< before commit() returns, after the write lock is released
  later           ///< by flush(), or by a later commit of any process
};

/// Largest size of the write-ahead log. It is normally copied into the database and restarted long before. If a reader
/// prevents this, the log grows up to this size plus one transaction; afterwards it is truncated to this size.
inline constexpr std::int64_t sqlite_log_bytes = 8 << 20;

}  // namespace ilp

namespace ilp::sqlite {

/// State of SQLite's busy handler, on_busy().
struct LockWait {
  std::int64_t waits_since_ns = 0;  ///< start of the last wait for a lock, monotonic clock
  std::int64_t longest_wait_ns = 2'000'000'000;
  std::int64_t taken_since_ns = 0;  ///< time since which the write lock was not free; 0: it was free at the last call
};

struct BlobStatements {
  sqlite3_stmt *size = nullptr, *erase = nullptr;
  sqlite3_stmt* create = nullptr;  ///< creates or replaces the blob, filled with zeros
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
  Status doomed;               ///< not ok: the fault that makes a commit of this transaction impossible
  RecordMask uncommitted = 0;  ///< types of records that it has written
};

struct WriteAheadLog {
  Synchronise when = Synchronise::in_commit;
  bool unsynchronised = false;  ///< a commit of this process may not be on the disk yet
  bool synchronising_failed = false;
  std::int64_t flushed_version = -1;  ///< data_version up to which the commits of others are on the disk
  std::int64_t bytes = 0;             ///< size after the latest commit
  std::int64_t held_bytes = 0;        ///< size when a reader last prevented the restart; 0: none did
  std::int64_t capacity = sqlite_log_bytes;
  std::int64_t reserve_bytes = 0;
  bool disk_is_full = false;      ///< the disk has no space for the reserve
  std::int64_t full_at_look = 0;  ///< writes_without_capacity() at the last check
  Status updates;                 ///< for SqliteStore::take_updates()
};

struct Session {
  sqlite3* database = nullptr;
  LockWait lock;
  LockFile lock_file;
  Statements statements;
  OpenTransaction transaction;
  WriteAheadLog log;
  bool damaged = false;
  std::int64_t refused_at_open = 0;  ///< refused_reads() at the opening
  std::int64_t known_bytes = 0;      ///< size of the database at the last query
  std::int64_t limit_bytes = 0;      ///< 0: no limit
  std::int64_t seen_version = 0;     ///< data_version at the latest poll
  RecordMask changed = 0;            ///< types of records that this process has committed since then
};

Status open(Session& s, const char* path);
Status open_read_only(Session& s, const char* path);
/// Opens a damaged database to save its readable part. Nothing is written, and a damaged log is read as far as SQLite
/// can.
Status open_damaged(Session& s, const char* path, std::int64_t cache_kib);
/// Sets the capacity of the page cache.
Status use_cache(Session& s, std::int64_t kib);
void close(Session& s);
Status check(Session& s);
[[nodiscard]] bool damaged(const Session& s);
StoreUsage usage(Session& s);

/// Sets how long begin() waits for the transactions of other processes (2 s after open()) before it returns
/// `store_locked` (a = ms for which the lock was not free). After that begin() does not wait, until it has found the
/// lock free.
inline void wait_for_writers(Session& s, std::int64_t milliseconds) {
  s.lock.longest_wait_ns = 1'000'000 * milliseconds;
}
/// Time for which begin() has failed to get the lock, ms; 0: it got the lock at the latest call.
[[nodiscard]] std::int64_t locked_ms(const Session& s);
/// LockFile::holder() of this database; 0 if it is not open.
[[nodiscard]] int lock_holder(Session& s);
/// SQLite's busy handler: SQLite calls it while another connection has a lock. `attempt` counts from 0 for each lock.
/// Returns 0 to abandon the wait.
int on_busy(void* lock, int attempt);

Status limit(Session& s, std::int64_t bytes);
Status synchronise(Session& s, Synchronise when);
Status flush(Session& s);
/// flush() if this connection has commits that may not be on the disk yet.
inline Status flush_own(Session& s) {
  return s.log.unsynchronised ? flush(s) : Status{};
}
/// Restarts the log if it is long or the disk is full. Called before every transaction. Returns `store_full` if the log
/// stays above its capacity.
Status make_room(Session& s);
/// SQLite calls this after every commit. It copies a long log into the database; if this fails, it is tried again after
/// the next commit.
int note_commit(void* log_bytes, sqlite3* database, const char* name, int frames);

/// The status of SQLite's error `code`. Notes damage in `s`.
Status fault(Session& s, int code);
Status execute(Session& s, const char* sql);
Status prepare(Session& s, const char* sql, sqlite3_stmt*& statement);
Status run(Session& s, sqlite3_stmt* statement);
Status integer_of(Session& s, sqlite3_stmt* statement, std::int64_t& value);

/// Ok if a transaction is open and can still be committed.
Status writable(Session& s);
/// Called after every write with its status, which it returns. A fault makes a commit of the transaction impossible.
Status written(Session& s, const RecordInfo& info, Status status);
Status get(Session& s, const RecordInfo& info, std::int64_t id, void* record);
/// Reads the record with the largest id below `before`, or with the largest id if `bounded` is false. Errors as next().
Status previous(Session& s, const RecordInfo& info, std::int64_t before, bool bounded, void* record);

Status write_blob(Session& s, const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                  std::span<const std::uint8_t> bytes);
Status read_blob(Session& s, const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                 std::span<std::uint8_t> bytes);
/// Marks a chunk of a blob that is saved in part: reading the chunk at `offset` returns `record_damaged` until it is
/// written again.
Status mark_chunk_damaged(Session& s, const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset);

}  // namespace ilp::sqlite
