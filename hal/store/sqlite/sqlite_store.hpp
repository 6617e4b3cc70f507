// The store on a disk: SQLite with a write-ahead log, every commit synchronised unless synchronise() says otherwise
// (architecture, "Atomicity").
#pragma once

#include <utility>

#include "hal/store/sqlite/session.hpp"

namespace ilp {

/// True if the fault is a verdict on the content of a database. Any other fault may be temporary, and says nothing
/// about the content.
[[nodiscard]] constexpr bool is_verdict(const Status& status) {
  return status.is(StatusCode::store_damaged) || status.is(StatusCode::log_damaged) ||
         status.is(StatusCode::store_schema) || status.is(StatusCode::store_build);
}

/// A database of another version of the field tables is refused with `store_schema` and not changed. open() prepares
/// all statements, so that later SQLite needs little memory beyond its page cache.
class SqliteStore final : public Store {
 public:
  ~SqliteStore() { close(); }

  /// Opens the database at `path`, and creates it if there is none. Returns `store_error` if it cannot be written (on a
  /// read-only disk).
  Status open(const char* path) { return sqlite::open(session_, path); }
  /// Limits the size of the database to `bytes`, or to the space that the disk has for it besides the log, if that is
  /// less. Makes the reserve (reserve.hpp). A write beyond the limit returns `store_full`; erasing is still possible.
  /// On a completely full disk even erasing must wait for free space. Existing data stays.
  Status limit(std::int64_t bytes) { return sqlite::limit(session_, bytes); }
  /// Returns `store_log_held` (a = octets of the log, b = its capacity) once, after the log has filled half of its
  /// capacity because a reader prevents its restart. When the log is full, begin() returns `store_full` until the
  /// reader has ended.
  Status take_updates() { return std::exchange(session_.log.updates, Status{}); }
  /// Reads the complete database, which takes long. Returns `store_damaged` if its structure is damaged.
  Status check() { return sqlite::check(session_); }
  /// True if damage was found since open(). Earlier writes may be lost: quarantine the database.
  [[nodiscard]] bool damaged() const { return sqlite::damaged(session_); }
  /// True if another process has committed since the latest poll(). False also if this cannot be read.
  [[nodiscard]] bool changed_by_others();
  /// Opens the database for reading only, for tools. A database with a log (its writer is active or was interrupted) is
  /// read together with the log. Otherwise no extra file remains.
  Status open_read_only(const char* path) { return sqlite::open_read_only(session_, path); }
  /// Selects when commits are synchronised; `in_commit` after open().
  Status synchronise(Synchronise when) { return sqlite::synchronise(session_, when); }
  /// Synchronises all commits of every process with the disk. It may be called within a transaction. With
  /// `behind_commit`, commit() does not report a failed synchronisation: flush() reports it, and outside a transaction
  /// it repairs it.
  Status flush() { return sqlite::flush(session_); }
  void close() { sqlite::close(session_); }

  Status begin() override;
  Status commit() override;
  void rollback() override;
  Status put(const RecordInfo& info, const void* record) override;
  Status get(const RecordInfo& info, std::int64_t id, void* record) override {
    return sqlite::get(session_, info, id, record);
  }
  Status next(const RecordInfo& info, std::int64_t after, void* record) override;
  Status last(const RecordInfo& info, void* record) override;
  Status erase(const RecordInfo& info, std::int64_t id) override;
  Status count(const RecordInfo& info, std::int64_t& records) override;
  Status write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                    std::span<const std::uint8_t> bytes) override {
    return sqlite::write_blob(session_, info, field, id, offset, bytes);
  }
  Status read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                   std::span<std::uint8_t> bytes) override {
    return sqlite::read_blob(session_, info, field, id, offset, bytes);
  }
  Status poll(RecordMask& changed) override;
  StoreUsage usage() override { return sqlite::usage(session_); }

  /// Access to what is no part of the Store interface: the write lock, and saving a damaged database.
  [[nodiscard]] sqlite::Session& session() { return session_; }

 private:
  sqlite::Session session_;
};

}  // namespace ilp
