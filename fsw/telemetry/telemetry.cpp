#include "fsw/telemetry/telemetry.hpp"

#include <cstring>

#include "cfg/version.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/base/text.hpp"
#include "fsw/downlink/file_delivery.hpp"
#include "fsw/shared/find.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr int events_per_step = 16;
// If events come faster than the link takes them, the rest waits in the store.
constexpr std::uint32_t most_waiting = 16;

std::uint8_t number_of(const char* component) {
  for (const Stage& stage : schedule) {
    if (std::strcmp(stage.name, component) == 0) return static_cast<std::uint8_t>(stage.component);
  }
  return 0;
}

/// Writes the value in the octets of the tailoring, or the nearest value that they can hold.
void write_signed(std::int64_t value, std::size_t octets, ByteWriter& out) {
  if (octets < 8) {
    const std::int64_t most = (std::int64_t{1} << (8 * octets - 1)) - 1;
    if (value > most) value = most;
    if (value < -most - 1) value = -most - 1;
    out.number(static_cast<std::uint64_t>(value) & ((std::uint64_t{1} << (8 * octets)) - 1), octets);
    return;
  }
  out.number(static_cast<std::uint64_t>(value), octets);
}

std::uint32_t fingerprint(const MissionParameters& mission) {
  std::uint32_t crc = 0;
  std::uint16_t number = 0;
  // In order of number, whatever the order of the table.
  for (std::size_t n = 0; n < parameter_count(); ++n) {
    std::size_t least = parameter_count();
    for (std::size_t i = 0; i < parameter_count(); ++i) {
      if (parameter_info(i).number <= number) continue;
      if (least == parameter_count() || parameter_info(i).number < parameter_info(least).number) least = i;
    }
    number = parameter_info(least).number;
    std::array<std::uint8_t, 8> octets{};
    ByteWriter out(octets);
    out.f64(parameter_value(mission, least));
    crc = crc32(octets, crc);
  }
  return crc;
}

/// The numbers of "1.2.3".
void read_version(const char* text, PackageStatus& status) {
  std::uint8_t* const numbers[] = {&status.version_major, &status.version_minor, &status.version_patch};
  std::size_t part = 0;
  for (const char* c = text; *c != 0 && part < 3; ++c) {
    if (*c == '.') {
      ++part;
    } else {
      *numbers[part] = static_cast<std::uint8_t>(*numbers[part] * 10 + (*c - '0'));
    }
  }
}

}  // namespace

constexpr CheckpointForm TelemetryReporter::checkpoint = checkpoint_form<State>(component_id);

TelemetryReporter::TelemetryReporter(Tables store, PacketRouter& router, TelemetryWriter& writer, Clock& clock,
                                     const MissionParameters& mission, TelemetrySources sources)
    : wiring_{store, router, writer, clock, mission, sources} {}

Status TelemetryReporter::restore() {
  work_ = {};
  const Status status = restore_checkpoint(wiring_.store, checkpoint, cursor_, state_);
  begin_ids<EventRecord>(wiring_.store, cursor_.first);
  begin_ids<CommandRecord>(wiring_.store, cursor_.second);
  if (!status.is(StatusCode::store_build)) return status;
  // A state of another layout is dropped, and with it what was commanded until now.
  return newest_id<CommandRecord>(wiring_.store, cursor_.second);
}

StepResult TelemetryReporter::step() {
  // Without a link no command for telemetry can come.
  if (!wiring_.router.present()) return {};
  Status status;
  for (Status (TelemetryReporter::*part)() : {&TelemetryReporter::obey_commands, &TelemetryReporter::report_events,
                                              &TelemetryReporter::save_cursor, &TelemetryReporter::send_due}) {
    const Status done = (this->*part)();
    if (status.ok()) status = done;
  }
  // The component that needs room reports a full store; housekeeping goes on, and shows it.
  return {status.is(StatusCode::store_full) ? Status{} : status, false};
}

