// Lists the metrics of a flight's score with labels and ideal values.
#pragma once

#include <span>
#include <string>

namespace ilp::host {

struct Metric {
  const char* key;    ///< name in `summary` of score.json
  const char* group;  ///< heading in tables; empty: not shown in tables of one flight
  const char* label;  ///< with its unit
  const char* ideal;  ///< value of a flight without errors; empty if there is none
};

/// The table of metrics.inc, in the order of display. Metrics of a group are adjacent.
[[nodiscard]] std::span<const Metric> metrics();

/// Text of a score's value: integers without decimals, others with about three significant digits, a dash for NaN.
[[nodiscard]] std::string score_text(double value);

}  // namespace ilp::host
