// The flat numbers of a score in words: for the scorer's table and for the report.
#pragma once

#include <span>
#include <string>

namespace ilp::ground {

struct ScoreName {
  const char* key;      ///< in score.json's `summary`
  const char* group;    ///< heading
  const char* meaning;  ///< with its unit
  const char* perfect;  ///< the value of a flight without error; empty where there is no such thing
};

/// In the order of reading; those of a group stand together.
[[nodiscard]] std::span<const ScoreName> score_names();

/// A score's value: whole numbers without decimals, others to about three digits, a dash for what is not known.
[[nodiscard]] std::string score_text(double value);

}  // namespace ilp::ground
