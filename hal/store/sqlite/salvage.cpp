#include "hal/store/sqlite/salvage.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <limits>

#include "fsw/base/result.hpp"
#include "hal/store/record_bytes.hpp"
#include "hal/store/sqlite/checked_vfs.hpp"
#include "hal/store/sqlite/log_mark.hpp"
#include "hal/store/sqlite/schema_pages.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"

namespace ilp {
namespace {

/// SQLite's memory for pages of each of the two databases.
constexpr std::int64_t cache_kib = 1024;
/// Records without blobs that are committed together.
constexpr int batch_records = 200;
/// If the end of a table is unknown, it is assumed after this many unreadable ids in a row.
constexpr std::int64_t max_missing = 1000;

/// For reads that fail, of all tables together: 2 s. What cannot be read after that counts as damaged.
constexpr int most_naps = 100;
constexpr int nap_ms = 20;

constexpr std::int64_t smallest = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t largest = std::numeric_limits<std::int64_t>::max();

/// Copies one table.
class Copy {
 public:
  Copy(SqliteStore& from, SqliteStore& to, const RecordInfo& info, std::span<std::uint8_t> scratch, int& naps,
       SalvageCount& count)
      : from_(from), to_(to), info_(info), scratch_(scratch), naps_(naps), count_(count) {}

  /// Returns faults of the new database.
  Status run() {
    ILP_TAKE(bool complete, forwards());
    if (!complete) {
      ILP_TAKE(complete, backwards());
    }
    if (!complete) ILP_TRY(between());
    return finish_batch();
  }

 private:
  static bool has_capacity(const Status& status) { return status.is(StatusCode::store_full); }

  /// A fault that passes is no damage, so it is tried again.
  template <typename Read>
  Status read_again(Read read) {
    Status status = read();
    const bool final = status.ok() || status.is(StatusCode::not_found) || status.is(StatusCode::record_damaged);
    if (!final) status = read();
    for (; status.is(StatusCode::store_error) && naps_ < most_naps; ++naps_) {
      sqlite3_sleep(nap_ms);
      status = read();
    }
    return status;
  }

  /// True at the end of the table; so does backwards() where it meets what this has reached.
  Result<bool> forwards() {
    for (;;) {  // bound: the records of the table; `low_` grows
      const Status found = read_again([&] { return from_.next(info_, low_, record_); });
      if (found.ok()) {
        low_ = id_of(record_);
        ILP_TRY(take());
      } else if (found.is(StatusCode::record_damaged)) {
        low_ = found.a;
        ++count_.lost;
      } else {
        return found.is(StatusCode::not_found);
      }
    }
  }

  /// Walks from the end to the point that `forwards` has reached.
  Result<bool> backwards() {
    for (;;) {  // bound: the records of the table; `high_` falls
      const Status found =
          read_again([&] { return sqlite::previous(from_.session(), info_, high_, high_known_, record_); });
      const bool damaged = found.is(StatusCode::record_damaged);
      if (!found.ok() && !damaged) return found.is(StatusCode::not_found);
      const std::int64_t id = damaged ? found.a : id_of(record_);
      if (id <= low_ || (high_known_ && id >= high_)) return id <= low_;
      high_ = id;
      high_known_ = true;
      if (damaged) {
        ++count_.lost;
      } else {
        ILP_TRY(take());
      }
    }
  }

  Status between() {
    const std::int64_t first = low_ < 0 ? 0 : low_ + 1;
    const std::int64_t end = high_known_ ? high_ : largest;
    std::int64_t missing = 0;
    std::int64_t unreadable = 0;
    for (std::int64_t id = first, probes = 0; id < end && probes < max_salvage_probes; ++id, ++probes) {
      const Status found = read_again([&] { return from_.get(info_, id, record_); });
      if (found.ok()) {
        ILP_TRY(take());
        count_.lost += unreadable;
        unreadable = 0;
        missing = 0;
        continue;
      }
      if (!found.is(StatusCode::not_found)) ++unreadable;
      if (!high_known_ && ++missing == max_missing) break;
    }
    // The number of records after the last readable one is not known.
    count_.lost += high_known_ ? unreadable : std::min<std::int64_t>(unreadable, 1);
    return {};
  }

  Status take() {
    const bool has_blobs = find_any_blob();
    if (!in_batch_) ILP_TRY(to_.begin());
    in_batch_ = true;
    std::int64_t damaged_blobs = 0;
    Status status = to_.put(info_, record_);
    for_each_blob(info_, [&](const FieldInfo& field, std::size_t) {
      if (!status.ok()) return;
      const Result<bool> whole = copy_blob(field);
      status = whole.status();
      if (whole.ok() && !whole.value()) ++damaged_blobs;
    });
    ++batch_;
    if (status.ok()) {
      count_.damaged_blobs += damaged_blobs;
      return has_blobs || batch_ >= batch_records ? finish_batch() : Status{};
    }
    return abandon_batch(status);
  }

