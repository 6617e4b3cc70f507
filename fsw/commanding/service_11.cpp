// Service 11, time-based scheduling: telecommands that wait for their release times.
#include <algorithm>
#include <utility>

#include "fsw/commanding/function_table.hpp"
#include "fsw/commanding/telecommand_service.hpp"
#include "fsw/packets/service_functions.hpp"

namespace ilp {
namespace {

/// One item of a report without its packet: sub-schedule, group, time and identifier, as wide as they can be.
constexpr std::size_t item_overhead_bytes = 8 + max_time_bytes + 8;

using Entries = decltype(CommandingWork::entries);

void insert_in_order(Entries& entries, const ScheduleEntry& entry) {
  if (!entries.push_back(entry)) return;
  for (std::size_t i = entries.size() - 1; i > 0 && entries[i].release_ns < entries[i - 1].release_ns; --i) {
    std::swap(entries[i], entries[i - 1]);
  }
}

bool listed(const ScheduledIdList& ids, const ScheduledId& name) {
  return std::find(ids.begin(), ids.end(), name) != ids.end();
}

/// Whether the request is a capture, which is given to the camera before its time.
bool is_capture_ahead(const Telecommand& request) {
  FunctionCall call;
  if (request.service != function_management::service || request.subtype != function_management::perform) return false;
  if (!decode_function(request.data, call).ok()) return false;
  const FunctionInfo* const function = find_function(call.name);
  return function != nullptr && function->function == Function::capture;
}

ScheduleEntry entry_of(const ScheduledRecord& scheduled) {
  const ScheduledId name{scheduled.source, scheduled.apid, scheduled.count};
  return {scheduled.id, scheduled.release_ns, name, scheduled.ahead, scheduled.packet.bytes};
}

Status check_insert(const ScheduleItem& item, std::uint32_t index, TimeNs now, const LinkSettings& settings,
                    ScheduledRecord& scheduled) {
  Telecommand request;
  Status status = decode_telecommand(item.packet, settings.apid, request);
  if (!status.ok()) return {status.code, status.a, index};
  if (item.packet.size() > limits::max_scheduled_bytes) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(item.packet.size()),
            static_cast<std::int64_t>(limits::max_scheduled_bytes)};
  }
  if (find_service(request.service) == nullptr) return {StatusCode::service_unknown, request.service, index};
  scheduled.release_ns = settings.time.mission(item.release);
  if (scheduled.release_ns < now) return {StatusCode::release_in_past, (now - scheduled.release_ns) / ns_per_ms, index};
  if (scheduled.release_ns - now > farthest_ns) return {StatusCode::time_out_of_range, 0, index};
  const ScheduledId name = scheduled_id(request);
  scheduled.source = name.source;
  scheduled.apid = name.apid;
  scheduled.count = name.count;
  scheduled.sub_schedule = item.sub_schedule;
  scheduled.group = item.group;
  scheduled.ahead = is_capture_ahead(request);
  scheduled.packet.bytes = static_cast<std::uint32_t>(item.packet.size());
  return {};
}

Status insert(ServiceCall& call) {
  // The form of the whole request is checked first.
  InsertReader form(call.tailoring(), call.telecommand.data);
  for (ScheduleItem item; form.next(item);) continue;  // bound: the octets of the request
  ILP_TRY(form.status());
  call.answer.accept();
  const std::size_t free_slots = call.work.entries.capacity() - call.work.entries.size();
  if (form.count() > free_slots) {
    return {StatusCode::schedule_full, static_cast<std::int64_t>(form.count()),
            static_cast<std::int64_t>(call.work.entries.capacity())};
  }
  call.workspace.entries_after = call.work.entries;
  InsertReader reader(call.tailoring(), call.telecommand.data);
  const TimeNs now = call.now();
  std::uint32_t index = 0;
  for (ScheduleItem item; reader.next(item); ++index) {  // bound: the room in the schedule
    ScheduledRecord scheduled;
    ILP_TRY(check_insert(item, index, now, call.wiring.writer.settings(), scheduled));
    scheduled.id = ++call.change.after.last_scheduled_id;
    ILP_TRY(put(call.wiring.store, scheduled));
    ILP_TRY(write_blob<ScheduledRecord>(call.wiring.store, "packet", scheduled.id, 0, item.packet));
    insert_in_order(call.workspace.entries_after, entry_of(scheduled));
  }
  call.answer.start();
  call.change.rescheduled = true;
  return {};
}

Status check_known(const ScheduledIdList& ids, const CommandingWork& work) {
  for (std::size_t i = 0; i < ids.size(); ++i) {
    bool known = false;
    for (const ScheduleEntry& entry : work.entries) known = known || entry.name == ids[i];
    if (!known) return {StatusCode::schedule_unknown, static_cast<std::int64_t>(i)};
  }
  return {};
}

Status remove(ServiceCall& call) {
  ScheduledIdList ids;
  ILP_TRY(decode_scheduled_ids(call.tailoring(), call.telecommand.data, ids));
  call.answer.accept();
  ILP_TRY(check_known(ids, call.work));
  call.answer.start();
  call.workspace.entries_after.clear();
  for (const ScheduleEntry& entry : call.work.entries) {
    if (listed(ids, entry.name)) {
      ILP_TRY(erase<ScheduledRecord>(call.wiring.store, entry.id));
    } else {
      static_cast<void>(call.workspace.entries_after.push_back(entry));
    }
  }
  call.change.rescheduled = true;
  return {};
}

