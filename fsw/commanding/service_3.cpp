// Service 3, housekeeping. A list is checked completely; then each of its items becomes a `command` to telemetry, which
// makes the reports.
#include "fsw/commanding/telecommand_service.hpp"
#include "fsw/packets/report_table.hpp"
#include "fsw/packets/service_housekeeping.hpp"

namespace ilp {
namespace {

Status set_intervals(ServiceCall& call) {
  IntervalList list;
  ILP_TRY(decode_interval_list(call.tailoring(), call.telecommand.data, list));
  call.answer.accept();
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto item = static_cast<std::int64_t>(i);
    if (find_report(list[i].report_id) == nullptr) {
      return {StatusCode::report_unknown, static_cast<std::int64_t>(list[i].report_id), item};
    }
    if (list[i].interval_ns < minor_frame_ns) {
      return {StatusCode::report_interval, list[i].interval_ns / ns_per_ms, item};
    }
  }
  call.answer.start();
  CommandRecord command{.kind = CommandKind::report_interval, .request_id = ++call.change.after.last_request_id};
  for (const ReportInterval& item : list) {
    command.subject_id = static_cast<std::int64_t>(item.report_id);
    command.at_ns = item.interval_ns;
    ILP_TRY(write_command(call.wiring, command));
  }
  return {};
}

}  // namespace

Status serve_housekeeping(ServiceCall& call) {
  CommandRecord command;
  switch (call.telecommand.subtype) {
    case housekeeping::set_interval:
      return set_intervals(call);
    case housekeeping::enable:
      command.kind = CommandKind::report_enable;
      break;
    case housekeeping::disable:
      command.kind = CommandKind::report_disable;
      break;
    case housekeeping::report_once:
      command.kind = CommandKind::report_once;
      break;
    default:
      return call.subtype_unknown();
  }
  command.request_id = ++call.change.after.last_request_id;
  ReportList list;
  ILP_TRY(decode_report_list(call.tailoring(), call.telecommand.data, list));
  call.answer.accept();
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (find_report(list[i]) == nullptr) {
      return {StatusCode::report_unknown, static_cast<std::int64_t>(list[i]), static_cast<std::int64_t>(i)};
    }
  }
  for (const std::uint64_t sid : list) {
    command.subject_id = static_cast<std::int64_t>(sid);
    ILP_TRY(write_command(call.wiring, command));
  }
  if (command.kind == CommandKind::report_once) return wait_for_telemetry(command.id, call);
  call.answer.start();
  return {};
}

}  // namespace ilp
