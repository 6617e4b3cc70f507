#include "fsw/downlink/downlink.hpp"

#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr std::int64_t credit_cap_s = 10;
/// Faults of one file until it is abandoned: faults that may pass (in 17 minutes), and permanent ones.
constexpr std::uint32_t most_passing_faults = 12;
constexpr std::uint32_t most_lasting_faults = 3;

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
    : store_(store), link_(link), clock_(clock), mission_(mission), scratch_(scratch), file_(store, link) {}

Status Downlink::restore() {
  asked_through_ = 0;
  hear_alone_ = 0;
  set_aside_.clear();
  const Status news = restore_checkpoint(store_, checkpoint, cursor_, state_);
  if (!restored(news)) return news;
  ILP_TRY(catch_up());
  return news;
}

Status Downlink::catch_up() {
  begin_ids<DownlinkRecord>(store_, state_.last_downlink_id);
  begin_ids<DownlinkRecord>(store_, state_.acknowledged_through);
  begin_ids<KeyframeRecord>(store_, state_.records_through);
  begin_ids<KeyframeRecord>(store_, state_.points_through);
  begin_ids<EventRecord>(store_, state_.events_through);
  begin_ids<KeyframeRecord>(store_, state_.event_files);
  DownlinkRecord record;
  for (;;) {  // bound: the files since the checkpoint
    Found found{};
    ILP_TRY(find_next(store_, state_.last_downlink_id, record, found));
    if (found == Found::nothing) break;
    state_.last_downlink_id = record.id;
    if (found == Found::damaged) continue;
    if (state_.records_through < record.records_through) state_.records_through = record.records_through;
    if (state_.points_through < record.points_through) state_.points_through = record.points_through;
    // Its number is in use; its events are sent once more.
    if (record.kind == DownlinkKind::records && record.subject_id <= 0) ++state_.event_files;
  }
  const Status newest = last(store_, record);
  newest_sent_ns_ = newest.ok() ? record.sent_ns : 0;
  return is_transient(newest) ? newest : Status{};
}

void Downlink::credit(State& after, const Contact& contact) {
  const TimeNs now = clock_.now();
  const std::int64_t rate = link_rate(mission_);
  // After a restart mission time may begin again, and the link must not wait until it has caught up.
  if (now < after.credited_ns) after.credited_ns = now;
  const std::int64_t elapsed_ms = (now - after.credited_ns) / ns_per_ms;
  if (elapsed_ms > 0) {
    const TimeNs until = after.credited_ns + elapsed_ms * ns_per_ms;
    const std::int64_t contact_ms = contact_between(mission_, after.credited_ns, until) / ns_per_ms;
    const std::int64_t bytes = rate * (contact_ms < 1000 * credit_cap_s ? contact_ms : 1000 * credit_cap_s) / 1000;
    after.credit_bytes += bytes;
    if (after.credit_bytes > rate * credit_cap_s) after.credit_bytes = rate * credit_cap_s;
    // On a slow link the fractions of a byte add up.
    if (bytes > 0 || contact_ms == 0) after.credited_ns = until;
  }
  // Without passes the link continues after the window.
  const TimeNs left_ns = mission_.pass_period_s > 0 ? contact.end_ns - now : continuous_window_ns;
  room_bytes_ = contact.open ? after.credit_bytes + bytes_in(rate, left_ns, no_limit_bytes) : 0;
}

Status Downlink::begin_pass(State& after, const Contact& contact, bool& begun) {
  begun = contact.open && contact.pass != after.pass;
  if (!begun) return {};
  after.pass = contact.pass;
  after.pass_bytes = 0;
  after.overdue_bytes = 0;
  // The unused part of a pass is lost; an overdraft stays as a debt.
  if (mission_.pass_period_s > 0 && after.credit_bytes > 0) after.credit_bytes = 0;
  for (std::size_t i = after.product_at_pass.size(); --i > 0;) after.product_at_pass[i] = after.product_at_pass[i - 1];
  ProductRecord newest;
  const Status any = last(store_, newest);
  if (any.is(StatusCode::not_found)) return {};
  if (any.is(StatusCode::record_damaged)) newest.id = any.a;
  if (!any.is(StatusCode::record_damaged)) ILP_TRY(any);
  after.product_at_pass[0] = newest.id;
  return {};
}

Status Downlink::send_in_contact(State& after, bool& sent) {
  const State before = after;
  const Status status = send_next(after, sent);
  if (status.is(StatusCode::transfer_queue_full)) {
    after = before;
    sent = changed_ = false;
    event_ = {};
    return {};
  }
  // The store answers not_found for missing records: only a link is not ready.
  if (status.is(StatusCode::not_ready)) {
    after = before;
    sent = changed_ = false;
    event_ = {};
    if (contact_lost_) return {};
    contact_lost_ = true;
    contact_lost_ns_ = clock_.now();
    event_ = {StatusCode::link_lost, after.last_downlink_id};
    return {};
  }
  if (status.ok() && sent && contact_lost_) {
    contact_lost_ = false;
    if (event_.ok()) event_ = {StatusCode::link_restored, (clock_.now() - contact_lost_ns_) / ns_per_ms};
  }
  return status;
}

Status Downlink::set_aside(const Status& fault, bool& others) {
  others = false;
  if (subject_.kind == FileClass::count || store_failed_ || fault.is(StatusCode::assertion_failed)) return fault;
  const bool of_link = file_.link_failed();
  if (!of_link && is_transient(fault)) {
    // A fault of the whole store is no statement about this file.
    CameraRecord any;
    const Status answer = last(store_, any);
    if (is_transient(answer)) return fault;
  }
  std::uint32_t faults = 0;
  const std::uint32_t most = is_transient(fault) ? most_passing_faults : most_lasting_faults;
  const auto kind = static_cast<std::uint8_t>(subject_.kind);
  if (!set_aside_.add(kind, subject_.id, clock_.now(), !of_link, most, faults)) return fault;
  others = true;
  if (faults > 1) return {};
  return {StatusCode::file_set_aside, subject_.id, static_cast<std::int64_t>(fault.code)};
}

StepResult Downlink::step() {
  event_ = {};
  subject_ = {};
  store_failed_ = changed_ = false;
  // Confirmations are on disk before anything is sent, and stay if sending fails.
  const Status unheard = hear_all();
  const Status told = unheard.ok() ? event_ : Status{};
  event_ = {};
  StepResult result = send_one();
  if (result.status.ok()) result.status = unheard.ok() ? told : unheard;
  return result;
}

StepResult Downlink::send_one() {
  State after = state_;
  const Contact contact = contact_at(mission_, clock_.now());
  bool sent = false;
  bool begun = false;
  bool checked = false;
  link_.prepare();
  StepTransaction transaction(store_, checkpoint);
  Status status = transaction.begin();
  if (status.ok()) status = begin_pass(after, contact, begun);
  if (status.ok()) status = check_products(after, checked);
  if (!status.ok()) return {status, false};
  credit(after, contact);
  status = send_in_contact(after, sent);
  if (!status.ok()) {
    bool others = false;
    status = set_aside(status, others);
    return {status, others};
  }
  if (sent || begun || checked || changed_) {
    status = transaction.commit(cursor_, after, cursor_);
    if (!status.ok()) return {status, false};
  }
  state_ = after;
  return {event_, sent || changed_};
}

}  // namespace ilp
