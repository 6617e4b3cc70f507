// Service 3 of the Telecommander: housekeeping reports. Lists are checked whole; then each item is a `command` to
// telemetry, which makes the reports.
#include "fsw/commanding/telecommander.hpp"
#include "fsw/packets/report_table.hpp"
#include "fsw/packets/service_housekeeping.hpp"

namespace ilp {

Status Telecommander::service_3(const Telecommand& telecommand, Answer& answer, Change& change) {
  CommandRecord command;
  switch (telecommand.subtype) {
    case housekeeping::set_interval:
      return set_intervals(telecommand, answer, change);
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
      return {StatusCode::subtype_unknown, telecommand.service, telecommand.subtype};
  }
  command.request_id = ++change.after.last_request_id;
  ReportList list;
  ILP_TRY(decode_report_list(wiring_.writer.settings().tailoring, telecommand.data, list));
  answer.accept();
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (find_report(list[i]) == nullptr) {
      return {StatusCode::report_unknown, static_cast<std::int64_t>(list[i]), static_cast<std::int64_t>(i)};
    }
  }
  std::int64_t last_id = 0;
  for (const std::uint64_t sid : list) {
    command.subject_id = static_cast<std::int64_t>(sid);
    ILP_TRY(write_command(command, last_id));
  }
  if (command.kind == CommandKind::report_once) return wait_for_telemetry(last_id, answer, change);
  answer.start();
  return {};
}

Status Telecommander::set_intervals(const Telecommand& telecommand, Answer& answer, Change& change) {
  IntervalList list;
  ILP_TRY(decode_interval_list(wiring_.writer.settings().tailoring, telecommand.data, list));
  answer.accept();
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto item = static_cast<std::int64_t>(i);
    if (find_report(list[i].report_id) == nullptr) {
      return {StatusCode::report_unknown, static_cast<std::int64_t>(list[i].report_id), item};
    }
    if (list[i].interval_ns < minor_frame_ns) {
      return {StatusCode::report_interval, list[i].interval_ns / ns_per_ms, item};
    }
  }
  answer.start();
  CommandRecord command;
  command.kind = CommandKind::report_interval;
  command.request_id = ++change.after.last_request_id;
  std::int64_t id = 0;
  for (const ReportInterval& item : list) {
    command.subject_id = static_cast<std::int64_t>(item.report_id);
    command.at_ns = item.interval_ns;
    ILP_TRY(write_command(command, id));
  }
  return {};
}

}  // namespace ilp
