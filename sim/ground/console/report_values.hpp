// The newest housekeeping reports of a flight, value by value.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fsw/packets/report_table.hpp"
#include "fsw/packets/tailoring.hpp"

namespace ilp::console {

class ReportValues {
 public:
  /// The data of a TM[3,25]; its report, null when the SID or the length is none of the table.
  const ReportInfo* take(const Tailoring& tailoring, std::span<const std::uint8_t> data);

  /// Null when there has been none.
  [[nodiscard]] const std::vector<double>* of(const std::string& report) const;
  /// Element `index` of a field, of repetition `repeat`; none when no report has come, NaN when the flight knows none.
  [[nodiscard]] std::optional<double> value(const std::string& report, const std::string& field, std::size_t index = 0,
                                            std::size_t repeat = 0) const;
  /// `name value unit` of each, in the order of the table.
  [[nodiscard]] std::vector<std::string> lines(const std::string& report) const;

 private:
  // 64-bit counts and times too: whole below 2^53, which is 104 days in nanoseconds.
  std::map<std::string, std::vector<double>> values_;
};

}  // namespace ilp::console
