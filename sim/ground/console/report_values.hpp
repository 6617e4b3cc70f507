// The newest housekeeping reports of a flight, value by value.
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

/// An event of service 5: severity, component, meaning, and what to do (docs/events.md).
[[nodiscard]] std::string event_words(const Tailoring& tailoring, const Report& report);

/// `section.key = value unit` of each parameter of TM[20,2]; `see` gets its number, from 0, and its value.
[[nodiscard]] std::vector<std::string> parameter_words(
    const Tailoring& tailoring, const Report& report,
    const std::function<void(std::size_t index, double value)>& see = {});

/// TM[11,13]: release time and name of each request that waits, by `name_of` where the request is ours.
[[nodiscard]] std::vector<std::string> schedule_words(const Tailoring& tailoring, const Report& report,
                                                      const std::function<std::string(std::uint32_t request)>& name_of);

/// The reason in a failure report of service 1, and what to do about it.
[[nodiscard]] std::string failure_words(std::uint32_t code, std::span<const std::uint8_t> failure_data);

class ReportValues {
 public:
  /// Takes the data of a TM[3,25]. Returns its report; null if the table has no such SID or another length.
  const ReportInfo* take(const Tailoring& tailoring, std::span<const std::uint8_t> data);

  /// Null when there has been none.
  [[nodiscard]] const std::vector<double>* of(const std::string& report) const;
  /// Element `index` of a field in repetition `repeat`: none if no report has come, NaN if the flight has no value.
  [[nodiscard]] std::optional<double> value(const std::string& report, const std::string& field, std::size_t index = 0,
                                            std::size_t repeat = 0) const;
  /// A line `name value unit` for each value, in the order of the table.
  [[nodiscard]] std::vector<std::string> lines(const std::string& report) const;

 private:
  // 64-bit counts and times too: whole below 2^53, which is 104 days in nanoseconds.
  std::map<std::string, std::vector<double>> values_;
};

}  // namespace ilp::console
