// A flight as its operator sees it: the newest housekeeping and the pass plan, in a few lines.
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
  bool parameters_known = false;     ///< all of them
  std::optional<double> received_s;  ///< since the last report; none before the first
  TimeNs since_status = 0;           ///< since the report `status`

  /// The flight's present mission time; 0 before the first report.
  [[nodiscard]] TimeNs mission_time() const;
};

/// "in contact for 01:20 more", "no contact; the next pass begins in 04:10 and lasts 10:00", "always in contact",
/// "no contact for 00:40, because a telecommand ended it".
[[nodiscard]] std::string pass_words(const FlightView& view);
/// The present pass and the next ones, one a line.
[[nodiscard]] std::vector<std::string> pass_plan(const FlightView& view, std::size_t passes);

/// A flight that has ended contact reports nothing more, so the view itself follows a telecommand that begins or ends
/// contact and was carried out. What to tell the operator; empty for every other telecommand.
[[nodiscard]] std::string apply_contact_command(const OperatorCommand& command, FlightView& view);

/// True if the flight is known to listen to nothing now.
[[nodiscard]] bool out_of_contact(const FlightView& view);

/// Time and contact, images, storage, link, queue, components in trouble.
[[nodiscard]] std::vector<std::string> panel(const FlightView& view);
/// The view in one line, for logs.
[[nodiscard]] std::string status_line(const FlightView& view);

}  // namespace ilp::console
