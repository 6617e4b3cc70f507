#include "fsw/downlink/downlink.hpp"

#include "fsw/downlink/downlink_choice.hpp"
#include "fsw/downlink/downlink_confirmations.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr std::int64_t credit_cap_s = 10;
/// Faults of one file until it is abandoned: faults that may pass (in 17 minutes), and permanent ones.
constexpr std::uint32_t most_passing_faults = 12;
constexpr std::uint32_t most_lasting_faults = 3;
/// After a fault of the store, this many confirmations are committed one by one.
constexpr int confirmed_alone = 16;
/// A slower link counts as one byte per second, so that it does not stop.
std::int64_t link_rate(const MissionParameters& mission) {
  if (mission.link_bytes_per_s <= 0) return 0;
  return mission.link_bytes_per_s < 1 ? 1 : static_cast<std::int64_t>(mission.link_bytes_per_s);
}

/// Bytes that a link carries in a time, at most `most`.
std::int64_t bytes_in(std::int64_t rate, TimeNs time, std::int64_t most) {
  const std::int64_t seconds = time / ns_per_s;
  if (rate > 0 && seconds >= most / rate) return most;
  return rate * seconds + rate * (time % ns_per_s / ns_per_ms) / 1000;
}

}  // namespace

constexpr CheckpointForm Downlink::checkpoint = checkpoint_form<State>(component_id);

Downlink::Downlink(Tables store, Link& link, Clock& clock, const MissionParameters& mission, Scratch scratch)
    : wiring_{store, link, clock, mission, scratch}, workspace_(store, link) {}

Status Downlink::restore() {
  work_.asked_through = 0;
  work_.confirm_alone = 0;
  work_.quarantine.clear();
  const Status updates = restore_checkpoint(wiring_.store, checkpoint, cursor_, state_);
  if (!restored(updates)) return updates;
  ILP_TRY(catch_up());
  return updates;
}

Status Downlink::catch_up() {
  begin_ids<DownlinkRecord>(wiring_.store, state_.last_downlink_id);
  begin_ids<DownlinkRecord>(wiring_.store, state_.acknowledged_through);
  begin_ids<KeyframeRecord>(wiring_.store, state_.records_through);
  begin_ids<KeyframeRecord>(wiring_.store, state_.points_through);
  begin_ids<EventRecord>(wiring_.store, state_.events_through);
  begin_ids<KeyframeRecord>(wiring_.store, state_.event_files);
  DownlinkRecord record;
  for (;;) {  // bound: the files since the checkpoint
    ILP_TAKE(const Found found, find_next(wiring_.store, state_.last_downlink_id, record));
    if (found == Found::nothing) break;
    state_.last_downlink_id = record.id;
    if (found == Found::damaged) continue;
    if (state_.records_through < record.records_through) state_.records_through = record.records_through;
    if (state_.points_through < record.points_through) state_.points_through = record.points_through;
    // Its number is in use; its events are sent once more.
    if (record.kind == DownlinkKind::records && record.subject_id <= 0) ++state_.event_files;
  }
  const Result<bool> newest = found_by(last(wiring_.store, record));
  work_.newest_sent_ns = newest.value() ? record.sent_ns : 0;
  return newest.status();
}

void Downlink::credit(State& after, const Contact& contact) {
  const TimeNs now = wiring_.clock.now();
  const std::int64_t rate = link_rate(wiring_.mission);
  // After a restart mission time may begin again, and the link must not wait until it has caught up.
  if (now < after.credited_ns) after.credited_ns = now;
  const std::int64_t elapsed_ms = (now - after.credited_ns) / ns_per_ms;
  if (elapsed_ms > 0) {
    const TimeNs until = after.credited_ns + elapsed_ms * ns_per_ms;
    const std::int64_t contact_ms = contact_between(wiring_.mission, after.credited_ns, until) / ns_per_ms;
    const std::int64_t bytes = rate * (contact_ms < 1000 * credit_cap_s ? contact_ms : 1000 * credit_cap_s) / 1000;
    after.credit_bytes += bytes;
    if (after.credit_bytes > rate * credit_cap_s) after.credit_bytes = rate * credit_cap_s;
    // On a slow link the fractions of a byte add up.
    if (bytes > 0 || contact_ms == 0) after.credited_ns = until;
  }
  // Without passes the link continues after the window.
  const TimeNs left_ns = wiring_.mission.pass_period_s > 0 ? contact.end_ns - now : continuous_window_ns;
  work_.free_bytes = contact.open ? after.credit_bytes + bytes_in(rate, left_ns, no_limit_bytes) : 0;
}

