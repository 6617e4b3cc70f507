// Keeps the values of a flight's newest housekeeping reports, and describes reports in words.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fsw/packets/report_table.hpp"
#include "fsw/packets/tailoring.hpp"
#include "sim/ground/console/console.hpp"

namespace ilp::console {

// Reports of the flight in words for the operator.

/// Describes an event of service 5: severity, component, meaning, and what to do (docs/events.md).
[[nodiscard]] std::string event_words(const Tailoring& tailoring, const Report& report);

/// Lines `section.key = value unit` for the parameters of TM[20,2]. `see` gets index and value of each parameter.
[[nodiscard]] std::vector<std::string> parameter_words(
    const Tailoring& tailoring, const Report& report,
    const std::function<void(std::size_t index, double value)>& see = {});

/// Lines for TM[11,13]: release time and name of each scheduled request. `name_of` returns the name of a request.
[[nodiscard]] std::vector<std::string> schedule_words(const Tailoring& tailoring, const Report& report,
                                                      const std::function<std::string(std::uint32_t request)>& name_of);

/// Describes the reason in a failure report of service 1, and what to do.
[[nodiscard]] std::string failure_words(std::uint32_t code, std::span<const std::uint8_t> failure_data);

class ReportValues {
 public:
  /// Takes the data of a TM[3,25], and returns its report. Null if the SID is unknown or the data have a wrong length.
  const ReportInfo* take(const Tailoring& tailoring, std::span<const std::uint8_t> data);

  /// All values of the newest report with this name; null: none has come.
  [[nodiscard]] const std::vector<double>* of(const std::string& report) const;
  /// Element `index` of a field in its repetition `repeat`. None: no report has come; NaN: the flight has no value.
  [[nodiscard]] std::optional<double> value(const std::string& report, const std::string& field, std::size_t index = 0,
                                            std::size_t repeat = 0) const;
  /// A line `name value unit` for each value, in the order of the table.
  [[nodiscard]] std::vector<std::string> lines(const std::string& report) const;

 private:
  // 64-bit counts and times are exact below 2^53, which is 104 days in nanoseconds.
  std::map<std::string, std::vector<double>> values_;
};

}  // namespace ilp::console
