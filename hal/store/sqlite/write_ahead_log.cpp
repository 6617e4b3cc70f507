// Capacity and restart of the write-ahead log, and synchronisation of commits with the disk.
#include <sqlite3.h>
#include <sys/statvfs.h>

#include <algorithm>

#include "fsw/base/argument.hpp"
#include "fsw/base/text.hpp"
#include "hal/store/sqlite/checked_vfs.hpp"
#include "hal/store/sqlite/log_mark.hpp"
#include "hal/store/sqlite/page_checksum.hpp"
#include "hal/store/sqlite/reserve.hpp"
#include "hal/store/sqlite/session.hpp"

namespace ilp::sqlite {
namespace {

/// The log is copied when it has so many frames: a commit that does it takes little longer than the others.
constexpr int frames_to_copy = 250;

/// Half of it is more than a log has that nobody holds, on any disk.
constexpr std::int64_t least_log_capacity = std::int64_t{4} * frames_to_copy * static_cast<std::int64_t>(frame_bytes);

Status limit_pages(Session& s, std::int64_t bytes) {
  FixedText<64> sql;
  constexpr auto page = static_cast<std::int64_t>(page_bytes);
  sql.add("PRAGMA max_page_count=").add(std::max<std::int64_t>((bytes + page - 1) / page, 1));
  return execute(s, sql.c_str());
}

/// Makes the reserve again when there is room for it. Without it the database does not grow: the log may need all there
/// is.
Status mind_reserve(Session& s) {
  s.log.full_at_look = writes_without_capacity();
  const char* const path = sqlite3_db_filename(s.database, "main");
  const Status made = s.log.reserve_bytes > 0 && path != nullptr ? make_reserve(path, s.log.reserve_bytes) : Status{};
  s.log.disk_is_full = made.is(StatusCode::store_full);
  if (!made.ok() && !s.log.disk_is_full) s.log.reserve_bytes = 0;
  return s.limit_bytes > 0 ? limit_pages(s, s.log.disk_is_full ? usage(s).bytes : s.limit_bytes) : Status{};
}

/// The room that the log has on the disk is then used again.
Status start_log_over(Session& s) {
  int frames = 0, copied = -1;
  // It does not wait for readers, which may stay for long.
  sqlite3_busy_handler(s.database, nullptr, nullptr);
  const int code = sqlite3_wal_checkpoint_v2(s.database, nullptr, SQLITE_CHECKPOINT_RESTART, &frames, &copied);
  sqlite3_busy_handler(s.database, on_busy, &s.lock);
  if (code == SQLITE_OK) {
    s.log.bytes = s.log.held_bytes = 0;
    return {};
  }
  if (code != SQLITE_BUSY) return fault(s, code);
  // Another process writes, or copies it itself.
  if (copied < 0 || copied == frames) return {};
  if (2 * s.log.bytes > s.log.capacity) {
    if (s.log.held_bytes == 0) s.log.updates = {StatusCode::store_log_held, s.log.bytes, s.log.capacity};
    s.log.held_bytes = s.log.bytes;
  }
  return {StatusCode::store_full, s.log.bytes, s.log.capacity};
}

sqlite3_file* log_file(Session& s) {
  sqlite3_file* log = nullptr;
  const int code = sqlite3_file_control(s.database, "main", SQLITE_FCNTL_JOURNAL_POINTER, static_cast<void*>(&log));
  return code == SQLITE_OK && log != nullptr && log->pMethods != nullptr ? log : nullptr;
}

Status synchronise_log(Session& s) {
  sqlite3_file* const log = log_file(s);
  if (log == nullptr) return {StatusCode::store_error, SQLITE_IOERR};
  if (!s.log.synchronising_failed) {
    const int code = log->pMethods->xSync(log, SQLITE_SYNC_NORMAL);
    s.log.synchronising_failed = code != SQLITE_OK;
    return code == SQLITE_OK ? Status{} : Status{StatusCode::store_error, code};
  }
  // The system reports once that it could not write something, and may then take it for written. So everything is
  // written again, into the database, and the log starts over.
  int frames = 0, copied = -1;
  const int code = sqlite3_wal_checkpoint_v2(s.database, nullptr, SQLITE_CHECKPOINT_RESTART, &frames, &copied);
  if (code != SQLITE_OK) return fault(s, code);
  s.log.synchronising_failed = frames != copied;
  return s.log.synchronising_failed ? Status{StatusCode::store_error, SQLITE_BUSY} : Status{};
}

}  // namespace

int note_commit(void* log_bytes, sqlite3* database, const char* name, int frames) {
  *static_cast<std::int64_t*>(log_bytes) = std::int64_t{frames} * static_cast<std::int64_t>(frame_bytes);
  if (frames >= frames_to_copy) static_cast<void>(sqlite3_wal_checkpoint(database, name));
  return SQLITE_OK;
}

Status limit(Session& s, std::int64_t bytes) {
  if (s.database == nullptr || bytes <= 0) return out_of_range(Argument::capacity, bytes);
  static_cast<void>(usage(s));
  s.limit_bytes = bytes;
  const char* const path = sqlite3_db_filename(s.database, "main");
  struct statvfs disk {};
  if (path != nullptr && *path != 0 && statvfs(path, &disk) == 0) {
    const std::int64_t capacity = s.known_bytes + reserved_bytes(path) +
                                  static_cast<std::int64_t>(disk.f_bavail) * static_cast<std::int64_t>(disk.f_frsize);
    const std::int64_t log = std::min(capacity / 2, 2 * sqlite_log_bytes);
    if (s.limit_bytes > capacity - log) s.limit_bytes = capacity - log;
    // One half is for the log, and the other one for copying it.
    s.log.reserve_bytes = log / 2;
    s.log.capacity = std::max(s.log.reserve_bytes, least_log_capacity);
  }
  return mind_reserve(s);
}

Status make_room(Session& s) {
  const char* const path = sqlite3_db_filename(s.database, "main");
  const bool full = s.log.disk_is_full || writes_without_capacity() != s.log.full_at_look ||
                    (s.log.reserve_bytes > 0 && path != nullptr && reserved_bytes(path) < s.log.reserve_bytes);
  const bool is_long = 2 * s.log.bytes > s.log.capacity;
  // Another process has started it over if it is shorter.
  if (!is_long || s.log.bytes < s.log.held_bytes) s.log.held_bytes = 0;
  // A try writes all that was copied to the disk: while the log has room, only after it has grown.
  const bool was_tried =
      s.log.held_bytes > 0 && s.log.bytes <= s.log.capacity && s.log.bytes - s.log.held_bytes < s.log.capacity / 32;
  Status status;
  if ((is_long && !was_tried) || (full && s.log.bytes > 0)) status = start_log_over(s);
  if (full || writes_without_capacity() != s.log.full_at_look) ILP_TRY(mind_reserve(s));
  return s.log.bytes > s.log.capacity ? status : Status{};
}

Status synchronise(Session& s, Synchronise when) {
  if (s.database == nullptr || s.transaction.open) return out_of_range(Argument::database);
  ILP_TRY(execute(s, when == Synchronise::in_commit ? "PRAGMA synchronous=FULL" : "PRAGMA synchronous=NORMAL"));
  s.log.when = when;
  if (when == Synchronise::in_commit) return {};
  sqlite3_file* const log = log_file(s);
  const int code = log == nullptr ? SQLITE_IOERR : log->pMethods->xFileControl(log, fcntl_log_is_deferred, nullptr);
  return code == SQLITE_OK ? Status{} : Status{StatusCode::store_error, code};
}

Status flush(Session& s) {
  if (s.database == nullptr) return out_of_range(Argument::database);
  if (s.log.when == Synchronise::in_commit) return {};
  std::int64_t version = 0;
  ILP_TRY(integer_of(s, s.statements.data_version, version));
  if (!s.log.unsynchronised && version == s.log.flushed_version) return {};
  ILP_TRY(synchronise_log(s));
  s.log.unsynchronised = false;
  s.log.flushed_version = version;
  return {};
}

}  // namespace ilp::sqlite
