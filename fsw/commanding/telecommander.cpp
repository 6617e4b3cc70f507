#include "fsw/commanding/telecommander.hpp"

#include <algorithm>
#include <utility>

#include "fsw/commanding/settings.hpp"
#include "fsw/packets/service_events.hpp"
#include "fsw/packets/service_functions.hpp"
#include "fsw/packets/service_housekeeping.hpp"
#include "fsw/packets/service_parameters.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

// More packets wait in the router.
constexpr int packets_per_step = 32;
constexpr int releases_per_step = 32;
// A minor frame that is late still carries out its requests; a request that an outage has delayed longer is not carried
// out.
constexpr TimeNs latest_release_ns = 10 * minor_frame_ns;
// The camera is given a capture before its time, so that a late minor frame does not delay it. Everything else happens
// not before its time.
constexpr TimeNs capture_lead_ns = ns_per_s;
constexpr std::uint32_t frames_between_counts = 50;
// A slow disk holds up a transaction of another process now and then; what lasts longer is a fault.
constexpr TimeNs longest_lock_wait_ns = 2 * ns_per_s;

/// Whether the packet names a sender that can be answered.
bool can_answer(const Status& fault, std::size_t bytes) {
  return bytes >= primary_header_bytes && !fault.is(StatusCode::packet_type);
}

/// Neither in the store nor in the mission: tests, and reports of what the telecommander knows or reads.
bool changes_nothing(const Telecommand& telecommand) {
  switch (telecommand.service) {
    case test_service::service:
      return true;
    case parameter_management::service:
      return telecommand.subtype == parameter_management::report;
    case scheduling::service:
      return telecommand.subtype == scheduling::summary || telecommand.subtype == scheduling::summary_all ||
             telecommand.subtype == scheduling::detail || telecommand.subtype == scheduling::detail_all;
    default:
      return false;
  }
}

Status serve(ServiceCall& call) {
  Service* const service = find_service(call.telecommand.service);
  return service != nullptr ? service(call) : Status{StatusCode::service_unknown, call.telecommand.service};
}

}  // namespace

Service* find_service(std::uint8_t number) {
  constexpr std::pair<std::uint8_t, Service*> services[] = {
      {housekeeping::service, serve_housekeeping},
      {event_reporting::service, serve_events},
      {function_management::service, serve_functions},
      {scheduling::service, serve_schedule},
      {test_service::service, serve_tests},
      {parameter_management::service, serve_parameters},
  };
  for (const auto& [known, service] : services) {
    if (known == number) return service;
  }
  return nullptr;
}

constexpr CheckpointForm Telecommander::checkpoint = checkpoint_form<State>(component_id);

Telecommander::Telecommander(Tables store, PacketRouter& router, TelemetryWriter& writer, Clock& clock,
                             MissionParameters& mission, Configuration* configuration)
    : wiring_{store, router, writer, clock, mission, configuration}, work_{mission, {}} {}

Status Telecommander::restore() {
  const Status loaded = restore_checkpoint(wiring_.store, checkpoint, cursor_, state_);
  if (!restored(loaded)) return loaded;
  begin_ids<CommandRecord>(wiring_.store, state_.last_request_id);
  begin_ids<ScheduledRecord>(wiring_.store, state_.last_scheduled_id);
  if (state_.open.empty()) {
    // No request waits for the existing captures.
    CaptureRecord newest;
    const Status found = last(wiring_.store, newest);
    // A damaged record does not hinder commanding.
    if (!found.ok() && !is_gone(found)) return found;
    if (!found.is(StatusCode::not_found)) state_.last_capture_id = found.ok() ? newest.id : found.a;
  }
  work_.wanted = wiring_.configuration != nullptr ? wiring_.configuration->wanted() : wiring_.mission;
  if (wiring_.configuration == nullptr) {
    const Status settings = load_settings(wiring_.store, work_.wanted);
    if (!settings.ok() && !settings.is(StatusCode::setting_ignored)) return settings;
  }
  ILP_TRY(read_schedule(wiring_, work_));
  return loaded;
}

StepResult Telecommander::step() {
  workspace_.set_parameters = false;
  Status status = wiring_.router.pump();
  const StatusCode pump_fault = status.code;
  if (status.is(workspace_.pump_fault)) status = {};
  workspace_.pump_fault = pump_fault;
  const Status followed = follow_open_requests();
  if (status.ok() && !followed.ok()) status = followed;
  release();
  receive();
  wiring_.writer.flush();
  if (++workspace_.frames % frames_between_counts == 0) {
    const Status written = write_counts();
    if (status.ok()) status = written;
  }
  const Status updates = update_of_configuration();
  if (status.ok()) status = updates;
  if (status.ok() && wiring_.writer.waiting() == 0 && wiring_.writer.lost() != workspace_.reported_lost) {
    status = {StatusCode::telemetry_lost, wiring_.writer.lost() - workspace_.reported_lost};
    workspace_.reported_lost = wiring_.writer.lost();
  }
  return {status, false, Then::go_on, workspace_.set_parameters};
}

