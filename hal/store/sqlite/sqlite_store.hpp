// The store on a disk: SQLite with a write-ahead log, every commit synchronised (architecture, "Atomicity").
#pragma once

#include <utility>

#include "hal/store/sqlite/session.hpp"

namespace ilp {

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
  ~SqliteStore() { close(); }

  /// A database that cannot be written (on a read-only disk) is refused with `store_error`.
  Status open(const char* path) { return sqlite::open(session_, path); }
  /// Limits the size of the database to `bytes`, and to the present room on the disk minus the room that the log may
  /// need, and makes the reserve (reserve.hpp). A write beyond it is `store_full`; erasing continues. On a completely
  /// full disk even erasing must wait for room. Existing data stays.
  Status limit(std::int64_t bytes) { return sqlite::limit(session_, bytes); }
  /// Once, when the log has half of its room because somebody reads: `store_log_held` (a = octets of the log, b = its
  /// room). When it has all of it, begin() is `store_full` until the reader has gone.
  Status take_updates() { return std::exchange(session_.log.updates, Status{}); }
  /// Reads the whole database, which takes long: `store_damaged` when its structure is damaged.
  Status check() { return sqlite::check(session_); }
  /// A call has returned `store_damaged` since open(). Earlier writes may be lost: set the database aside.
  [[nodiscard]] bool damaged() const { return sqlite::damaged(session_); }
  /// Another process has committed since the latest poll(). False if that cannot be read.
  [[nodiscard]] bool changed_by_others();
  /// For tools: nothing is written. For a database that no process has open for writing, no extra file remains; a
  /// database whose writer is active, or was interrupted, is read together with its log.
  Status open_read_only(const char* path) { return sqlite::open_read_only(session_, path); }
  /// After open() it is `in_commit`.
  Status synchronise(Synchronise when) { return sqlite::synchronise(session_, when); }
  /// Whatever has been committed by any process is on the disk when this is ok. Within a transaction too. A commit
  /// whose synchronisation failed (`behind_commit`) is one that was not synchronised: this reports the fault, and heals
  /// it outside a transaction.
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

  /// For what is no part of a store: the lock of the writers, saving a damaged database.
  [[nodiscard]] sqlite::Session& session() { return session_; }

 private:
  sqlite::Session session_;
};

}  // namespace ilp
