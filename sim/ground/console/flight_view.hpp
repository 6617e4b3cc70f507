// The operator's view of a flight: its newest housekeeping and its pass plan, in a few lines.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cfg/mission.hpp"
#include "sim/ground/console/operator_command.hpp"
#include "sim/ground/console/report_values.hpp"

namespace ilp::console {

struct FlightView {
  ReportValues reports;
  MissionParameters mission;         ///< as the flight has reported them
  bool parameters_known = false;     ///< all parameters have been reported
  std::optional<double> received_s;  ///< time since the last report; none: no report has come
  TimeNs since_status = 0;           ///< time since the report `status`

  /// The flight's present mission time; 0 before the first report.
  [[nodiscard]] TimeNs mission_time() const;
};

/// The state of contact in words: "in contact for 01:20 more", "no contact; the next pass begins in 04:10 and lasts
/// 10:00", "always in contact", "no contact for 00:40, because a telecommand ended it".
[[nodiscard]] std::string pass_words(const FlightView& view);
/// A line for each of the present pass and the next ones.
[[nodiscard]] std::vector<std::string> pass_plan(const FlightView& view, std::size_t passes);

/// Updates the view after a telecommand that begins or ends contact was executed: a flight without contact cannot
/// report it. Returns a line for the operator; empty for other telecommands.
[[nodiscard]] std::string apply_contact_command(const OperatorCommand& command, FlightView& view);

/// Whether the flight is known to be out of contact now.
[[nodiscard]] bool out_of_contact(const FlightView& view);

/// Lines of the panel: time and contact, images, storage, link, queue, and components with problems.
[[nodiscard]] std::vector<std::string> panel(const FlightView& view);
/// The view in one line, for logs.
[[nodiscard]] std::string status_line(const FlightView& view);

}  // namespace ilp::console
