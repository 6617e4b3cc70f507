#include "hal/store/sqlite/sqlite_store.hpp"

#include <sqlite3.h>

#include <cstring>

#include "fsw/base/argument.hpp"
#include "hal/store/checksums.hpp"
#include "hal/store/record_bytes.hpp"
#include "hal/store/sql_columns.hpp"
#include "hal/store/sqlite/columns.hpp"
#include "hal/store/sqlite/sql_text.hpp"

namespace ilp {

using namespace sqlite;

namespace {

RecordStatements& of(Session& s, const RecordInfo& info) {
  return s.statements.records[static_cast<std::size_t>(info.type)];
}

Status read_row(Session& s, const RecordInfo& info, sqlite3_stmt* statement, void* record) {
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
    status = code == SQLITE_DONE ? Status{StatusCode::not_found} : fault(s, code);
  }
  sqlite3_reset(statement);
  return status;
}

Status put_blob(Session& s, const BlobStatements& statements, std::int64_t id, std::uint32_t bytes) {
  // The size comes from the table itself, because the record that is replaced may be damaged.
  sqlite3_bind_int64(statements.size, 1, id);
  const int code = sqlite3_step(statements.size);
  const std::int64_t bytes_before = code == SQLITE_ROW ? sqlite3_column_int64(statements.size, 0) : 0;
  const Status found = code == SQLITE_ROW || code == SQLITE_DONE ? Status{} : fault(s, code);
  sqlite3_reset(statements.size);
  ILP_TRY(found);
  if (bytes == bytes_before) return {};
  sqlite3_stmt* const statement = bytes == 0 ? statements.erase : statements.create;
  sqlite3_bind_int64(statement, 1, id);
  if (bytes != 0) {
    sqlite3_bind_int64(statement, 2, static_cast<std::int64_t>(chunk_count(bytes) * sizeof(std::uint32_t)));
    sqlite3_bind_int64(statement, 3, bytes);
  }
  return run(s, statement);
}

Status put_blobs(Session& s, const RecordInfo& info, const void* record, std::int64_t id) {
  Status status;
  for_each_blob(info, [&](const FieldInfo& field, std::size_t index) {
    if (status.ok()) status = put_blob(s, of(s, info).blobs[index], id, blob_bytes(record, field));
  });
  return status;
}

Status put_fields(Session& s, const RecordInfo& info, const void* record) {
  sqlite3_stmt* statement = of(s, info).put;
  bind_record(statement, info, record);
  return run(s, statement);
}

Status erase_row(Session& s, const RecordInfo& info, std::int64_t id) {
  const RecordStatements& record = of(s, info);
  for (const BlobStatements& blob : record.blobs) {
    if (blob.erase == nullptr) break;
    sqlite3_bind_int64(blob.erase, 1, id);
    ILP_TRY(run(s, blob.erase));
  }
  sqlite3_bind_int64(record.erase, 1, id);
  return run(s, record.erase);
}

}  // namespace

Status sqlite::writable(Session& s) {
  if (!s.transaction.open) return out_of_range(Argument::transaction);
  // On some faults SQLite rolls back by itself; without a transaction every further write would commit on its own.
  if (s.transaction.doomed.ok() && sqlite3_get_autocommit(s.database) != 0)
    s.transaction.doomed = {StatusCode::store_error, SQLITE_ABORT};
  return s.transaction.doomed;
}

Status sqlite::written(Session& s, const RecordInfo& info, Status status) {
  if (!status.ok()) {
    s.transaction.doomed = status;
    return status;
  }
  s.transaction.uncommitted |= mask_of(info.type);
  return {};
}

Status sqlite::get(Session& s, const RecordInfo& info, std::int64_t id, void* record) {
  sqlite3_stmt* statement = of(s, info).get;
  sqlite3_bind_int64(statement, 1, id);
  const Status status = read_row(s, info, statement, record);
  return status.is(StatusCode::not_found) ? Status{StatusCode::not_found, id} : status;
}