Status TelemetryReporter::report_events() {
  for (int i = 0; i < events_per_step && wiring_.writer.waiting() < most_waiting; ++i) {
    EventRecord event;
    ILP_TAKE(const Found found, find_next(wiring_.store, cursor_.first, event));
    if (found == Found::nothing) break;
    // The scrubber reports the damage; the next events are not kept waiting.
    if (found == Found::valid) ILP_TRY(report_event(event));
    cursor_.first = event.id;
    work_.cursor_unsaved = true;
  }
  return {};
}

Status TelemetryReporter::save_cursor() {
  if (!work_.cursor_unsaved) return {};
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(transaction.commit(cursor_, state_, cursor_));
  work_.cursor_unsaved = false;
  return {};
}

Status TelemetryReporter::report_event(const EventRecord& event) {
  if (event.code < state_.disabled.size() && state_.disabled[event.code] != 0) return {};
  const Tailoring& tailoring = wiring_.writer.settings().tailoring;
  std::array<std::uint8_t, 128> octets{};
  ByteWriter auxiliary(octets);
  auxiliary.number(number_of(event.component), tailoring.event_reporter);
  write_signed(event.a, tailoring.event_value, auxiliary);
  write_signed(event.b, tailoring.event_value, auxiliary);
  auxiliary.u32(static_cast<std::uint32_t>(event.id));
  ILP_TRY(encode_time(tailoring.time, wiring_.writer.stamp(event.time_ns), auxiliary));
  const std::size_t place_bytes = strnlen(event.place, sizeof(event.place));
  auxiliary.put({reinterpret_cast<const std::uint8_t*>(event.place), place_bytes});
  ByteWriter out(workspace_.report);
  encode_event(tailoring, event.code, auxiliary.written(), out);
  ILP_ASSERT(auxiliary.ok() && out.ok(), event.code);
  const auto severity = static_cast<std::uint8_t>(event.severity & 3U);
  return wiring_.writer.report(event_reporting::service,
                               static_cast<std::uint8_t>(event_reporting::informative + severity), 0, out.written());
}

Status TelemetryReporter::send_due() {
  const TimeNs now = wiring_.clock.now();
  Status status;
  for (const ReportInfo& report : report_table()) {
    const std::size_t i = report.id;
    if (state_.enabled[i] == 0 || now < work_.due_ns[i]) continue;
    if (wiring_.writer.waiting() != 0) break;
    const Status sent = send(report);
    if (status.ok()) status = sent;
    work_.due_ns[i] += state_.interval_ns[i];
    if (work_.due_ns[i] <= now) work_.due_ns[i] = now + state_.interval_ns[i];
  }
  return status;
}

Status TelemetryReporter::send(const ReportInfo& report) {
  ByteWriter out(workspace_.report);
  encode_report_id(wiring_.writer.settings().tailoring, report.id, out);
  ILP_TRY(write_values(report, out));
  ILP_ASSERT(out.ok(), report.id);
  return wiring_.writer.report(housekeeping::service, housekeeping::report, 0, out.written());
}

Status TelemetryReporter::write_values(const ReportInfo& report, ByteWriter& out) {
  switch (report.source) {
    case ReportSource::status: {
      PackageStatus status;
      ILP_TRY(package_status(status));
      write_report_values(report, &status, out);
      return {};
    }
    case ReportSource::link: {
      const LinkCounts counts = link_counts();
      write_report_values(report, &counts, out);
      return {};
    }
    case ReportSource::components:
      for (std::size_t i = 0; i < report.repeats; ++i) {
        ILP_TAKE(const ComponentHealth values, health(static_cast<ComponentId>(i + 1)));
        write_report_values(report, &values, out);
      }
      return {};
    case ReportSource::nodes: {
      NodeRecord node;
      for (std::size_t i = 0; i < report.repeats; ++i) {
        ILP_TAKE(const NodeHealth values, next_node(node));
        write_report_values(report, &values, out);
      }
      return {};
    }
    case ReportSource::first:
    case ReportSource::newest:
      break;
  }
  const RecordInfo& info = record_info(report.record);
  const Status found = report.source == ReportSource::first ? wiring_.store.get(info, 1, workspace_.record.data())
                                                            : wiring_.store.last(info, workspace_.record.data());
  if (found.is(StatusCode::not_found)) {
    workspace_.record = {};
  } else {
    ILP_TRY(found);
  }
  write_report_values(report, workspace_.record.data(), out);
  return {};
}

