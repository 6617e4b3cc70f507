#include "fsw/packets/message_table.hpp"

#include <iterator>

#include "fsw/packets/service_events.hpp"
#include "fsw/packets/service_functions.hpp"
#include "fsw/packets/service_housekeeping.hpp"
#include "fsw/packets/service_parameters.hpp"
#include "fsw/packets/service_schedule.hpp"
#include "fsw/packets/service_verification.hpp"

namespace ilp {
namespace {

constexpr MessageInfo up(std::uint8_t service, std::uint8_t subtype, const char* name, const char* layout,
                         const char* remark = "") {
  return {service, subtype, true, name, layout, remark};
}
constexpr MessageInfo down(std::uint8_t service, std::uint8_t subtype, const char* name, const char* layout,
                           const char* remark = "") {
  return {service, subtype, false, name, layout, remark};
}

constexpr const char* reports = "N w(report count), SID w(SID) x N";
constexpr const char* events = "N w(event count), event w(event) x N";
constexpr const char* request = "request ID u32";
constexpr const char* failure = "request ID u32, failure code w(failure code), two i64";
constexpr const char* request_ids = "N w(schedule count), request x N";
constexpr const char* event =
    "event w(event), component w(reporter), two values w(event value), number u32, TIME, text up to the end";
constexpr const char* event_remark = "TIME is that of the event; the text is there for failed assertions only";

constexpr MessageInfo table[] = {
    down(verification::service, verification::acceptance, "successful acceptance", request, "flag 1"),
    down(verification::service, verification::acceptance_failed, "failed acceptance", failure),
    down(verification::service, verification::start, "successful start", request, "flag 2"),
    down(verification::service, verification::start_failed, "failed start", failure),
    down(verification::service, verification::progress, "successful progress", "request ID u32, step w(step)",
         "flag 4; of `CAPTSER`, for each image"),
    down(verification::service, verification::completion, "successful completion", request, "flag 8"),
    down(verification::service, verification::completion_failed, "failed completion", failure),

    up(housekeeping::service, housekeeping::enable, "enable periodic reports", reports),
    up(housekeeping::service, housekeeping::disable, "disable periodic reports", reports),
    down(housekeeping::service, housekeeping::report, "housekeeping report", "SID w(SID), values"),
    up(housekeeping::service, housekeeping::report_once, "one-shot reports", reports, "answer: TM[3,25]"),
    up(housekeeping::service, housekeeping::set_interval, "collection interval",
       "N w(report count), (SID w(SID), interval u32 ms or f32 s) x N", "at least 100 ms"),

    down(event_reporting::service, event_reporting::informative, "informative event", event, event_remark),
    down(event_reporting::service, event_reporting::informative + 1, "event of low severity", event, event_remark),
    down(event_reporting::service, event_reporting::informative + 2, "event of medium severity", event, event_remark),
    down(event_reporting::service, event_reporting::informative + 3, "event of high severity", event, event_remark),
    up(event_reporting::service, event_reporting::enable, "enable events", events),
    up(event_reporting::service, event_reporting::disable, "disable events", events),
    up(event_reporting::service, event_reporting::report_disabled, "report disabled events", "", "answer: TM[5,8]"),
    down(event_reporting::service, event_reporting::disabled, "disabled events", events),

    up(function_management::service, function_management::perform, "perform a function", "name 8 characters, arguments",
       "functions: below"),

    up(scheduling::service, scheduling::enable, "enable the schedule", ""),
    up(scheduling::service, scheduling::disable, "disable the schedule", ""),
    up(scheduling::service, scheduling::reset, "reset the schedule", ""),
    up(scheduling::service, scheduling::insert, "insert telecommands",
       "sub-schedule w(sub-schedule), N w(insert count), (group w(group), release TIME, telecommand) x N",
       "each a whole packet with its own CRC"),
    up(scheduling::service, scheduling::remove, "delete by request ID", request_ids),
    up(scheduling::service, scheduling::shift, "time-shift by request ID",
       "offset i32 ms, N w(schedule count), request x N"),
    up(scheduling::service, scheduling::detail, "detail-report by request ID", request_ids, "answer: TM[11,10]"),
    down(scheduling::service, scheduling::detail_report, "schedule detail report",
         "N w(schedule count), (sub-schedule w(sub-schedule), group w(group), release TIME, telecommand) x N"),
    up(scheduling::service, scheduling::summary, "summary-report by request ID", request_ids, "answer: TM[11,13]"),
    down(scheduling::service, scheduling::summary_report, "schedule summary report",
         "N w(schedule count), (sub-schedule w(sub-schedule), group w(group), release TIME, request) x N"),
    up(scheduling::service, scheduling::shift_all, "time-shift all", "offset i32 ms"),
    up(scheduling::service, scheduling::detail_all, "detail-report all", "", "answer: TM[11,10]"),
    up(scheduling::service, scheduling::summary_all, "summary-report all", "", "answer: TM[11,13]"),

    up(test_service::service, test_service::are_you_alive, "are-you-alive test", "", "answer: TM[17,2]"),
    down(test_service::service, test_service::alive, "are-you-alive report", ""),
    up(test_service::service, test_service::connection_test, "on-board connection test", "APID u16",
       "answer: TM[17,4]"),
    down(test_service::service, test_service::connected, "on-board connection report", "APID u16"),

    up(parameter_management::service, parameter_management::report, "report parameter values",
       "N w(parameter count), parameter w(parameter) x N", "answer: TM[20,2]"),
    down(parameter_management::service, parameter_management::values, "parameter values",
         "N w(parameter count), (parameter w(parameter), value) x N"),
    up(parameter_management::service, parameter_management::set, "set parameter values",
       "N w(parameter count), (parameter w(parameter), value) x N", "all or none"),
};

constexpr bool in_order() {
  for (std::size_t i = 1; i < std::size(table); ++i) {
    const MessageInfo& a = table[i - 1];
    const MessageInfo& b = table[i];
    if (a.service > b.service || (a.service == b.service && a.subtype >= b.subtype)) return false;
  }
  return true;
}
static_assert(in_order());

}  // namespace

std::span<const MessageInfo> message_table() {
  return table;
}

}  // namespace ilp
