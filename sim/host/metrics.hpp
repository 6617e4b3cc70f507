// The numbers of a flight's score: what they are called, and what they are at best.
#pragma once

#include <span>
#include <string>

namespace ilp::host {

struct Metric {
  const char* key;    ///< in `summary` of score.json
  const char* group;  ///< heading; empty: not shown in tables of one flight
  const char* label;  ///< with its unit
  const char* ideal;  ///< the value of a flight without error; empty where there is no such thing
};

/// The table of metrics.inc, in the order of reading; metrics of a group stand together.
[[nodiscard]] std::span<const Metric> metrics();

/// A score's value: whole numbers without decimals, others to about three digits, a dash for what is not known.
[[nodiscard]] std::string score_text(double value);

}  // namespace ilp::host
