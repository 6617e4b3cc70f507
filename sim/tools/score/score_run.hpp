// The scorer's work on one flight: read, measure, write score.json, print the table.
#pragma once

#include <iosfwd>

#include "sim/tools/score/score.hpp"

namespace ilp::score {

/// Writes `out` (empty: score.json in the flight's folder), beside it height-error.pfm where heights could be compared
/// (truth's unit, on the grid of the truth's height.pfm, NaN elsewhere), and the table to `table`. std::runtime_error
/// with a message for the user.
void run_score(const ScoreOptions& options, const std::filesystem::path& out, std::ostream& table);

}  // namespace ilp::score
