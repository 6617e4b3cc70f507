#include "fsw/commanding/telecommander.hpp"

#include "fsw/commanding/settings.hpp"
#include "fsw/packets/service_events.hpp"
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

}  // namespace

constexpr CheckpointForm Telecommander::checkpoint = checkpoint_form<State>(component_id);

Telecommander::Telecommander(Tables store, PacketRouter& router, TelemetryWriter& writer, Clock& clock,
                             MissionParameters& mission, Configuration* configuration)
    : store_(store),
      router_(router),
      writer_(writer),
      clock_(clock),
      mission_(mission),
      configuration_(configuration),
      wanted_(mission) {}

constexpr Telecommander::ServiceRow Telecommander::services[] = {
    {housekeeping::service, &Telecommander::service_3},
    {event_reporting::service, &Telecommander::service_5},
    {function_management::service, &Telecommander::service_8},
    {scheduling::service, &Telecommander::service_11},
    {test_service::service, &Telecommander::service_17},
    {parameter_management::service, &Telecommander::service_20},
};

const Telecommander::ServiceRow* Telecommander::find_service(std::uint8_t service) {
  for (const ServiceRow& row : services) {
    if (row.service == service) return &row;
  }
  return nullptr;
}

/// Neither in the store nor in the mission: tests, and reports of what the telecommander knows or reads.
bool Telecommander::changes_nothing(const Telecommand& telecommand) {
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

Status Telecommander::restore() {
  const Status loaded = restore_checkpoint(store_, checkpoint, cursor_, state_);
  if (!restored(loaded)) return loaded;
  begin_ids<CommandRecord>(store_, state_.last_request_id);
  begin_ids<ScheduledRecord>(store_, state_.last_scheduled_id);
  if (state_.open.empty()) {
    // No request waits for the existing captures.
    CaptureRecord newest;
    const Status found = last(store_, newest);
    // A damaged record does not hinder commanding.
    const bool damaged = found.is(StatusCode::record_damaged);
    if (!found.ok() && !found.is(StatusCode::not_found) && !damaged) return found;
    if (found.ok()) state_.last_capture_id = newest.id;
    if (damaged) state_.last_capture_id = found.a;
  }
  if (configuration_ != nullptr) {
    wanted_ = configuration_->wanted();
    ILP_TRY(read_schedule());
    return loaded;
  }
  wanted_ = mission_;
  const Status settings = load_settings(store_, wanted_);
  if (!settings.ok() && !settings.is(StatusCode::setting_ignored)) return settings;
  ILP_TRY(read_schedule());
  return loaded;
}

StepResult Telecommander::step() {
  set_parameters_ = false;
  Status status = router_.pump();
  const StatusCode pump_fault = status.code;
  if (status.is(pump_fault_)) status = {};
  pump_fault_ = pump_fault;
  const Status followed = follow_requests();
  if (status.ok() && !followed.ok()) status = followed;
  release();
  receive();
  writer_.flush();
  if (++frames_ % frames_between_counts == 0) {
    const Status written = write_counts();
    if (status.ok()) status = written;
  }
  const Status news = news_of_configuration();
  if (status.ok()) status = news;
  if (status.ok() && writer_.waiting() == 0 && writer_.lost() != reported_lost_) {
    status = {StatusCode::telemetry_lost, writer_.lost() - reported_lost_};
    reported_lost_ = writer_.lost();
  }
  return {status, false, Then::go_on, set_parameters_};
}

Status Telecommander::news_of_configuration() {
  if (configuration_ == nullptr) return {};
  if (configuration_->step(clock_.now())) {
    wanted_ = configuration_->wanted();
    set_parameters_ = true;
  }
  return configuration_->news();
}

Status Telecommander::write_counts() {
  CommandingRecord& counts = state_.counts;
  const bool reports_changed = counts.reports_sent != writer_.sent() || counts.reports_lost != writer_.lost() ||
                               counts.reports_waiting != writer_.waiting();
  if (!counts_changed_ && !reports_changed) return {};
  counts.reports_sent = writer_.sent();
  counts.reports_lost = writer_.lost();
  counts.reports_waiting = writer_.waiting();
  counts.open = static_cast<std::uint32_t>(state_.open.size());
  counts.scheduled = static_cast<std::uint32_t>(entries_.size());
  StepTransaction transaction(store_, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store_, counts));
  ILP_TRY(transaction.commit(cursor_, state_, cursor_));
  counts_changed_ = false;
  return {};
}

void Telecommander::receive() {
  for (int i = 0; i < packets_per_step; ++i) {
    std::size_t bytes = packet_bytes_;
    if (bytes == 0 && !router_.receive(Channel::commands, packet_, bytes).ok()) return;
    packet_bytes_ = 0;
    if (waits_for_lock({packet_.data(), bytes})) {
      packet_bytes_ = bytes;
      return;
    }
    carry_out({packet_.data(), bytes}, clock_.now(), nullptr);
    if (came_before_ > 0) --came_before_;
  }
}

Status Telecommander::try_store() {
  Transaction transaction(store_);
  const Status begun = transaction.begin();
  if (!begun.is(StatusCode::store_locked)) {
    locked_since_ns_ = -1;
  } else if (locked_since_ns_ < 0) {
    locked_since_ns_ = clock_.now();
  }
  return begun;
}

bool Telecommander::waits_for_lock(std::span<const std::uint8_t> packet) {
  Telecommand telecommand;
  if (!decode_telecommand(packet, writer_.settings().apid, telecommand).ok() || changes_nothing(telecommand))
    return false;
  return try_store().is(StatusCode::store_locked) && clock_.now() - locked_since_ns_ < longest_lock_wait_ns;
}

