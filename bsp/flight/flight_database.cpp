#include "bsp/flight/flight_database.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "bsp/flight/flight_software.hpp"
#include "bsp/flight/store_epoch_merge.hpp"
#include "fsw/base/text.hpp"
#include "fsw/storage/storage_manager.hpp"
#include "hal/store/checksums.hpp"
#include "hal/store/sqlite/disk_file.hpp"
#include "hal/store/sqlite/log_mark.hpp"
#include "hal/store/sqlite/quarantine.hpp"

namespace ilp {
namespace {

Result<bool> ended_in_order(Store& store) {
  StartRecord boot;
  const Status found = last(store, boot);
  if (!found.ok() && !is_gone(found)) return found;
  return found.is(StatusCode::not_found) || (found.ok() && boot.end_ns != 0);
}

using Path = FixedText<limits::max_path_bytes>;

/// Suffixes of a salvaged database: while it is being written, and when it is complete.
constexpr const char* unfinished_suffix = ".salvage";
constexpr const char* complete_suffix = ".saved";

/// Piece of a blob that is copied at once; it lies at the end of the flight's memory, where SQLite's arena does not
/// reach.
constexpr std::size_t chunk_bytes = 16 * blob_chunk_bytes;
static_assert(limits::sqlite_arena_bytes + chunk_bytes <= limits::ram_store_bytes);

Path beside(const char* path, const char* suffix) {
  Path name;
  name.add(path).add(suffix);
  return name;
}

Status remove_database(const Path& path) {
  for (const char* const suffix : {"-sync", "-wal", "-shm", "-journal", "-reserve", ""}) {
    Path name = path;
    name.add(suffix);
    if (::unlink(name.c_str()) != 0 && errno != ENOENT) return {StatusCode::io_error, errno};
  }
  return {};
}

Status make_empty(const Path& path) {
  SqliteStore store;
  return store.open(path.c_str());
}

/// A database that was closed is whole in itself if it has no log.
Status rename_whole(const Path& from, const Path& to) {
  Path log = from;
  log.add(log_suffix);
  ILP_TAKE(const bool log_exists, look_for(log.c_str()));
  if (log_exists) return StatusCode::store_error;
  return std::rename(from.c_str(), to.c_str()) == 0 ? Status{} : Status{StatusCode::io_error, errno};
}

std::int64_t total_saved(const SalvageCounts& counts) {
  std::int64_t saved = 0;
  for (const SalvageCount& count : counts) saved += count.saved;
  return saved;
}

std::int64_t count_records(Store& store) {
  std::int64_t total = 0;
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    std::int64_t records = 0;
    if (store.count(record_info(static_cast<RecordType>(t)), records).ok()) total += records;
  }
  return total;
}

/// Writes an event for each table with losses into the new database itself, so that no interrupted start loses them.
Status report_losses(const char* path, const SalvageCounts& counts) {
  SqliteStore store;
  ILP_TRY(store.open(path));
  EventRecord event;
  const Status found = last(store, event);
  if (!found.ok() && !found.is(StatusCode::not_found)) return found;
  Transaction transaction(store);
  ILP_TRY(transaction.begin());
  for (std::size_t t = 0; t < counts.size(); ++t) {
    const Status losses[] = {{StatusCode::records_lost, counts[t].lost, static_cast<std::int64_t>(t)},
                             {StatusCode::blobs_damaged, counts[t].damaged_blobs, static_cast<std::int64_t>(t)}};
    for (const Status& loss : losses) {
      if (loss.a == 0) continue;
      EventRecord reported;
      reported.id = ++event.id;
      reported.time_ns = event.time_ns;
      reported.code = static_cast<std::uint16_t>(loss.code);
      reported.severity = static_cast<std::uint8_t>(status_severity(loss.code));
      copy_text(reported.component, "board");
      reported.a = loss.a;
      reported.b = loss.b;
      ILP_TRY(put(store, reported));
    }
  }
  return transaction.commit();
}

Status open_database(SqliteStore& store, const char* path) {
  ILP_TRY(store.open(path));
  Status status = check_checkpoints(store, checkpoint_forms());
  const Result<bool> in_order = status.ok() ? ended_in_order(store) : status;
  status = in_order.status();
  if (status.ok() && !in_order.value()) status = store.check();
  if (!status.ok()) store.close();
  return status;
}

}  // namespace

bool may_pass(const Status& fault) {
  return fault.is(StatusCode::store_error) || fault.is(StatusCode::io_error) || fault.is(StatusCode::store_full) ||
         fault.is(StatusCode::store_locked);
}

/// The order of these steps lets the next start continue from any interruption: it removes an unfinished new database,
/// and puts a complete one in its place. Nothing is quarantined before that is complete.
Status FlightDatabase::replace(const char* path, const Status& verdict, const MissionParameters& mission) {
  const Path unfinished = beside(path, unfinished_suffix);
  if (unfinished.overflow()) return {StatusCode::capacity_exceeded, 0, limits::max_path_bytes};
  ILP_TRY(remove_database(unfinished));
  const std::span<std::uint8_t> scratch(reinterpret_cast<std::uint8_t*>(memory_.data() + memory_.size()) - chunk_bytes,
                                        chunk_bytes);
  const bool readable = verdict.is(StatusCode::store_damaged) || verdict.is(StatusCode::log_damaged);
  updates_.salvaged = {};
  Status status = readable
                      ? salvage(path, unfinished.c_str(), database_limit_bytes(mission), scratch, updates_.salvaged)
                      : make_empty(unfinished);
  if (status.ok()) status = report_losses(unfinished.c_str(), updates_.salvaged);
  if (status.ok()) status = rename_whole(unfinished, beside(path, complete_suffix));
  if (!status.ok()) {
    static_cast<void>(remove_database(unfinished));
    return status;
  }
  ILP_TRY(put_saved_in_place(path));
  if (total_saved(updates_.salvaged) == 0) {
    updates_.database = {StatusCode::store_set_aside, updates_.database.b, static_cast<std::int64_t>(verdict.code)};
  }
  return open_database(store_, path);
}

