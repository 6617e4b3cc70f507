// When commits are synchronised with the disk, and what is done where that fails.

#include <sqlite3.h>

#include "fsw/base/argument.hpp"
#include "hal/store/sqlite/checked_vfs.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"

namespace ilp {

Status SqliteStore::synchronise(Synchronise when) {
  if (database_ == nullptr || in_transaction_) return out_of_range(Argument::database);
  ILP_TRY(execute(when == Synchronise::in_commit ? "PRAGMA synchronous=FULL" : "PRAGMA synchronous=NORMAL"));
  synchronise_ = when;
  if (when == Synchronise::in_commit) return {};
  sqlite3_file* const log = log_file();
  const int code = log == nullptr ? SQLITE_IOERR : log->pMethods->xFileControl(log, fcntl_log_is_loose, nullptr);
  return code == SQLITE_OK ? Status{} : Status{StatusCode::store_error, code};
}

sqlite3_file* SqliteStore::log_file() {
  sqlite3_file* log = nullptr;
  const int code = sqlite3_file_control(database_, "main", SQLITE_FCNTL_JOURNAL_POINTER, static_cast<void*>(&log));
  return code == SQLITE_OK && log != nullptr && log->pMethods != nullptr ? log : nullptr;
}

Status SqliteStore::synchronise_log() {
  sqlite3_file* const log = log_file();
  if (log == nullptr) return {StatusCode::store_error, SQLITE_IOERR};
  if (!synchronising_failed_) {
    const int code = log->pMethods->xSync(log, SQLITE_SYNC_NORMAL);
    synchronising_failed_ = code != SQLITE_OK;
    return code == SQLITE_OK ? Status{} : Status{StatusCode::store_error, code};
  }
  // The system reports once that it could not write something, and may then take it for written. So everything is
  // written again, into the database, and the log starts over.
  int frames = 0, copied = -1;
  const int code = sqlite3_wal_checkpoint_v2(database_, nullptr, SQLITE_CHECKPOINT_RESTART, &frames, &copied);
  if (code != SQLITE_OK) return fault(code);
  synchronising_failed_ = frames != copied;
  return synchronising_failed_ ? Status{StatusCode::store_error, SQLITE_BUSY} : Status{};
}

Status SqliteStore::flush() {
  if (database_ == nullptr) return out_of_range(Argument::database);
  if (synchronise_ == Synchronise::in_commit) return {};
  std::int64_t version = 0;
  ILP_TRY(integer_of(data_version_, version));
  if (!unsynchronised_ && version == flushed_version_) return {};
  ILP_TRY(synchronise_log());
  unsynchronised_ = false;
  flushed_version_ = version;
  return {};
}

}  // namespace ilp
