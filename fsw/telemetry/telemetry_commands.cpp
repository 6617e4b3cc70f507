// Carries out the ground's commands to telemetry (services 3 and 5), which are records of `command`.
#include "fsw/packets/service_events.hpp"
#include "fsw/telemetry/telemetry.hpp"

namespace ilp {
namespace {

// A telecommand has at most this many items and one for all events.
constexpr std::size_t commands_per_step = limits::max_event_list + 1;

bool is_for_telemetry(CommandKind kind) {
  switch (kind) {
    case CommandKind::report_enable:
    case CommandKind::report_disable:
    case CommandKind::report_once:
    case CommandKind::report_interval:
    case CommandKind::event_enable:
    case CommandKind::event_disable:
    case CommandKind::events_report:
      return true;
    default:
      return false;
  }
}

}  // namespace

Status TelemetryReporter::obey_commands() {
  Status status;
  for (std::size_t i = 0; i < commands_per_step; ++i) {
    CommandRecord command;
    ILP_TAKE(const Found found, find_next(wiring_.store, cursor_.second, command));
    if (found == Found::nothing) break;
    if (found == Found::valid && is_for_telemetry(command.kind)) {
      const Status obeyed = obey(command);
      if (is_transient(obeyed)) return obeyed;
      if (status.ok()) status = obeyed;
      work_.cursor_unsaved = true;
    }
    cursor_.second = command.id;
  }
  return status;
}

Status TelemetryReporter::obey(const CommandRecord& command) {
  switch (command.kind) {
    case CommandKind::event_enable:
    case CommandKind::event_disable:
      switch_events(command.subject_id, command.kind == CommandKind::event_disable);
      return {};
    case CommandKind::events_report:
      return report_disabled(static_cast<std::uint16_t>(command.tag));
    case CommandKind::report_enable:
    case CommandKind::report_disable:
    case CommandKind::report_once:
    case CommandKind::report_interval:
      break;
    default:
      return {};
  }
  const ReportInfo* const report = find_report(static_cast<std::uint64_t>(command.subject_id));
  if (report == nullptr) return {};
  if (command.kind == CommandKind::report_once) return send(*report);
  const TimeNs now = wiring_.clock.now();
  std::uint8_t& enabled = state_.enabled[report->id];
  TimeNs& interval = state_.interval_ns[report->id];
  TimeNs& due = work_.due_ns[report->id];
  if (command.kind == CommandKind::report_interval) {
    interval = command.at_ns;
  } else {
    // The first report goes at once.
    if (command.kind == CommandKind::report_enable && enabled == 0) due = now;
    enabled = command.kind == CommandKind::report_enable ? 1 : 0;
  }
  // The next one goes not later than the interval says.
  if (due > now + interval) due = now + interval;
  return {};
}

void TelemetryReporter::switch_events(std::int64_t event, bool disable) {
  const std::uint8_t disabled = disable ? 1 : 0;
  if (event > 0 && event < static_cast<std::int64_t>(event_count)) {
    state_.disabled[static_cast<std::size_t>(event)] = disabled;
  }
  // `ok` is no event.
  for (std::size_t id = 1; event == 0 && id < event_count; ++id) state_.disabled[id] = disabled;
}

Status TelemetryReporter::report_disabled(std::uint16_t destination) {
  FixedVector<std::uint32_t, event_count> ids;
  for (std::size_t id = 1; id < event_count; ++id) {
    if (state_.disabled[id] != 0) static_cast<void>(ids.push_back(static_cast<std::uint32_t>(id)));
  }
  ByteWriter out(workspace_.report);
  encode_disabled_events(wiring_.writer.settings().tailoring, {ids.data(), ids.size()}, out);
  ILP_ASSERT(out.ok(), ids.size());
  return wiring_.writer.report(event_reporting::service, event_reporting::disabled, destination, out.written());
}

}  // namespace ilp