Status shift(bool all, ServiceCall& call) {
  ScheduledIdList ids;
  std::int32_t ms = 0;
  if (all) {
    ILP_TRY(decode_shift_all(call.telecommand.data, ms));
  } else {
    ILP_TRY(decode_shift(call.tailoring(), call.telecommand.data, ms, ids));
  }
  call.answer.accept();
  ILP_TRY(check_known(ids, call.work));
  const TimeNs now = call.now();
  call.workspace.entries_after.clear();
  std::int64_t index = 0;
  for (ScheduleEntry entry : call.work.entries) {
    if (all || listed(ids, entry.name)) {
      entry.release_ns += ms * ns_per_ms;
      if (entry.release_ns < now) return {StatusCode::release_in_past, (now - entry.release_ns) / ns_per_ms, index};
      if (entry.release_ns - now > farthest_ns) return {StatusCode::time_out_of_range, 0, index};
      ScheduledRecord scheduled;
      ILP_TRY(get(call.wiring.store, entry.id, scheduled));
      scheduled.release_ns = entry.release_ns;
      ILP_TRY(put(call.wiring.store, scheduled));
      ++index;
    }
    insert_in_order(call.workspace.entries_after, entry);
  }
  call.answer.start();
  call.change.rescheduled = true;
  return {};
}

Status report(bool detail, ServiceCall& call) {
  const LinkSettings& settings = call.wiring.writer.settings();
  const bool all =
      call.telecommand.subtype == scheduling::summary_all || call.telecommand.subtype == scheduling::detail_all;
  ScheduledIdList ids;
  if (all && !call.telecommand.data.empty()) return {StatusCode::request_malformed, 0};
  if (!all) ILP_TRY(decode_scheduled_ids(settings.tailoring, call.telecommand.data, ids));
  call.answer.accept();
  ILP_TRY(check_known(ids, call.work));
  call.answer.start();
  const std::uint8_t subtype = detail ? scheduling::detail_report : scheduling::summary_report;
  // The items go in as many reports as they need; each report is complete by itself.
  const std::size_t head = settings.tailoring.schedule_count == 0 ? 2 : settings.tailoring.schedule_count;
  const std::size_t free_slots =
      call.workspace.report.size() - (primary_header_bytes + telemetry_header_bytes + max_time_bytes + crc16_bytes);
  const std::span<std::uint8_t> body = std::span<std::uint8_t>(call.workspace.report).subspan(head, free_slots - head);
  ByteWriter items(body);
  std::size_t count = 0;
  const auto send = [&]() -> Status {
    ByteWriter front(call.workspace.report);
    encode_report_head(settings.tailoring, count, front);
    ILP_ASSERT(items.ok(), items.size());
    ILP_TRY(
        call.answer.report(scheduling::service, subtype, std::span(call.workspace.report).first(head + items.size())));
    items = ByteWriter(body);
    count = 0;
    return {};
  };
  for (const ScheduleEntry& entry : call.work.entries) {
    if (!all && !listed(ids, entry.name)) continue;
    ScheduledRecord scheduled;
    ILP_TRY(get(call.wiring.store, entry.id, scheduled));
    ScheduleItem item{.sub_schedule = scheduled.sub_schedule,
                      .group = scheduled.group,
                      .release = call.wiring.writer.stamp(entry.release_ns),
                      .packet = {},
                      .id = entry.name};
    if (detail) {
      const std::span<std::uint8_t> packet = std::span(call.workspace.scheduled_packet).first(entry.bytes);
      ILP_TRY(read_blob<ScheduledRecord>(call.wiring.store, "packet", entry.id, 0, packet));
      item.packet = packet;
    }
    const std::size_t needed = item_overhead_bytes + item.packet.size();
    if (items.left() < needed || count == 255) ILP_TRY(send());
    ILP_TRY(detail ? encode_detail_item(settings.tailoring, item, items)
                   : encode_summary_item(settings.tailoring, item, items));
    ++count;
  }
  return count > 0 || call.work.entries.empty() ? send() : Status{};
}

}  // namespace

Status read_schedule(const CommandingWiring& wiring, CommandingWork& work) {
  work.entries.clear();
  ScheduledRecord scheduled;
  while (!work.entries.full()) {
    ILP_TAKE(const Found found, find_next(wiring.store, scheduled.id, scheduled));
    if (found == Found::nothing) break;
    // A damaged request is never carried out, and does not hinder commanding.
    if (found == Found::damaged) continue;
    const ScheduleEntry entry = entry_of(scheduled);
    // A longer one has never been inserted: the record is damaged.
    if (entry.bytes <= limits::max_scheduled_bytes) insert_in_order(work.entries, entry);
  }
  return {};
}

Status serve_schedule(ServiceCall& call) {
  switch (call.telecommand.subtype) {
    case scheduling::insert:
      return insert(call);
    case scheduling::remove:
      return remove(call);
    case scheduling::shift:
      return shift(false, call);
    case scheduling::shift_all:
      return shift(true, call);
    case scheduling::summary_all:
    case scheduling::summary:
      return report(false, call);
    case scheduling::detail_all:
    case scheduling::detail:
      return report(true, call);
    case scheduling::enable:
    case scheduling::disable:
    case scheduling::reset:
      break;
    default:
      return call.subtype_unknown();
  }
  if (!call.telecommand.data.empty()) return {StatusCode::request_malformed, 0};
  call.answer.start();
  call.change.after.counts.schedule_enabled = call.telecommand.subtype == scheduling::enable;
  if (call.telecommand.subtype != scheduling::reset) return {};
  for (const ScheduleEntry& entry : call.work.entries) ILP_TRY(erase<ScheduledRecord>(call.wiring.store, entry.id));
  call.workspace.entries_after.clear();
  call.change.rescheduled = true;
  return {};
}

}  // namespace ilp
