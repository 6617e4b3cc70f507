// The telecommands of services 3 and 5.
#include "fsw/telemetry/telemetry.hpp"

namespace ilp {

bool TelemetryReporter::serves(std::uint8_t service) const {
  return service == housekeeping::service || service == event_reporting::service;
}

Status TelemetryReporter::perform(const Telecommand& telecommand, Answer& answer) {
  after_ = state_;
  if (telecommand.service == housekeeping::service) {
    ILP_TRY(telecommand.subtype == housekeeping::set_interval ? set_intervals(telecommand, answer)
                                                              : manage_housekeeping(telecommand, answer));
  } else {
    ILP_TRY(telecommand.subtype == event_reporting::report_disabled ? report_disabled(telecommand, answer)
                                                                    : manage_events(telecommand, answer));
  }
  return save(after_);
}

void TelemetryReporter::settled(bool committed) {
  if (!committed) return;
  const TimeNs now = clock_.now();
  for (std::size_t i = 0; i < report_id_limit; ++i) {
    // The first one at once, and the next one not later than the new interval says.
    if (after_.enabled[i] != 0 && state_.enabled[i] == 0) due_ns_[i] = now;
    if (due_ns_[i] > now + after_.interval_ns[i]) due_ns_[i] = now + after_.interval_ns[i];
  }
  state_ = after_;
  cursor_unsaved_ = false;
}

Status TelemetryReporter::manage_housekeeping(const Telecommand& telecommand, Answer& answer) {
  const std::uint8_t subtype = telecommand.subtype;
  if (subtype != housekeeping::enable && subtype != housekeeping::disable && subtype != housekeeping::report_once) {
    return {StatusCode::subtype_unknown, telecommand.service, subtype};
  }
  ReportList list;
  ILP_TRY(decode_report_list(writer_.settings().tailoring, telecommand.data, list));
  answer.accept();
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (find_report(list[i]) == nullptr) {
      return {StatusCode::report_unknown, static_cast<std::int64_t>(list[i]), static_cast<std::int64_t>(i)};
    }
  }
  answer.start();
  for (const std::uint64_t id : list) {
    if (subtype == housekeeping::report_once) {
      ILP_TRY(send(*find_report(id)));
    } else {
      after_.enabled[id] = subtype == housekeeping::enable ? 1 : 0;
    }
  }
  return {};
}

Status TelemetryReporter::set_intervals(const Telecommand& telecommand, Answer& answer) {
  IntervalList list;
  ILP_TRY(decode_interval_list(writer_.settings().tailoring, telecommand.data, list));
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
  for (const ReportInterval& item : list) after_.interval_ns[item.report_id] = item.interval_ns;
  return {};
}

Status TelemetryReporter::manage_events(const Telecommand& telecommand, Answer& answer) {
  const std::uint8_t subtype = telecommand.subtype;
  if (subtype != event_reporting::enable && subtype != event_reporting::disable) {
    return {StatusCode::subtype_unknown, telecommand.service, subtype};
  }
  const std::uint8_t disable = subtype == event_reporting::disable ? 1 : 0;
  EventList list;
  ILP_TRY(decode_event_list(writer_.settings().tailoring, telecommand.data, list));
  answer.accept();
  for (std::size_t i = 0; i < list.ids.size(); ++i) {
    if (list.ids[i] == 0 || !is_status_code(list.ids[i])) {
      return {StatusCode::event_unknown, list.ids[i], static_cast<std::int64_t>(i)};
    }
  }
  answer.start();
  for (const std::uint32_t id : list.ids) after_.disabled[id] = disable;
  // `ok` is no event.
  for (std::size_t id = 1; list.all && id < event_count; ++id) after_.disabled[id] = disable;
  return {};
}

Status TelemetryReporter::report_disabled(const Telecommand& telecommand, Answer& answer) {
  if (!telecommand.data.empty()) return {StatusCode::request_malformed, 0};
  answer.start();
  FixedVector<std::uint32_t, event_count> ids;
  for (std::size_t id = 1; id < event_count; ++id) {
    if (state_.disabled[id] != 0) static_cast<void>(ids.push_back(static_cast<std::uint32_t>(id)));
  }
  ByteWriter out(report_);
  encode_disabled_events(writer_.settings().tailoring, {ids.data(), ids.size()}, out);
  ILP_ASSERT(out.ok(), ids.size());
  return answer.report(event_reporting::service, event_reporting::disabled, out.written());
}

}  // namespace ilp
