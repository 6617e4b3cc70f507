// Service 5 of the Telecommander: which events are reported. Lists are checked whole; then each item is a `command` to
// telemetry.
#include "fsw/commanding/telecommander.hpp"
#include "fsw/packets/service_events.hpp"

namespace ilp {

Status Telecommander::service_5(const Telecommand& telecommand, Answer& answer, Change& change) {
  CommandRecord command;
  command.request_id = ++change.after.last_request_id;
  std::int64_t id = 0;
  switch (telecommand.subtype) {
    case event_reporting::report_disabled:
      if (!telecommand.data.empty()) return {StatusCode::request_malformed, 0};
      command.kind = CommandKind::events_report;
      command.tag = answer.request().source;
      ILP_TRY(write_command(command, id));
      return wait_for_telemetry(id, answer, change);
    case event_reporting::enable:
      command.kind = CommandKind::event_enable;
      break;
    case event_reporting::disable:
      command.kind = CommandKind::event_disable;
      break;
    default:
      return {StatusCode::subtype_unknown, telecommand.service, telecommand.subtype};
  }
  EventList list;
  ILP_TRY(decode_event_list(wiring_.writer.settings().tailoring, telecommand.data, list));
  answer.accept();
  for (std::size_t i = 0; i < list.ids.size(); ++i) {
    if (list.ids[i] == 0 || !is_status_code(list.ids[i])) {
      return {StatusCode::event_unknown, list.ids[i], static_cast<std::int64_t>(i)};
    }
  }
  answer.start();
  for (const std::uint32_t event : list.ids) {
    command.subject_id = event;
    ILP_TRY(write_command(command, id));
  }
  // The number 0 is no event: it stands for all of them.
  command.subject_id = 0;
  return list.all ? write_command(command, id) : Status{};
}

}  // namespace ilp
