// The store on a PostgreSQL server, which several processes on one or several machines share (docs/store.md).
#pragma once

#include "hal/store/postgres/session.hpp"

namespace ilp {

/// A transaction has the store to itself, as in SQLite, from its first read or write: the others wait for it, up to
/// 15 s (`store_error`). Writes are sent ahead, so a fault of one may be returned by a later call, by commit() at the
/// latest. After `store_lost` every call fails until reconnect(). libpq allocates memory. An object has several MiB: it
/// does not belong on a stack.
class PostgresStore final : public Store, public StoreSharing {
 public:
  ~PostgresStore() { close(); }

  /// `conninfo` as libpq takes it: words and values, or postgresql://... An empty database gets the tables; those of
  /// another version are refused with `store_schema` (a = its fingerprint, b = ours) and left untouched; so is a
  /// database whose encoding is not SQL_ASCII (a = -1). wait() ends for changes of `watched`.
  /// `capacity_exceeded` for a text that is too long.
  Status open(const char* conninfo, RecordMask watched, PostgresOptions options = {}) {
    return postgres::open(session_, conninfo, watched, options);
  }
  void close() { postgres::close(session_); }
  /// Limits the bytes of blobs and of the tables' pages to about `bytes`. A put beyond it is `store_full`; erasing goes
  /// on. 0: no limit.
  void limit(std::int64_t bytes) { session_.capacity.limit_bytes = bytes; }
  /// Says in a sentence why the latest call failed. It holds no password.
  [[nodiscard]] const char* message() const { return session_.connection.message(); }
  [[nodiscard]] const postgres::Session& session() const { return session_; }

  Status begin() override { return postgres::begin(session_); }
  Status commit() override { return postgres::commit(session_); }
  void rollback() override { postgres::rollback(session_); }
  Status put(const RecordInfo& info, const void* record) override { return postgres::put(session_, info, record); }
  Status get(const RecordInfo& info, std::int64_t id, void* record) override {
    return postgres::get(session_, info, id, record);
  }
  Status next(const RecordInfo& info, std::int64_t after, void* record) override {
    return postgres::next(session_, info, after, record);
  }
  Status last(const RecordInfo& info, void* record) override { return postgres::last(session_, info, record); }
  Status erase(const RecordInfo& info, std::int64_t id) override { return postgres::erase(session_, info, id); }
  Status count(const RecordInfo& info, std::int64_t& records) override {
    return postgres::count(session_, info, records);
  }
  Status write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                    std::span<const std::uint8_t> bytes) override {
    return postgres::write_blob(session_, info, field, id, offset, bytes);
  }
  Status read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                   std::span<std::uint8_t> bytes) override {
    return postgres::read_blob(session_, info, field, id, offset, bytes);
  }
  Status poll(RecordMask& changed) override { return postgres::poll(session_, changed); }
  /// Bytes of all blobs and of the tables' pages. Indexes and what the server has yet to clean up do not count. While
  /// less than half of the limit is used, the number is up to a second old, with what this process has put since.
  StoreUsage usage() override { return postgres::usage(session_); }

  Status claim(StageMask stages) override { return postgres::claim(session_, stages); }
  void release() override { postgres::release(session_); }
  [[nodiscard]] bool connected() const override { return session_.connection.alive(); }
  Status reconnect() override { return postgres::reconnect(session_); }
  /// By a connection of its own, because the server synchronises nothing in the middle of a transaction. `not_ready` if
  /// that one is lost: try again.
  Status flush() override { return postgres::flush(session_); }
  void wait(std::int32_t milliseconds) override { postgres::wait(session_, milliseconds); }

 private:
  postgres::Session session_;
};

}  // namespace ilp