  bool find_any_blob() const {
    bool any = false;
    for_each_blob(info_, [&](const FieldInfo& field, std::size_t) { any = any || blob_bytes(record_, field) != 0; });
    return any;
  }

  Status finish_batch() {
    if (!in_batch_) return {};
    in_batch_ = false;
    const Status status = to_.commit();
    if (!status.ok()) return abandon_batch(status);
    count_.saved += batch_;
    batch_ = 0;
    return {};
  }

  /// If there is no room for these, there may be for others.
  Status abandon_batch(const Status& status) {
    to_.rollback();
    in_batch_ = false;
    count_.lost += batch_;
    batch_ = 0;
    return has_capacity(status) ? Status{} : status;
  }

  /// False where a part of it is damaged; so does copy_chunks().
  Result<bool> copy_blob(const FieldInfo& field) {
    bool whole = true;
    const std::size_t size = blob_bytes(record_, field);
    for (std::size_t at = 0; at < size; at += scratch_.size()) {
      const auto window = scratch_.first(std::min(scratch_.size(), size - at));
      if (from_.read_blob(info_, field.name, id_of(record_), at, window).ok()) {
        ILP_TRY(to_.write_blob(info_, field.name, id_of(record_), at, window));
      } else {
        ILP_TAKE(const bool valid, copy_chunks(field, at, window.size()));
        whole = whole && valid;
      }
    }
    return whole;
  }

  Result<bool> copy_chunks(const FieldInfo& field, std::size_t begin, std::size_t bytes) {
    bool whole = true;
    for (std::size_t at = begin; at < begin + bytes; at += blob_chunk_bytes) {
      const auto chunk = scratch_.first(std::min(blob_chunk_bytes, begin + bytes - at));
      const std::int64_t id = id_of(record_);
      if (read_again([&] { return from_.read_blob(info_, field.name, id, at, chunk); }).ok()) {
        ILP_TRY(to_.write_blob(info_, field.name, id, at, chunk));
      } else {
        whole = false;
        ILP_TRY(sqlite::mark_chunk_damaged(to_.session(), info_, field.name, id, at));
      }
    }
    return whole;
  }

  SqliteStore& from_;
  SqliteStore& to_;
  const RecordInfo& info_;
  std::span<std::uint8_t> scratch_;
  int& naps_;
  SalvageCount& count_;
  std::int64_t low_ = smallest;
  std::int64_t high_ = largest;
  bool high_known_ = false;
  bool in_batch_ = false;
  int batch_ = 0;
  alignas(8) std::uint8_t record_[limits::max_record_bytes] = {};
};

constexpr bool is_large(RecordType type) {
  return type == RecordType::frame || type == RecordType::depth;
}

}  // namespace

Status salvage(const char* from, const char* to, std::int64_t limit_bytes, std::span<std::uint8_t> scratch,
               SalvageCounts& counts) {
  counts = {};
  Status log = check_log(from);
  if (log.is(StatusCode::log_damaged)) log = mend_log(from);
  if (!log.ok() && !log.is(StatusCode::log_damaged)) return log;
  bool lossless = log.ok();
  SqliteStore saved;
  ILP_TRY(saved.open(to));
  saved.close();
  // The same build makes the same schema in the same pages.
  ILP_TRY(restore_schema_pages(from, to));
  log = bridge_log(from);
  if (log.is(StatusCode::io_error)) return log;
  SqliteStore damaged;
  const std::int64_t failed_before = failed_reads();
  const Status readable = sqlite::open_damaged(damaged.session(), from, cache_kib);
  ILP_TRY(saved.open(to));
  ILP_TRY(saved.limit(limit_bytes));
  ILP_TRY(sqlite::use_cache(saved.session(), cache_kib));
  // Nothing can be read of it, or not at this time. Without one of its tables SQLite has no other word for it.
  const bool without_table =
      readable.is(StatusCode::store_error) && readable.a == SQLITE_ERROR && failed_reads() == failed_before;
  if (!readable.ok()) return is_verdict(readable) || without_table ? Status{} : readable;
  int naps = 0;
  for (const bool large : {false, true}) {
    for (std::size_t t = 0; t < counts.size(); ++t) {
      const RecordInfo& info = record_info(static_cast<RecordType>(t));
      if (is_large(info.type) != large || info.type == RecordType::identity) continue;
      Copy copy(damaged, saved, info, scratch, naps, counts[t]);
      ILP_TRY(copy.run());
      lossless = lossless && counts[t].lost == 0;
    }
  }
  // Numbers of lost records have been used: the flight begins another store epoch (IdentityRecord).
  if (!lossless) return {};
  const auto identity = static_cast<std::size_t>(RecordType::identity);
  Copy copy(damaged, saved, record_info(RecordType::identity), scratch, naps, counts[identity]);
  return copy.run();
}

}  // namespace ilp