Status Telecommander::update_of_configuration() {
  if (wiring_.configuration == nullptr) return {};
  if (wiring_.configuration->step(wiring_.clock.now())) {
    work_.wanted = wiring_.configuration->wanted();
    workspace_.set_parameters = true;
  }
  return wiring_.configuration->updates();
}

Status Telecommander::write_counts() {
  CommandingRecord& counts = state_.counts;
  const bool reports_changed = counts.reports_sent != wiring_.writer.sent() ||
                               counts.reports_lost != wiring_.writer.lost() ||
                               counts.reports_waiting != wiring_.writer.waiting();
  if (!workspace_.counts_changed && !reports_changed) return {};
  counts.reports_sent = wiring_.writer.sent();
  counts.reports_lost = wiring_.writer.lost();
  counts.reports_waiting = wiring_.writer.waiting();
  counts.open = static_cast<std::uint32_t>(state_.open.size());
  counts.scheduled = static_cast<std::uint32_t>(work_.entries.size());
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(wiring_.store, counts));
  ILP_TRY(transaction.commit(cursor_, state_, cursor_));
  workspace_.counts_changed = false;
  return {};
}

void Telecommander::receive() {
  for (int i = 0; i < packets_per_step; ++i) {
    std::size_t bytes = workspace_.packet_bytes;
    if (bytes == 0 && !wiring_.router.receive(Channel::commands, workspace_.packet, bytes).ok()) return;
    workspace_.packet_bytes = 0;
    if (waits_for_lock({workspace_.packet.data(), bytes})) {
      workspace_.packet_bytes = bytes;
      return;
    }
    carry_out({workspace_.packet.data(), bytes}, wiring_.clock.now(), nullptr);
    if (workspace_.came_before > 0) --workspace_.came_before;
  }
}

Status Telecommander::try_store() {
  Transaction transaction(wiring_.store);
  const Status begun = transaction.begin();
  workspace_.lock.note(begun.is(StatusCode::store_locked), wiring_.clock.now());
  return begun;
}

bool Telecommander::waits_for_lock(std::span<const std::uint8_t> packet) {
  Telecommand telecommand;
  if (!decode_telecommand(packet, wiring_.writer.settings().apid, telecommand).ok() || changes_nothing(telecommand))
    return false;
  return try_store().is(StatusCode::store_locked) &&
         wiring_.clock.now() - workspace_.lock.begin_ns < longest_lock_wait_ns;
}

void Telecommander::release() {
  const TimeNs now = wiring_.clock.now();
  for (int i = 0; i < releases_per_step && !work_.entries.empty(); ++i) {
    const auto* const due = std::find_if(work_.entries.begin(), work_.entries.end(), [&](const ScheduleEntry& entry) {
      return entry.release_ns - (entry.ahead ? capture_lead_ns : 0) <= now;
    });
    // A request that cannot be carried out or removed now stays.
    if (due == work_.entries.end() || try_store().is(StatusCode::store_locked)) return;
    const ScheduleEntry entry = *due;
    release_one(entry, now);
  }
}

void Telecommander::release_one(const ScheduleEntry& entry, TimeNs now) {
  const std::span<std::uint8_t> packet = std::span(workspace_.scheduled_packet).first(entry.bytes);
  Status status = read_blob<ScheduledRecord>(wiring_.store, "packet", entry.id, 0, packet);
  Telecommand telecommand;
  if (status.ok()) status = decode_telecommand(packet, wiring_.writer.settings().apid, telecommand);
  if (status.ok() && !state_.counts.schedule_enabled) status = {StatusCode::release_missed, 0};
  if (status.ok() && now - entry.release_ns > latest_release_ns) {
    status = {StatusCode::release_missed, (now - entry.release_ns) / ns_per_ms};
  }
  if (status.ok()) {
    carry_out(packet, entry.release_ns, &entry);
    return;
  }
  drop_entry(entry.id);
  Answer answer(wiring_.writer, telecommand.request(), telecommand.ack_flags);
  answer.accept();
  answer.finish(status);
  ++state_.counts.received;
  ++state_.counts.accepted;
  ++state_.counts.failed;
  workspace_.counts_changed = true;
}

void Telecommander::drop_entry(std::int64_t id) {
  // A request that cannot be erased now is dropped from memory. After a restart it is too late to be carried out.
  StepTransaction transaction(wiring_.store, checkpoint);
  if (transaction.begin().ok() && erase<ScheduledRecord>(wiring_.store, id).ok()) {
    static_cast<void>(transaction.commit());
  }
  forget_entry(id);
}