Status sqlite::previous(Session& s, const RecordInfo& info, std::int64_t before, bool bounded, void* record) {
  if (!bounded) return read_row(s, info, of(s, info).last, record);
  sqlite3_stmt*& statement = of(s, info).previous;
  if (statement == nullptr) {
    SqlText sql;
    select(info, "WHERE id<? ORDER BY id DESC LIMIT 1", sql);
    ILP_TRY(prepare(s, sql.c_str(), statement));
  }
  sqlite3_bind_int64(statement, 1, before);
  return read_row(s, info, statement, record);
}

Status SqliteStore::begin() {
  if (session_.database == nullptr || session_.transaction.open) return out_of_range(Argument::database);
  ILP_TRY(make_room(session_));
  const Status begun = run(session_, session_.statements.begin);
  if (!begun.is(StatusCode::store_locked)) session_.lock.taken_since_ns = 0;
  if (begun.is(StatusCode::store_locked) && session_.lock.taken_since_ns == 0) {
    session_.lock.taken_since_ns = session_.lock.waits_since_ns;
    return {StatusCode::store_locked, locked_ms(session_)};
  }
  ILP_TRY(begun);
  session_.transaction = {true, {}, 0};
  return {};
}

Status SqliteStore::commit() {
  Status status = writable(session_);
  if (status.ok()) status = run(session_, session_.statements.commit);
  if (!status.ok()) {
    rollback();
    return status;
  }
  session_.transaction.open = false;
  session_.changed |= session_.transaction.uncommitted;
  session_.log.unsynchronised = session_.log.unsynchronised || session_.transaction.uncommitted != 0;
  // The commit is done. If this fails, it is for flush() to say so.
  if (session_.log.when == Synchronise::behind_commit && session_.transaction.uncommitted != 0)
    static_cast<void>(flush());
  session_.transaction.uncommitted = 0;
  return {};
}

void SqliteStore::rollback() {
  if (!session_.transaction.open) return;
  session_.transaction.open = false;
  session_.transaction.uncommitted = 0;
  if (sqlite3_get_autocommit(session_.database) == 0) static_cast<void>(run(session_, session_.statements.rollback));
}

Status SqliteStore::next(const RecordInfo& info, std::int64_t after, void* record) {
  sqlite3_stmt* statement = of(session_, info).next;
  sqlite3_bind_int64(statement, 1, after);
  const Status status = read_row(session_, info, statement, record);
  // In a damaged index a walk could run in a circle for ever.
  const bool goes_back =
      (status.ok() && id_of(record) <= after) || (status.is(StatusCode::record_damaged) && status.a <= after);
  return goes_back ? fault(session_, SQLITE_CORRUPT) : status;
}

Status SqliteStore::last(const RecordInfo& info, void* record) {
  return read_row(session_, info, of(session_, info).last, record);
}

Status SqliteStore::count(const RecordInfo& info, std::int64_t& records) {
  return integer_of(session_, of(session_, info).count, records);
}

Status SqliteStore::put(const RecordInfo& info, const void* record) {
  ILP_TRY(writable(session_));
  Status status = put_blobs(session_, info, record, id_of(record));
  if (status.ok()) status = put_fields(session_, info, record);
  return written(session_, info, status);
}

Status SqliteStore::erase(const RecordInfo& info, std::int64_t id) {
  ILP_TRY(writable(session_));
  const Status status = erase_row(session_, info, id);
  if (status.ok() && sqlite3_changes(session_.database) == 0) return {StatusCode::not_found, id};
  return written(session_, info, status);
}

Status SqliteStore::poll(RecordMask& changed) {
  std::int64_t version = 0;
  ILP_TRY(integer_of(session_, session_.statements.data_version, version));
  changed = session_.changed;
  session_.changed = 0;
  // Another process has written. The table is not known, so all of them count as changed.
  if (version != session_.seen_version) changed = ~RecordMask{0};
  session_.seen_version = version;
  return {};
}

bool SqliteStore::changed_by_others() {
  std::int64_t version = 0;
  return integer_of(session_, session_.statements.data_version, version).ok() && version != session_.seen_version;
}

}  // namespace ilp
