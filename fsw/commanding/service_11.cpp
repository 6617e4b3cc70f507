// Service 11 of the Telecommander: telecommands that wait for their time.
#include "fsw/commanding/telecommander.hpp"

namespace ilp {
namespace {

/// One item of a report without its packet: sub-schedule, group, time and identifier, as wide as they can be.
constexpr std::size_t item_overhead_bytes = 8 + max_time_bytes + 8;

template <typename Entries, typename Entry>
void insert_in_order(Entries& entries, const Entry& entry) {
  if (!entries.push_back(entry)) return;
  for (std::size_t i = entries.size() - 1; i > 0 && entries[i].release_ns < entries[i - 1].release_ns; --i) {
    const Entry later = entries[i - 1];
    entries[i - 1] = entries[i];
    entries[i] = later;
  }
}

bool listed(const ScheduledIdList& ids, const ScheduledId& name) {
  for (const ScheduledId& id : ids) {
    if (id == name) return true;
  }
  return false;
}

/// Whether the request is a capture, which is given to the camera before its time.
bool goes_ahead(const Telecommand& request) {
  FunctionCall call;
  if (request.service != function_management::service || request.subtype != function_management::perform) return false;
  if (!decode_function(request.data, call).ok()) return false;
  const FunctionInfo* const function = find_function(call.name);
  return function != nullptr && function->function == Function::capture;
}

}  // namespace

Telecommander::Entry Telecommander::entry_of(const ScheduledRecord& scheduled) {
  Entry entry;
  entry.id = scheduled.id;
  entry.release_ns = scheduled.release_ns;
  entry.name = {scheduled.source, scheduled.apid, scheduled.count};
  entry.ahead = scheduled.ahead;
  entry.bytes = scheduled.packet.bytes;
  return entry;
}

Status Telecommander::read_schedule() {
  work_.entries.clear();
  ScheduledRecord scheduled;
  while (!work_.entries.full()) {
    ILP_TAKE(const Found found, find_next(wiring_.store, scheduled.id, scheduled));
    if (found == Found::nothing) break;
    // A damaged request is never carried out, and does not hinder commanding.
    if (found == Found::damaged) continue;
    const Entry entry = entry_of(scheduled);
    // A longer one has never been inserted: the record is damaged.
    if (entry.bytes <= workspace_.scheduled_packet.size()) insert_in_order(work_.entries, entry);
  }
  return {};
}

Status Telecommander::service_11(const Telecommand& telecommand, Answer& answer, Change& change) {
  switch (telecommand.subtype) {
    case scheduling::insert:
      return insert(telecommand, answer, change);
    case scheduling::remove:
      return remove(telecommand, answer, change);
    case scheduling::shift:
      return shift(telecommand, false, answer, change);
    case scheduling::shift_all:
      return shift(telecommand, true, answer, change);
    case scheduling::summary_all:
    case scheduling::summary:
      return report_schedule(telecommand, false, answer);
    case scheduling::detail_all:
    case scheduling::detail:
      return report_schedule(telecommand, true, answer);
    case scheduling::enable:
    case scheduling::disable:
    case scheduling::reset:
      break;
    default:
      return {StatusCode::subtype_unknown, telecommand.service, telecommand.subtype};
  }
  if (!telecommand.data.empty()) return {StatusCode::request_malformed, 0};
  answer.start();
  change.after.counts.schedule_enabled = telecommand.subtype == scheduling::enable;
  if (telecommand.subtype != scheduling::reset) return {};
  for (const Entry& entry : work_.entries) ILP_TRY(erase<ScheduledRecord>(wiring_.store, entry.id));
  workspace_.entries_after.clear();
  change.rescheduled = true;
  return {};
}

Status Telecommander::check_insert(const ScheduleItem& item, std::uint32_t index, TimeNs now,
                                   ScheduledRecord& scheduled) const {
  Telecommand request;
  Status status = decode_telecommand(item.packet, wiring_.writer.settings().apid, request);
  if (!status.ok()) return {status.code, status.a, index};
  if (item.packet.size() > limits::max_scheduled_bytes) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(item.packet.size()),
            static_cast<std::int64_t>(limits::max_scheduled_bytes)};
  }
  if (find_service(request.service) == nullptr) return {StatusCode::service_unknown, request.service, index};
  scheduled.release_ns = wiring_.writer.settings().time.mission(item.release);
  if (scheduled.release_ns < now) return {StatusCode::release_in_past, (now - scheduled.release_ns) / ns_per_ms, index};
  if (scheduled.release_ns - now > farthest_ns) return {StatusCode::time_out_of_range, 0, index};
  const ScheduledId name = scheduled_id(request);
  scheduled.source = name.source;
  scheduled.apid = name.apid;
  scheduled.count = name.count;
  scheduled.sub_schedule = item.sub_schedule;
  scheduled.group = item.group;
  scheduled.ahead = goes_ahead(request);
  scheduled.packet.bytes = static_cast<std::uint32_t>(item.packet.size());
  return {};
}

Status Telecommander::insert(const Telecommand& telecommand, Answer& answer, Change& change) {
  const Tailoring& tailoring = wiring_.writer.settings().tailoring;
  // The form of the whole request is checked first.
  InsertReader form(tailoring, telecommand.data);
  for (ScheduleItem item; form.next(item);) continue;  // bound: the octets of the request
  ILP_TRY(form.status());
  answer.accept();
  const std::size_t room = work_.entries.capacity() - work_.entries.size();
  if (form.count() > room) {
    return {StatusCode::schedule_full, static_cast<std::int64_t>(form.count()),
            static_cast<std::int64_t>(work_.entries.capacity())};
  }
  workspace_.entries_after = work_.entries;
  InsertReader reader(tailoring, telecommand.data);
  const TimeNs now = wiring_.clock.now();
  std::uint32_t index = 0;
  for (ScheduleItem item; reader.next(item); ++index) {  // bound: the room in the schedule
    ScheduledRecord scheduled;
    ILP_TRY(check_insert(item, index, now, scheduled));
    scheduled.id = ++change.after.last_scheduled_id;
    ILP_TRY(put(wiring_.store, scheduled));
    ILP_TRY(write_blob<ScheduledRecord>(wiring_.store, "packet", scheduled.id, 0, item.packet));
    insert_in_order(workspace_.entries_after, entry_of(scheduled));
  }
  answer.start();
  change.rescheduled = true;
  return {};
}