void Telecommander::forget_entry(std::int64_t id) {
  std::size_t kept = 0;
  for (const ScheduleEntry& entry : work_.entries) {
    if (entry.id != id) work_.entries[kept++] = entry;
  }
  while (work_.entries.size() > kept) work_.entries.pop_back();
}

void Telecommander::carry_out(std::span<const std::uint8_t> packet, TimeNs nominal_ns, const ScheduleEntry* entry) {
  CommandingRecord& counts = state_.counts;
  ++counts.received;
  workspace_.counts_changed = true;
  Telecommand telecommand;
  const Status decoded = decode_telecommand(packet, wiring_.writer.settings().apid, telecommand);
  if (!decoded.ok() && !can_answer(decoded, packet.size())) {
    ++counts.unanswerable;
    return;
  }
  Answer answer(wiring_.writer, telecommand.request(), telecommand.ack_flags);
  Status status = decoded;
  if (decoded.ok()) {
    workspace_.change.nominal_ns = nominal_ns;
    if (nominal_ns > wiring_.clock.now()) answer.postpone();
    ServiceCall call{wiring_, work_, workspace_, telecommand, answer, workspace_.change};
    status = perform(entry, call);
    if (entry != nullptr && status.is(StatusCode::store_locked)) {
      --counts.received;
      return;
    }
    if (status.ok()) apply_change(workspace_.change);
    if (!status.ok() && entry != nullptr) drop_entry(entry->id);
  }
  if (answer.accepted() || status.ok()) {
    ++counts.accepted;
  } else {
    ++counts.rejected;
  }
  if (status.ok() && !answer.open()) ++counts.completed;
  if (!status.ok() && answer.accepted()) ++counts.failed;
  if (!answer.open() || !status.ok()) answer.finish(status);
  // This comes after the report, because the end of a pass would hold it back.
  if (decoded.ok()) take_effect(answer.accepted() || status.ok(), status, entry == nullptr);
}

void Telecommander::take_effect(bool accepted, const Status& status, bool from_the_link) {
  // A telecommand of the schedule, or one that had come before, shows nothing of the contact that there is now.
  if (wiring_.configuration != nullptr && accepted && from_the_link && workspace_.came_before == 0)
    wiring_.configuration->confirm();
  if (!status.ok() || !workspace_.change.set) return;
  workspace_.set_parameters = true;
  if (wiring_.configuration != nullptr) {
    wiring_.configuration->accept(workspace_.change.wanted, workspace_.change.way);
    // One more: the present one is still to be counted.
    workspace_.came_before = wiring_.router.waiting() + 1;
  } else {
    for (std::size_t i = 0; i < parameter_count(); ++i) {
      const double value = parameter_value(workspace_.change.wanted, i);
      if (value == parameter_value(work_.wanted, i)) continue;
      if (parameter_info(i).acts == Acts::at_once) static_cast<void>(ilp::set_parameter(wiring_.mission, i, value));
    }
  }
  work_.wanted = workspace_.change.wanted;
}

Status Telecommander::perform(const ScheduleEntry* entry, ServiceCall& call) {
  TelecommandChange& change = call.change;
  change.after = state_;
  change.set = false;
  change.rescheduled = false;
  if (entry == nullptr && changes_nothing(call.telecommand)) return serve(call);
  StepTransaction transaction(wiring_.store, checkpoint);
  const Status begun = transaction.begin();
  if (begun.is(StatusCode::store_locked) && entry == nullptr) call.answer.accept();
  ILP_TRY(begun);
  if (entry != nullptr) {
    ILP_TRY(erase<ScheduledRecord>(wiring_.store, entry->id));
    forget_entry(entry->id);
  }
  ILP_TRY(serve(call));
  return transaction.commit(cursor_, change.after, cursor_);
}

void Telecommander::apply_change(const TelecommandChange& change) {
  const CommandingRecord counts = state_.counts;
  state_ = change.after;
  state_.counts = counts;
  state_.counts.schedule_enabled = change.after.counts.schedule_enabled;
  if (change.rescheduled) work_.entries = workspace_.entries_after;
}

Status Telecommander::follow_open_requests() {
  // No request waits; the place among the captures is kept with the next telecommand.
  if (state_.open.empty()) return learn_captures(wiring_, state_).status();
  workspace_.updates.clear();
  State& after = workspace_.change.after = state_;
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TAKE(const bool changed, follow_requests(wiring_, after, workspace_.updates));
  if (!changed) return {};
  ILP_TRY(transaction.commit(cursor_, after, cursor_, state_));
  workspace_.counts_changed = true;
  for (const RequestUpdate& item : workspace_.updates) report_update(item, wiring_.writer);
  return {};
}

}  // namespace ilp
