// A store on a PostgreSQL server, which processes on one or several machines share (docs/store.md).
#pragma once

#include "hal/store/postgres/session.hpp"

namespace ilp {

/// A transaction locks the store from its first read or write. Transactions of other processes wait for it up to 15 s
/// and then return `store_error`. Writes are sent without waiting for their answers, so that a later call returns the
/// error of a write; commit() is the last one that can. After `store_lost` every call fails until reconnect(). libpq
/// allocates memory. An object has several MiB and must not lie on a stack.
class PostgresStore final : public Store, public StoreSharing {
 public:
  ~PostgresStore() { close(); }

  /// Connects to the server and makes the tables in an empty database. `conninfo` is a connection string of libpq:
  /// words and values, or postgresql://... wait() returns for changes of the tables `watched`. Returns `store_schema`
  /// (first value: fingerprint of the tables, -1 if the encoding is not SQL_ASCII; second: that of this build) if the
  /// database does not fit this build; nothing is changed then. Returns `capacity_exceeded` if `conninfo` is too long.
  Status open(const char* conninfo, RecordMask watched, PostgresOptions options = {}) {
    return postgres::open(session_, conninfo, watched, options);
  }
  void close() { postgres::close(session_); }
  /// Limits the bytes of blobs and of the tables' pages to about `bytes`; 0: no limit. A put beyond the limit returns
  /// `store_full`; records can still be erased.
  void limit(std::int64_t bytes) { session_.capacity.limit_bytes = bytes; }
  /// Sentence that says why the latest call failed. It contains no password.
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
  /// Bytes of all blobs and of the tables' pages, without indexes and without erased rows that the server has yet to
  /// remove. While less than half of the limit is used, the number may be a second old; what this process has put since
  /// is included.
  StoreUsage usage() override { return postgres::usage(session_); }

  Status claim(StageMask stages) override { return postgres::claim(session_, stages); }
  void release() override { postgres::release(session_); }
  [[nodiscard]] bool connected() const override { return session_.connection.alive(); }
  Status reconnect() override { return postgres::reconnect(session_); }
  /// Uses a second connection, because the server synchronises nothing in the middle of a transaction. Returns
  /// `not_ready` if that connection is lost; the next call opens it again.
  Status flush() override { return postgres::flush(session_); }
  void wait(std::int32_t milliseconds) override { postgres::wait(session_, milliseconds); }

 private:
  postgres::Session session_;
};

}  // namespace ilp
