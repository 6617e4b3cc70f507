// The store on a disk: SQLite with a write-ahead log, every commit synchronised (architecture, "Atomicity").
#pragma once

#include <array>

#include "hal/store/record_bytes.hpp"
#include "hal/store/sqlite/lock_file.hpp"
#include "hal/store/store.hpp"

struct sqlite3;
struct sqlite3_file;
struct sqlite3_stmt;
struct sqlite3_blob;

namespace ilp {

struct BlobHandles;

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

/// The fault is a verdict on the content of a database that was read. Any other one may pass, and says nothing about
/// it.
[[nodiscard]] constexpr bool is_verdict(const Status& status) {
  return status.is(StatusCode::store_damaged) || status.is(StatusCode::log_damaged) ||
         status.is(StatusCode::store_schema) || status.is(StatusCode::store_build);
}

/// A database of another version of the field tables is refused with `store_schema` and left untouched. open() prepares
/// all statements, so that in flight SQLite needs little memory beyond its page cache.
class SqliteStore final : public Store {
 public:
  SqliteStore() = default;
  ~SqliteStore();

  /// A database that cannot be written (on a read-only disk) is refused with `store_error`.
  Status open(const char* path);
  /// Limits the size of the database to `bytes`, and to the present room on the disk minus the room that the log may
  /// need, and makes the reserve (reserve.hpp). A write beyond it is `store_full`; erasing continues. On a completely
  /// full disk even erasing must wait for room. Existing data stays.
  Status limit(std::int64_t bytes);
  /// Once, when the log has half of its room because somebody reads: `store_log_held` (a = octets of the log, b = its
  /// room). When it has all of it, begin() is `store_full` until the reader has gone.
  Status take_news();
  /// Reads the whole database, which takes long: `store_damaged` when its structure is damaged.
  Status check();
  /// A call has returned `store_damaged` since open(). Earlier writes may be lost: set the database aside.
  [[nodiscard]] bool damaged() const;
  /// Another process has committed since the latest poll(). False if that cannot be read.
  [[nodiscard]] bool changed_by_others();
  /// For tools: nothing is written. For a database that no process has open for writing, no extra file remains; a
  /// database whose writer is active, or was interrupted, is read together with its log.
  Status open_read_only(const char* path);
  /// For saving the readable part: nothing is written, and a damaged log is read as far as SQLite can.
  Status open_damaged(const char* path, std::int64_t cache_kib);
  /// Sets the memory for pages.
  Status use_cache(std::int64_t kib);
  /// After open() it is `in_commit`.
  Status synchronise(Synchronise when);
  /// Whatever has been committed by any process is on the disk when this is ok. Within a transaction too. A commit
  /// whose synchronisation failed (`behind_commit`) is one that was not synchronised: this reports the fault, and heals
  /// it outside a transaction.
  Status flush();
  /// The same for what this connection has committed.
  Status flush_own() { return unsynchronised_ ? flush() : Status{}; }
  void close();

  /// How long begin() waits for the transactions of other processes, at most, before it is `store_locked` (a = ms for
  /// which the lock was taken); 2 s after open(). From then on it does not wait, until it has found the lock free.
  void wait_for_writers(std::int64_t milliseconds) { lock_.longest_wait_ns = 1'000'000 * milliseconds; }
  /// For how long begin() has not got the lock, in ms; 0: it had it at the latest call.
  [[nodiscard]] std::int64_t locked_ms() const;
  /// As LockFile::holder().
  [[nodiscard]] int lock_holder();

