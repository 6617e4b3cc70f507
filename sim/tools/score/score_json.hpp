// A score as JSON, and as a table for people.
#pragma once

#include <iosfwd>
#include <nlohmann/json.hpp>

#include "sim/tools/score/score.hpp"

namespace ilp::score {

inline constexpr int score_version = 1;

/// Version, completeness, counts, `strips`, `keyframes` and `remarks`; what is not known is null. Lengths are in the
/// truth's unit, angles in degrees, `sigma` and `relative_error` along the strip's axes in the truth's unit.
[[nodiscard]] nlohmann::ordered_json score_json(const Score& score, const FlightFiles& files);

/// Members in the order of `order`, then all others; NaN becomes null.
[[nodiscard]] nlohmann::ordered_json summary_json(const std::map<std::string, double>& summary);

void write_table(const Score& score, const std::map<std::string, double>& summary, std::ostream& out);

}  // namespace ilp::score
