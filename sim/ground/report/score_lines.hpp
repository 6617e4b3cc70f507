// The numbers of a score that a person wants first.
#pragma once

#include <string>
#include <vector>

#include "sim/ground/report/score_file.hpp"

namespace ilp::report {

/// Positions, heights and stated errors, a line each; what was not measured is left out, an incomplete flight said.
[[nodiscard]] std::vector<std::string> score_lines(const ScoreFile& score);

}  // namespace ilp::report