  Status begin() override;
  Status commit() override;
  void rollback() override;
  Status put(const RecordInfo& info, const void* record) override;
  Status get(const RecordInfo& info, std::int64_t id, void* record) override;
  Status next(const RecordInfo& info, std::int64_t after, void* record) override;
  Status last(const RecordInfo& info, void* record) override;
  Status erase(const RecordInfo& info, std::int64_t id) override;
  Status count(const RecordInfo& info, std::int64_t& records) override;
  Status write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                    std::span<const std::uint8_t> bytes) override;
  Status read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                   std::span<std::uint8_t> bytes) override;
  Status poll(RecordMask& changed) override;
  StoreUsage usage() override;

  /// The record with the largest id below `before`, or of all if `bounded` is false; otherwise as next().
  Status previous(const RecordInfo& info, std::int64_t before, bool bounded, void* record);
  /// For saving the rest of a damaged blob: reading the chunk at `offset` returns `record_damaged` until it is written
  /// again.
  Status mark_chunk_damaged(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset);

 private:
  /// What SQLite's busy handler knows.
  struct LockWait {
    std::int64_t waits_since_ns = 0;  ///< on the monotonic clock, for the lock that it waited for last
    std::int64_t longest_wait_ns = 2'000'000'000;
    std::int64_t taken_since_ns = 0;  ///< 0: the lock of the writers is not known to be taken
  };
  static int wait_for_lock(void* lock, int attempt);

  struct BlobStatements {
    sqlite3_stmt* size = nullptr;
    sqlite3_stmt* create = nullptr;  ///< or replace, with zero bytes
    sqlite3_stmt* erase = nullptr;
  };
  struct Statements {
    sqlite3_stmt* put = nullptr;
    sqlite3_stmt* get = nullptr;
    sqlite3_stmt* next = nullptr;
    sqlite3_stmt* last = nullptr;
    sqlite3_stmt* previous = nullptr;  ///< prepared at its first use
    sqlite3_stmt* erase = nullptr;
    sqlite3_stmt* count = nullptr;
    std::array<BlobStatements, max_blob_fields> blobs{};
  };

  Status fault(int code);
  Status execute(const char* sql);
  Status prepare(const char* sql, sqlite3_stmt*& statement);
  Status connect(const char* path, int flags);
  /// `sound`: the number of its schema is expected to be right.
  Status connect_read_only(const char* path, bool sound);
  Status check_database(bool may_create);
  Status check_schema(bool may_create);
  Status create_schema();
  Status prepare_all();
  Status prepare_record(const RecordInfo& info);
  Status integer_of(sqlite3_stmt* statement, std::int64_t& value);
  Status read_row(const RecordInfo& info, sqlite3_stmt* statement, void* record);
  Status run(sqlite3_stmt* statement);
  [[nodiscard]] sqlite3_file* log_file();
  Status synchronise_log();
  Status make_room();
  Status start_log_over();
  Status mind_reserve();
  Status limit_pages(std::int64_t bytes);
  Status writable();
  /// Call it after every write: a fault makes a commit impossible.
  Status written(const RecordInfo& info, Status status);
  Status put_blob(const BlobStatements& statements, std::int64_t id, std::uint32_t bytes);
  Status put_blobs(const RecordInfo& info, const void* record, std::int64_t id);
  Status put_fields(const RecordInfo& info, const void* record);
  Status erase_row(const RecordInfo& info, std::int64_t id);
  Status open_blob(const RecordInfo& info, const char* field, std::int64_t id, bool writable, BlobHandles& blob);
  Status open_column(const BlobHandles& blob, const char* column, bool writable, sqlite3_blob*& handle);
  Status missing_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t bytes);
  Status check_range(const RecordInfo& info, const char* field, const BlobHandles& blob, std::size_t offset,
                     std::size_t bytes);
  Status check_chunks(const BlobHandles& blob, std::size_t offset, std::span<const std::uint8_t> bytes);
  Status write_chunks(const BlobHandles& blob, std::size_t offset, std::span<const std::uint8_t> bytes);

  sqlite3* database_ = nullptr;
  LockWait lock_;
  LockFile lock_file_;
  bool damaged_ = false;
  std::int64_t refused_at_open_ = 0;
  Synchronise synchronise_ = Synchronise::in_commit;
  bool unsynchronised_ = false;  ///< a commit of this process may not be on the disk
  bool synchronising_failed_ = false;
  std::int64_t flushed_version_ = -1;  ///< the commits of others that are on the disk (data_version)
  bool in_transaction_ = false;
  Status doomed_;  ///< the fault that made a commit of this transaction impossible
  std::array<Statements, static_cast<std::size_t>(RecordType::count)> statements_{};
  sqlite3_stmt* begin_ = nullptr;
  sqlite3_stmt* commit_ = nullptr;
  sqlite3_stmt* rollback_ = nullptr;
  sqlite3_stmt* data_version_ = nullptr;
  sqlite3_stmt* page_count_ = nullptr;
  sqlite3_stmt* free_count_ = nullptr;
  std::int64_t page_bytes_ = 4096;
  std::int64_t known_bytes_ = 0;     ///< size of the database at the last query
  std::int64_t limit_bytes_ = 0;     ///< 0: none
  std::int64_t log_bytes_ = 0;       ///< of the log after the latest commit
  std::int64_t held_log_bytes_ = 0;  ///< of the log when a reader last kept it; 0: it was not kept
  std::int64_t log_room_ = sqlite_log_bytes;
  std::int64_t reserve_bytes_ = 0;
  bool disk_is_full_ = false;  ///< it has no room for the reserve
  std::int64_t full_at_look_ = 0;
  Status news_;
  std::int64_t seen_version_ = 0;
  RecordMask uncommitted_ = 0;
  RecordMask changed_ = 0;
};

}  // namespace ilp