Status TelemetryReporter::package_status(PackageStatus& status) {
  std::int64_t newest = 0;
  ILP_TRY(newest_id<EventRecord>(wiring_.store, newest));
  read_version(software_version, status);
  status.mission_time_ns = wiring_.clock.now();
  status.contact = wiring_.router.contact();
  status.parameters_crc32 = fingerprint(wiring_.mission);
  if (wiring_.sources.health != nullptr) {
    status.frames_run = static_cast<std::uint32_t>(wiring_.sources.health->frames_run());
    status.frame_overruns = wiring_.sources.health->frame_overruns();
  }
  status.events = static_cast<std::uint32_t>(newest);
  status.events_untold = static_cast<std::uint32_t>(newest > cursor_.first ? newest - cursor_.first : 0);
  for (const std::uint8_t disabled : state_.disabled) status.events_disabled += disabled;
  return {};
}

LinkCounts TelemetryReporter::link_counts() const {
  const RouterCounts& router = wiring_.router.counts();
  LinkCounts counts;
  counts.received = router.received;
  counts.sent = router.sent;
  counts.malformed = router.malformed;
  counts.unknown_apid = router.unknown_apid;
  counts.refused = router.refused;
  counts.dropped = router.dropped;
  counts.reports_sent = wiring_.writer.sent();
  counts.reports_lost = wiring_.writer.lost();
  counts.reports_waiting = wiring_.writer.waiting();
  if (wiring_.sources.delivery == nullptr) return counts;
  counts.pdus_in = wiring_.sources.delivery->pdus_in;
  counts.pdus_out = wiring_.sources.delivery->pdus_out;
  counts.pdus_rejected = wiring_.sources.delivery->rejected;
  counts.pdus_ignored = wiring_.sources.delivery->ignored;
  counts.files_delivered = wiring_.sources.delivery->delivered;
  counts.files_refused = wiring_.sources.delivery->refused;
  counts.files_cancelled = wiring_.sources.delivery->cancelled;
  return counts;
}

/// The component's process writes its counts now and then.
Result<ComponentHealth> TelemetryReporter::health(ComponentId component) {
  if (wiring_.sources.health == nullptr) return ComponentHealth{};
  if (wiring_.sources.health->runs(component)) {
    const ComponentStats& stats = wiring_.sources.health->stats(component);
    return ComponentHealth{stats.steps, stats.overruns, stats.restarts, stats.faults, stats.busy_ns, stats.longest_ns};
  }
  ComponentRecord kept;
  ILP_TAKE(const bool found, find(wiring_.store, static_cast<std::int64_t>(component), kept));
  if (!found) return ComponentHealth{};
  return ComponentHealth{kept.steps, kept.overruns, kept.restarts, kept.faults, kept.busy_ns, kept.longest_ns};
}

/// `node` is the one before; afterwards it is this one. Zeros after the last one.
Result<NodeHealth> TelemetryReporter::next_node(NodeRecord& node) {
  ILP_TAKE(const bool found, found_by(next(wiring_.store, node.id, node)));
  if (!found) return NodeHealth{};
  return NodeHealth{node.stages,      node.started_ns, wiring_.clock.now() - node.seen_ns,
                    node.connections, node.overruns,   node.longest_ns};
}

}  // namespace ilp
