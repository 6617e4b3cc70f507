// Fixes in words and as JSON: what the report and map-check both say.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "sim/ground/fixes/fix_summary.hpp"
#include "sim/ground/model/joined_model.hpp"

namespace ilp::fixes {

/// As `ilp-ground map-tiles` prints it, in hexadecimal.
[[nodiscard]] std::string map_name(std::int64_t map_id);

/// For the terminal and the page: how many keyframes stand on the map, why the others do not, and what the fixes
/// removed. Empty without fix records.
[[nodiscard]] std::vector<std::string> lines_of(const FixSummary& summary);
/// Of the model that stands on the map: how its fixes agree, and what they have removed. Empty without one.
[[nodiscard]] std::vector<std::string> lines_of(const model::JoinedFlight& joined);

/// Lengths in m; distances that are not known are null.
[[nodiscard]] nlohmann::ordered_json json_of(const FixSummary& summary);

}  // namespace ilp::fixes
