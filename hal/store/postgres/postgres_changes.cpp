// Notices changes of tables by other processes that share the store, and claims stages.
#include "fsw/base/argument.hpp"
#include "fsw/records/records.hpp"
#include "hal/store/postgres/session.hpp"
#include "hal/store/postgres/settings.hpp"

namespace ilp::postgres {
namespace {

constexpr RecordMask every_table = mask_of(RecordType::count) - 1;
constexpr unsigned max_stages = 8 * sizeof(StageMask);

bool has(StageMask stages, unsigned stage) {
  return (stages >> stage & 1U) != 0;
}

/// Tables that a commit has changed.
void note_changes(Session& s, RecordMask tables, std::int64_t commit) {
  for (std::size_t t = 0; t < record_count; ++t) {
    if ((tables >> t & 1U) != 0) s.changes.numbers[t] = commit;
  }
  s.changes.changed |= tables;
  s.changes.received_others = true;
  s.answers.forget(tables);
  drop_held(s, tables);
  s.capacity.used_is_known = false;
}

/// Notifications come behind the answer to a rollback, which nobody has waited for.
Status receive(Session& s) {
  if (s.transaction.open || !s.connection.anything_sent()) return s.connection.receive();
  const Status status = collect(s);
  s.connection.clear();
  return status;
}

/// `taken`: those that were free. The others are with another process.
Status try_claim(Session& s, StageMask stages, StageMask& taken) {
  SqlText sql;
  sql.add("SELECT 0::bigint");
  for (unsigned stage = 0; stage < max_stages; ++stage) {
    if (!has(stages, stage)) continue;
    sql.add(",pg_try_advisory_lock(").add(lock_class).add(',').add(std::int64_t{stage} + 1).add(")::int::bigint");
  }
  taken = 0;
  ILP_TRY(s.connection.send(sql.c_str(), true));
  ILP_TRY(s.connection.collect());
  int column = 0;
  for (unsigned stage = 0; stage < max_stages; ++stage) {
    std::int64_t granted = 0;
    if (!has(stages, stage)) continue;
    if (!s.connection.rows(0).number(0, ++column, granted)) return {StatusCode::store_damaged};
    if (granted != 0) taken |= StageMask{1} << stage;
  }
  s.connection.clear();
  return {};
}

}  // namespace

Status take_look(Session& s) {
  const Rows& rows = s.connection.rows(s.awaited.look);
  std::int64_t commits = 0;
  bool whole = rows.count() == 1 && rows.number(0, 0, commits);
  RecordMask changed = 0;
  for (std::size_t t = 0; t < record_count && whole; ++t) {
    std::int64_t number = 0;
    whole = rows.number(0, static_cast<int>(t) + 1, number);
    if (number != s.changes.numbers[t]) changed |= RecordMask{1} << t;
    s.changes.numbers[t] = number;
  }
  if (!whole) return {StatusCode::store_damaged};
  for (std::size_t t = 0; t < record_count; ++t) {
    if ((changed >> t & 1U) != 0) note_changes(s, RecordMask{1} << t, s.changes.numbers[t]);
  }
  s.changes.received = commits;
  s.changes.unread |= changed;
  s.changes.poll_now = false;
  s.changes.polled_ms = steady_ms();
  return {};
}

void take_change(Session& s) {
  std::int64_t commit = 0;
  if (!s.connection.rows(s.awaited.change).number(0, 0, commit)) {
    s.changes.poll_now = true;
    return;
  }
  for (std::size_t t = 0; t < record_count; ++t) {
    if ((s.transaction.uncommitted >> t & 1U) != 0) s.changes.numbers[t] = commit;
  }
  s.changes.received = commit;
}

void take_notifications(Session& s) {
  Notification note;
  while (s.connection.next_notification(note)) {  // bound: what has been received
    // Those up to this commit came with an answer of the server.
    if (note.own || note.commit <= s.changes.received) continue;
    if (note.commit != s.changes.received + 1) s.changes.poll_now = true;
    note_changes(s, static_cast<RecordMask>(note.tables) & every_table, note.commit);
    s.changes.received = note.commit;
  }
}

Status look(Session& s) {
  if (!s.connection.alive()) return StatusCode::store_lost;
  ILP_TRY(send_look(s));
  const Status status = collect(s);
  s.connection.clear();
  return status;
}

Status poll(Session& s, RecordMask& changed) {
  changed = 0;
  ILP_TRY(receive(s));
  take_notifications(s);
  if (!s.transaction.open && (s.changes.poll_now || steady_ms() - s.changes.polled_ms >= postgres_poll_ms))
    ILP_TRY(look(s));
  changed = s.changes.changed;
  s.changes.changed = 0;
  return {};
}

void wait(Session& s, std::int32_t milliseconds) {
  const std::int64_t end = steady_ms() + milliseconds;
  while (!s.transaction.open && receive(s).ok()) {  // bound: `milliseconds`
    take_notifications(s);
    const std::int64_t now = steady_ms();
    if (s.changes.poll_now || now - s.changes.polled_ms >= postgres_poll_ms) {
      if (!look(s).ok()) return;
    }
    if ((s.changes.changed & s.watched) != 0 || now >= end) return;
    const std::int64_t next_look = s.changes.polled_ms + postgres_poll_ms;
    s.connection.wait((end < next_look ? end : next_look) - now);
  }
}

/// No answer is newer than the numbers of commits that come behind it, so whatever was read of others is known of.
Status flush(Session& s) {
  if (!s.connection.alive()) return StatusCode::store_lost;
  if (!s.changes.received_others) return {};
  s.changes.received_others = false;
  Status status = s.flusher.alive() ? Status{} : s.flusher.open(s.conninfo.c_str());
  if (status.ok()) status = s.flusher.send(flush_statement, false);
  if (status.ok()) status = s.flusher.collect();
  s.changes.received_others = !status.ok();
  // This connection is not the one that is lost.
  return status.is(StatusCode::store_lost) ? Status{StatusCode::not_ready} : status;
}

Status claim(Session& s, StageMask stages) {
  if (s.transaction.open) return out_of_range(Argument::transaction);
  const StageMask wanted = stages & ~s.claimed;
  StageMask taken = 0;
  ILP_TRY(try_claim(s, wanted, taken));
  if (taken == wanted) {
    s.claimed |= stages;
    return {};
  }
  std::int64_t first = 0;
  for (unsigned stage = 0; stage < max_stages; ++stage) {
    if (has(wanted & ~taken, stage) && first == 0) first = std::int64_t{stage} + 1;
    if (!has(taken, stage)) continue;
    FixedText<96> sql;
    sql.add("SELECT pg_advisory_unlock(").add(lock_class).add(',').add(std::int64_t{stage} + 1).add(')');
    ILP_TRY(s.connection.send(sql.c_str(), false));
  }
  ILP_TRY(s.connection.collect());
  return {StatusCode::stage_claimed, first};
}

void release(Session& s) {
  s.claimed = 0;
  if (s.transaction.open || !s.connection.alive()) return;
  if (s.connection.send("SELECT pg_advisory_unlock_all()", false).ok()) static_cast<void>(s.connection.collect());
}

// The server may not have noticed yet that the old connection is gone, and still hold the stages for it:
// `stage_claimed` until it has.
Status reconnect(Session& s) {
  const StageMask claimed = s.claimed;
  Status status = connect(s);
  s.claimed = 0;
  if (status.ok()) status = claim(s, claimed);
  s.claimed = claimed;
  s.changes.changed = ~RecordMask{0};
  if (!status.ok()) s.connection.close();
  return status;
}

}  // namespace ilp::postgres
