// Pictures of a flight against the truth.
#pragma once

#include <string>

#include "sim/ground/report/score_file.hpp"

namespace ilp::report {

/// True and estimated track from above, flight from left to right, errors drawn larger than they are; a <figure>,
/// empty where there is no track.
[[nodiscard]] std::string track_error_figure(const ScoredStrip& strip);

/// The map of height errors in colours, cut to what was mapped; a <figure>, empty without a map.
[[nodiscard]] std::string height_error_figure(const ScoreFile& score);

}  // namespace ilp::report