Status FlightDatabase::put_saved_in_place(const char* path) {
  const Path complete = beside(path, complete_suffix);
  ILP_TAKE(const bool is_complete, look_for(complete.c_str()));
  if (!is_complete) return {};
  std::int64_t number = 0;
  // It is moved last. If it is missing, an earlier start has set it aside.
  ILP_TAKE(const bool exists, look_for(path));
  if (exists) ILP_TRY(quarantine_database(path, number));
  // The note is about the one that was quarantined.
  ILP_TRY(guard_.forget_damage());
  if (std::rename(complete.c_str(), path) != 0) return {StatusCode::io_error, errno};
  updates_.database = {StatusCode::store_salvaged, total_saved(updates_.salvaged), number};
  return {};
}

Status FlightDatabase::open_usable(const char* path, StoreTrouble trouble, const MissionParameters& mission) {
  ILP_TRY(put_saved_in_place(path));
  if (guard_.says_damaged()) {
    ILP_TAKE(const bool exists, look_for(path));
    if (!exists) ILP_TRY(guard_.forget_damage());
  }
  Status status = guard_.says_damaged() ? Status{StatusCode::store_damaged} : open_database(store_, path);
  if (status.ok() && updates_.database.is(StatusCode::store_salvaged)) updates_.database.a = count_records(store_);
  if (trouble == StoreTrouble::refuse) return status;
  if (status.is(StatusCode::log_damaged)) {
    const Status mended = mend_log(path);
    if (mended.is(StatusCode::io_error)) return mended;
    if (mended.ok()) {
      // Everything was recovered.
      updates_.database = status;
      status = open_database(store_, path);
    }
  }
  // A fault that is no verdict on its content leaves a database where it is.
  if (is_verdict(status)) return replace(path, status, mission);
  return status;
}

Status FlightDatabase::open(const char* path, StoreTrouble trouble, const MissionParameters& mission, DiskWait* wait,
                            UnreadableCopy copies) {
  // The guard lies on the same disk.
  ILP_TRY(guard_.take(path));
  ILP_TRY(open_usable(path, trouble, mission));
  ILP_TRY(take_in_copies(path, mission, wait, copies));
  return store_.limit(database_limit_bytes(mission));
}

/// The copies are store epochs of the flight that followed each other.
Status FlightDatabase::take_in_copies(const char* path, const MissionParameters& mission, DiskWait* wait,
                                      UnreadableCopy copies) {
  ILP_TRY(remove_unfinished_copy(path));
  for (std::int64_t number = 1; number <= max_memory_copies; ++number) {
    const MemoryCopyPath copy = memory_copy_path(path, number);
    ILP_TAKE(const bool exists, look_for(copy.c_str()));
    if (exists) ILP_TRY(take_in(path, copy.c_str(), mission, wait, copies));
  }
  return {};
}

Status FlightDatabase::take_in(const char* path, const char* copy, const MissionParameters& mission, DiskWait* wait,
                               UnreadableCopy copies) {
  MemoryCopy records;
  const Status readable = records.open(copy, wait);
  if (may_pass(readable) && copies == UnreadableCopy::try_again) return readable;
  if (!readable.ok()) {
    // The flight goes on with its database.
    updates_.not_moved = {StatusCode::store_not_moved, static_cast<std::int64_t>(readable.code), readable.a};
    return refuse_copy(copy);
  }
  ILP_TAKE(const bool fits, follows(store_, records));
  if (!fits) {
    store_.close();
    ILP_TRY(replace(path, StatusCode::store_not_moved, mission));
  }
  std::int64_t taken = 0;
  ILP_TRY(merge_store_epoch(store_, records, wait, taken));
  records.close();
  updates_.moved = {StatusCode::store_back_on_disk, updates_.moved.a + taken, updates_.moved.b + records.lost()};
  return ::unlink(copy) == 0 ? Status{} : Status{StatusCode::io_error, errno};
}

Status FlightDatabase::open_as_primary(const char* path, StoreTrouble trouble, Synchronise when,
                                       const MissionParameters& mission) {
  const Status taken = guard_.take(path);
  if (taken.is(StatusCode::store_in_use)) return open_among_others(path, mission, when);
  ILP_TRY(taken);
  Status status = open_usable(path, trouble, mission);
  if (status.ok()) status = take_in_copies(path, mission, nullptr, UnreadableCopy::quarantine);
  if (status.ok()) status = store_.limit(database_limit_bytes(mission));
  if (status.ok()) status = store_.synchronise(when);
  if (status.ok()) {
    guard_.admit_others();
  } else {
    guard_.release();
  }
  return status;
}

Status FlightDatabase::open_among_others(const char* path, const MissionParameters& mission, Synchronise when) {
  ILP_TRY(guard_.share(path));
  Status status = guard_.says_damaged() ? Status{StatusCode::store_damaged} : store_.open(path);
  if (status.ok()) status = check_checkpoints(store_, checkpoint_forms());
  if (status.ok()) status = store_.limit(database_limit_bytes(mission));
  if (status.ok()) status = store_.synchronise(when);
  if (!status.ok()) close();
  return status;
}

bool FlightDatabase::damaged() const {
  if (store_.damaged()) guard_.note_damage();
  return store_.damaged();
}

void FlightDatabase::close() {
  static_cast<void>(damaged());
  store_.close();
  guard_.release();
}

}  // namespace ilp
