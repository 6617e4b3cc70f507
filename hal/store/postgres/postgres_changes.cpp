// What processes that share a store know of each other: changes of tables, and who runs which stage.
#include "fsw/base/argument.hpp"
#include "fsw/records/records.hpp"
#include "hal/store/postgres/postgres_store.hpp"
#include "hal/store/postgres/settings.hpp"

namespace ilp {

using namespace postgres;

namespace {

constexpr RecordMask every_table = mask_of(RecordType::count) - 1;
constexpr unsigned max_stages = 8 * sizeof(StageMask);

bool has(StageMask stages, unsigned stage) {
  return (stages >> stage & 1U) != 0;
}

}  // namespace

/// Tables that a commit has changed.
void PostgresStore::note_changes(RecordMask tables, std::int64_t commit) {
  for (std::size_t t = 0; t < record_count; ++t) {
    if ((tables >> t & 1U) != 0) numbers_[t] = commit;
  }
  changed_ |= tables;
  changed_early_ |= tables;
  heard_others_ = true;
  answers_.forget(tables);
  drop_held(tables);
  used_is_known_ = false;
}

/// Compares the numbers of commits with those that are known.
Status PostgresStore::take_look() {
  const Rows& rows = connection_.rows(awaited_.look);
  std::int64_t commits = 0;
  bool whole = rows.count() == 1 && rows.number(0, 0, commits);
  RecordMask changed = 0;
  for (std::size_t t = 0; t < record_count && whole; ++t) {
    std::int64_t number = 0;
    whole = rows.number(0, static_cast<int>(t) + 1, number);
    if (number != numbers_[t]) changed |= RecordMask{1} << t;
    numbers_[t] = number;
  }
  if (!whole) return {StatusCode::store_damaged};
  for (std::size_t t = 0; t < record_count; ++t) {
    if ((changed >> t & 1U) != 0) note_changes(RecordMask{1} << t, numbers_[t]);
  }
  heard_ = commits;
  unread_ |= changed;
  look_now_ = false;
  looked_ms_ = steady_ms();
  return {};
}

/// The number of our own commit. What is known of its tables is known as they are now.
void PostgresStore::take_change() {
  std::int64_t commit = 0;
  if (!connection_.rows(awaited_.change).number(0, 0, commit)) {
    look_now_ = true;
    return;
  }
  for (std::size_t t = 0; t < record_count; ++t) {
    if ((uncommitted_ >> t & 1U) != 0) numbers_[t] = commit;
  }
  heard_ = commit;
}

void PostgresStore::take_notifications() {
  Notification note;
  while (connection_.next_notification(note)) {  // bound: what has been received
    // Those up to this commit came with an answer of the server.
    if (note.own || note.commit <= heard_) continue;
    if (note.commit != heard_ + 1) look_now_ = true;
    note_changes(static_cast<RecordMask>(note.tables) & every_table, note.commit);
    heard_ = note.commit;
  }
}

Status PostgresStore::look() {
  if (!connected()) return StatusCode::store_lost;
  ILP_TRY(send_look());
  const Status status = collect();
  connection_.clear();
  return status;
}

/// Notifications come behind the answer to a rollback, which nobody has waited for.
Status PostgresStore::receive() {
  if (in_transaction_ || !connection_.anything_sent()) return connection_.receive();
  const Status status = collect();
  connection_.clear();
  return status;
}

Status PostgresStore::poll(RecordMask& changed) {
  changed = 0;
  ILP_TRY(receive());
  take_notifications();
  if (!in_transaction_ && (look_now_ || steady_ms() - looked_ms_ >= postgres_look_ms)) ILP_TRY(look());
  changed = changed_;
  changed_ = 0;
  return {};
}

void PostgresStore::wait(std::int32_t milliseconds) {
  const std::int64_t end = steady_ms() + milliseconds;
  while (!in_transaction_ && receive().ok()) {  // bound: `milliseconds`
    take_notifications();
    const std::int64_t now = steady_ms();
    if (look_now_ || now - looked_ms_ >= postgres_look_ms) {
      if (!look().ok()) return;
    }
    if ((changed_ & watched_) != 0 || now >= end) return;
    const std::int64_t next_look = looked_ms_ + postgres_look_ms;
    connection_.wait((end < next_look ? end : next_look) - now);
  }
}

/// No answer is newer than the numbers of commits that come behind it, so whatever was read of others is known of.
Status PostgresStore::flush() {
  if (!connected()) return StatusCode::store_lost;
  if (!heard_others_) return {};
  heard_others_ = false;
  Status status = flusher_.alive() ? Status{} : flusher_.open(conninfo_.c_str());
  if (status.ok()) status = flusher_.send(flush_statement, false);
  if (status.ok()) status = flusher_.collect();
  heard_others_ = !status.ok();
  // This connection is not the one that is lost.
  return status.is(StatusCode::store_lost) ? Status{StatusCode::not_ready} : status;
}

/// `taken`: those that were free. The others are with another process.
Status PostgresStore::try_claim(StageMask stages, StageMask& taken) {
  SqlText sql;
  sql.add("SELECT 0::bigint");
  for (unsigned stage = 0; stage < max_stages; ++stage) {
    if (!has(stages, stage)) continue;
    sql.add(",pg_try_advisory_lock(").add(lock_class).add(',').add(std::int64_t{stage} + 1).add(")::int::bigint");
  }
  taken = 0;
  ILP_TRY(connection_.send(sql.c_str(), true));
  ILP_TRY(connection_.collect());
  int column = 0;
  for (unsigned stage = 0; stage < max_stages; ++stage) {
    std::int64_t granted = 0;
    if (!has(stages, stage)) continue;
    if (!connection_.rows(0).number(0, ++column, granted)) return {StatusCode::store_damaged};
    if (granted != 0) taken |= StageMask{1} << stage;
  }
  connection_.clear();
  return {};
}

Status PostgresStore::claim(StageMask stages) {
  if (in_transaction_) return out_of_range(Argument::transaction);
  const StageMask wanted = stages & ~claimed_;
  StageMask taken = 0;
  ILP_TRY(try_claim(wanted, taken));
  if (taken == wanted) {
    claimed_ |= stages;
    return {};
  }
  std::int64_t first = 0;
  for (unsigned stage = 0; stage < max_stages; ++stage) {
    if (has(wanted & ~taken, stage) && first == 0) first = std::int64_t{stage} + 1;
    if (!has(taken, stage)) continue;
    FixedText<96> sql;
    sql.add("SELECT pg_advisory_unlock(").add(lock_class).add(',').add(std::int64_t{stage} + 1).add(')');
    ILP_TRY(connection_.send(sql.c_str(), false));
  }
  ILP_TRY(connection_.collect());
  return {StatusCode::stage_claimed, first};
}

void PostgresStore::release() {
  claimed_ = 0;
  if (in_transaction_ || !connected()) return;
  if (connection_.send("SELECT pg_advisory_unlock_all()", false).ok()) static_cast<void>(connection_.collect());
}

// The server may not have noticed yet that the old connection is gone, and still hold the stages for it:
// `stage_claimed` until it has.
Status PostgresStore::reconnect() {
  const StageMask claimed = claimed_;
  Status status = connect();
  claimed_ = 0;
  if (status.ok()) status = claim(claimed);
  claimed_ = claimed;
  changed_ = ~RecordMask{0};
  if (!status.ok()) connection_.close();
  return status;
}

}  // namespace ilp