void Telecommander::release() {
  const TimeNs now = clock_.now();
  for (int i = 0; i < releases_per_step && !entries_.empty(); ++i) {
    const Entry* due = nullptr;
    for (const Entry& entry : entries_) {
      const TimeNs lead = entry.ahead ? capture_lead_ns : 0;
      if (due == nullptr && entry.release_ns - lead <= now) due = &entry;
    }
    // A request that cannot be carried out or removed now stays.
    if (due == nullptr || try_store().is(StatusCode::store_locked)) return;
    const Entry entry = *due;
    release_one(entry, now);
  }
}

void Telecommander::release_one(const Entry& entry, TimeNs now) {
  const std::span<std::uint8_t> packet = std::span(scheduled_packet_).first(entry.bytes);
  Status status = read_blob<ScheduledRecord>(store_, "packet", entry.id, 0, packet);
  Telecommand telecommand;
  if (status.ok()) status = decode_telecommand(packet, writer_.settings().apid, telecommand);
  if (status.ok() && !state_.counts.schedule_enabled) status = {StatusCode::release_missed, 0};
  if (status.ok() && now - entry.release_ns > latest_release_ns) {
    status = {StatusCode::release_missed, (now - entry.release_ns) / ns_per_ms};
  }
  if (status.ok()) {
    carry_out(packet, entry.release_ns, &entry);
    return;
  }
  drop_entry(entry.id);
  Answer answer(writer_, telecommand.request(), telecommand.ack_flags);
  answer.accept();
  answer.finish(status);
  ++state_.counts.received;
  ++state_.counts.accepted;
  ++state_.counts.failed;
  counts_changed_ = true;
}

void Telecommander::drop_entry(std::int64_t id) {
  // A request that cannot be erased now is dropped from memory. After a restart it is too late to be carried out.
  StepTransaction transaction(store_, checkpoint);
  if (transaction.begin().ok() && erase<ScheduledRecord>(store_, id).ok()) {
    static_cast<void>(transaction.commit());
  }
  forget_entry(id);
}

void Telecommander::forget_entry(std::int64_t id) {
  std::size_t kept = 0;
  for (const Entry& entry : entries_) {
    if (entry.id != id) entries_[kept++] = entry;
  }
  while (entries_.size() > kept) entries_.pop_back();
}

void Telecommander::carry_out(std::span<const std::uint8_t> packet, TimeNs nominal_ns, const Entry* entry) {
  CommandingRecord& counts = state_.counts;
  ++counts.received;
  counts_changed_ = true;
  Telecommand telecommand;
  const Status decoded = decode_telecommand(packet, writer_.settings().apid, telecommand);
  if (!decoded.ok() && !can_answer(decoded, packet.size())) {
    ++counts.unanswerable;
    return;
  }
  Answer answer(writer_, telecommand.request(), telecommand.ack_flags);
  Status status = decoded;
  if (decoded.ok()) {
    work_.nominal_ns = nominal_ns;
    if (nominal_ns > clock_.now()) answer.postpone();
    status = perform(telecommand, entry, answer, work_);
    if (entry != nullptr && status.is(StatusCode::store_locked)) {
      --counts.received;
      return;
    }
    settle(work_, status.ok());
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
  if (configuration_ != nullptr && accepted && from_the_link && came_before_ == 0) configuration_->confirm();
  if (!status.ok() || !work_.set) return;
  set_parameters_ = true;
  if (configuration_ != nullptr) {
    configuration_->settle(work_.wanted, work_.way);
    // One more: the present one is still to be counted.
    came_before_ = router_.waiting() + 1;
  } else {
    for (std::size_t i = 0; i < parameter_count(); ++i) {
      const double value = parameter_value(work_.wanted, i);
      if (value == parameter_value(wanted_, i)) continue;
      if (parameter_info(i).acts == Acts::at_once) static_cast<void>(ilp::set_parameter(mission_, i, value));
    }
  }
  wanted_ = work_.wanted;
}

Status Telecommander::perform(const Telecommand& telecommand, const Entry* entry, Answer& answer, Work& work) {
  work.after = state_;
  work.set = false;
  work.way = Configuration::Way::parameters;
  work.rescheduled = false;
  if (entry == nullptr && changes_nothing(telecommand)) return serve(telecommand, answer, work);
  StepTransaction transaction(store_, checkpoint);
  const Status begun = transaction.begin();
  if (begun.is(StatusCode::store_locked) && entry == nullptr) answer.accept();
  ILP_TRY(begun);
  if (entry != nullptr) {
    ILP_TRY(erase<ScheduledRecord>(store_, entry->id));
    forget_entry(entry->id);
  }
  ILP_TRY(serve(telecommand, answer, work));
  return transaction.commit(cursor_, work.after, cursor_);
}

void Telecommander::settle(const Work& work, bool committed) {
  if (!committed) return;
  const CommandingRecord counts = state_.counts;
  const Flag enabled = work.after.counts.schedule_enabled;
  state_ = work.after;
  state_.counts = counts;
  state_.counts.schedule_enabled = enabled;
  if (work.rescheduled) entries_ = entries_after_;
}

Status Telecommander::serve(const Telecommand& telecommand, Answer& answer, Work& work) {
  const ServiceRow* const row = find_service(telecommand.service);
  if (row == nullptr) return {StatusCode::service_unknown, telecommand.service};
  return (this->*row->carry_out)(telecommand, answer, work);
}

}  // namespace ilp
