// Service 5, event reporting: enables and disables events. A list is checked completely; then each of its items becomes
// a `command` to telemetry.
#include "fsw/commanding/telecommand_service.hpp"
#include "fsw/packets/service_events.hpp"

namespace ilp {

Status serve_events(ServiceCall& call) {
  CommandRecord command{.request_id = ++call.change.after.last_request_id};
  switch (call.telecommand.subtype) {
    case event_reporting::report_disabled:
      if (!call.telecommand.data.empty()) return {StatusCode::request_malformed, 0};
      command.kind = CommandKind::events_report;
      command.tag = call.answer.request().source;
      ILP_TRY(write_command(call.wiring, command));
      return wait_for_telemetry(command.id, call);
    case event_reporting::enable:
      command.kind = CommandKind::event_enable;
      break;
    case event_reporting::disable:
      command.kind = CommandKind::event_disable;
      break;
    default:
      return call.subtype_unknown();
  }
  EventList list;
  ILP_TRY(decode_event_list(call.tailoring(), call.telecommand.data, list));
  call.answer.accept();
  for (std::size_t i = 0; i < list.ids.size(); ++i) {
    if (list.ids[i] == 0 || !is_status_code(list.ids[i])) {
      return {StatusCode::event_unknown, list.ids[i], static_cast<std::int64_t>(i)};
    }
  }
  call.answer.start();
  for (const std::uint32_t event : list.ids) {
    command.subject_id = event;
    ILP_TRY(write_command(call.wiring, command));
  }
  // The number 0 is no event: it stands for all of them.
  command.subject_id = 0;
  return list.all ? write_command(call.wiring, command) : Status{};
}

}  // namespace ilp