Status Telecommander::check_known(const ScheduledIdList& ids) const {
  for (std::size_t i = 0; i < ids.size(); ++i) {
    bool known = false;
    for (const Entry& entry : work_.entries) known = known || entry.name == ids[i];
    if (!known) return {StatusCode::schedule_unknown, static_cast<std::int64_t>(i)};
  }
  return {};
}

Status Telecommander::remove(const Telecommand& telecommand, Answer& answer, Change& change) {
  ScheduledIdList ids;
  ILP_TRY(decode_scheduled_ids(wiring_.writer.settings().tailoring, telecommand.data, ids));
  answer.accept();
  ILP_TRY(check_known(ids));
  answer.start();
  workspace_.entries_after.clear();
  for (const Entry& entry : work_.entries) {
    if (listed(ids, entry.name)) {
      ILP_TRY(erase<ScheduledRecord>(wiring_.store, entry.id));
    } else {
      static_cast<void>(workspace_.entries_after.push_back(entry));
    }
  }
  change.rescheduled = true;
  return {};
}

Status Telecommander::shift(const Telecommand& telecommand, bool all, Answer& answer, Change& change) {
  ScheduledIdList ids;
  std::int32_t ms = 0;
  if (all) {
    ILP_TRY(decode_shift_all(telecommand.data, ms));
  } else {
    ILP_TRY(decode_shift(wiring_.writer.settings().tailoring, telecommand.data, ms, ids));
  }
  answer.accept();
  ILP_TRY(check_known(ids));
  const TimeNs now = wiring_.clock.now();
  workspace_.entries_after.clear();
  std::int64_t index = 0;
  for (Entry entry : work_.entries) {
    if (all || listed(ids, entry.name)) {
      entry.release_ns += ms * ns_per_ms;
      if (entry.release_ns < now) return {StatusCode::release_in_past, (now - entry.release_ns) / ns_per_ms, index};
      if (entry.release_ns - now > farthest_ns) return {StatusCode::time_out_of_range, 0, index};
      ScheduledRecord scheduled;
      ILP_TRY(get(wiring_.store, entry.id, scheduled));
      scheduled.release_ns = entry.release_ns;
      ILP_TRY(put(wiring_.store, scheduled));
      ++index;
    }
    insert_in_order(workspace_.entries_after, entry);
  }
  answer.start();
  change.rescheduled = true;
  return {};
}

Status Telecommander::report_schedule(const Telecommand& telecommand, bool detail, Answer& answer) {
  const LinkSettings& settings = wiring_.writer.settings();
  const bool all = telecommand.subtype == scheduling::summary_all || telecommand.subtype == scheduling::detail_all;
  ScheduledIdList ids;
  if (all && !telecommand.data.empty()) return {StatusCode::request_malformed, 0};
  if (!all) ILP_TRY(decode_scheduled_ids(settings.tailoring, telecommand.data, ids));
  answer.accept();
  ILP_TRY(check_known(ids));
  answer.start();
  const std::uint8_t subtype = detail ? scheduling::detail_report : scheduling::summary_report;
  // The items go in as many reports as they need; each report is complete by itself.
  const std::size_t head = settings.tailoring.schedule_count == 0 ? 2 : settings.tailoring.schedule_count;
  const std::size_t room =
      workspace_.report.size() - (primary_header_bytes + telemetry_header_bytes + max_time_bytes + crc16_bytes);
  const std::span<std::uint8_t> body = std::span<std::uint8_t>(workspace_.report).subspan(head, room - head);
  ByteWriter items(body);
  std::size_t count = 0;
  const auto send = [&]() -> Status {
    ByteWriter front(workspace_.report);
    encode_report_head(settings.tailoring, count, front);
    ILP_ASSERT(items.ok(), items.size());
    ILP_TRY(answer.report(scheduling::service, subtype, std::span(workspace_.report).first(head + items.size())));
    items = ByteWriter(body);
    count = 0;
    return {};
  };
  for (const Entry& entry : work_.entries) {
    if (!all && !listed(ids, entry.name)) continue;
    ScheduleItem item;
    ScheduledRecord scheduled;
    ILP_TRY(get(wiring_.store, entry.id, scheduled));
    item.sub_schedule = scheduled.sub_schedule;
    item.group = scheduled.group;
    item.release = wiring_.writer.stamp(entry.release_ns);
    item.id = entry.name;
    if (detail) {
      const std::span<std::uint8_t> packet = std::span(workspace_.scheduled_packet).first(entry.bytes);
      ILP_TRY(read_blob<ScheduledRecord>(wiring_.store, "packet", entry.id, 0, packet));
      item.packet = packet;
    }
    const std::size_t needed = item_overhead_bytes + item.packet.size();
    if (items.left() < needed || count == 255) ILP_TRY(send());
    ILP_TRY(detail ? encode_detail_item(settings.tailoring, item, items)
                   : encode_summary_item(settings.tailoring, item, items));
    ++count;
  }
  return count > 0 || work_.entries.empty() ? send() : Status{};
}

}  // namespace ilp