Result<bool> Downlink::begin_pass(State& after, const Contact& contact) {
  if (!contact.open || contact.pass + 1 == after.next_pass) return false;
  after.next_pass = contact.pass + 1;
  after.pass_bytes = 0;
  after.overdue_bytes = 0;
  // The unused part of a pass is lost; an overdraft stays as a debt.
  if (wiring_.mission.pass_period_s > 0 && after.credit_bytes > 0) after.credit_bytes = 0;
  for (std::size_t i = after.product_at_pass.size(); --i > 0;) after.product_at_pass[i] = after.product_at_pass[i - 1];
  ProductRecord newest;
  const Status any = last(wiring_.store, newest);
  const bool damaged = any.is(StatusCode::record_damaged);
  if (any.ok() || damaged) after.product_at_pass[0] = damaged ? any.a : newest.id;
  if (!any.ok() && !is_gone(any)) return any;
  return true;
}

Result<bool> Downlink::send_in_contact(State& after) {
  const State before = after;
  const Result<bool> sent = part<DownlinkChoice>().send_next(after);
  // The store answers not_found for missing records: only a link is not ready.
  const bool lost = sent.status().is(StatusCode::not_ready);
  if (lost || sent.status().is(StatusCode::transfer_queue_full)) {
    after = before;
    work_.changed = false;
    work_.event = {};
    if (!lost || work_.contact_lost) return false;
    work_.contact_lost = true;
    work_.contact_lost_ns = wiring_.clock.now();
    work_.event = {StatusCode::link_lost, after.last_downlink_id};
    return false;
  }
  if (sent.value() && work_.contact_lost) {
    work_.contact_lost = false;
    if (work_.event.ok())
      work_.event = {StatusCode::link_restored, (wiring_.clock.now() - work_.contact_lost_ns) / ns_per_ms};
  }
  return sent;
}

StepResult Downlink::quarantine(const Status& fault) {
  if (work_.subject.kind == FileClass::count || work_.store_failed || fault.is(StatusCode::assertion_failed))
    return {fault};
  const bool of_link = workspace_.file.link_failed();
  if (!of_link && is_transient(fault)) {
    // A fault of the whole store is no statement about this file.
    CameraRecord any;
    if (is_transient(last(wiring_.store, any))) return {fault};
  }
  std::uint32_t faults = 0;
  const std::uint32_t most = is_transient(fault) ? most_passing_faults : most_lasting_faults;
  if (!work_.quarantine.add(work_.subject.kind, work_.subject.id, wiring_.clock.now(), !of_link, most, faults))
    return {fault};
  if (faults > 1) return {{}, true};
  return {{StatusCode::file_set_aside, work_.subject.id, static_cast<std::int64_t>(fault.code)}, true};
}

Status Downlink::confirm_all() {
  State after = state_;
  if (after.acknowledged_through == after.last_downlink_id) return {};
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  const Result<bool> confirmed = part<DownlinkConfirmations>().confirm(after);
  Status status = confirmed.status();
  if (confirmed.value()) status = transaction.commit(cursor_, after, cursor_);
  if (status.ok()) state_ = after;
  if (!status.ok()) work_.confirm_alone = confirmed_alone;
  return status;
}

StepResult Downlink::step() {
  work_.event = {};
  work_.subject = {};
  work_.store_failed = work_.changed = false;
  // Confirmations are on disk before anything is sent, and stay if sending fails.
  const Status unheard = confirm_all();
  const Status reported = unheard.ok() ? work_.event : Status{};
  work_.event = {};
  StepResult result = send_one();
  if (result.status.ok()) result.status = unheard.ok() ? reported : unheard;
  return result;
}

StepResult Downlink::send_one() {
  State after = state_;
  const Contact contact = contact_at(wiring_.mission, wiring_.clock.now());
  wiring_.link.prepare();
  StepTransaction transaction(wiring_.store, checkpoint);
  const Status open = transaction.begin();
  if (!open.ok()) return {open};
  const Result<bool> begun = begin_pass(after, contact);
  if (!begun.ok()) return {begun.status()};
  const Result<bool> checked = part<DownlinkConfirmations>().check_products(after);
  if (!checked.ok()) return {checked.status()};
  credit(after, contact);
  const Result<bool> sent = send_in_contact(after);
  if (!sent.ok()) return quarantine(sent.status());
  if (sent.value() || begun.value() || checked.value() || work_.changed) {
    const Status kept = transaction.commit(cursor_, after, cursor_);
    if (!kept.ok()) return {kept};
  }
  state_ = after;
  return {work_.event, sent.value() || work_.changed};
}

}  // namespace ilp
