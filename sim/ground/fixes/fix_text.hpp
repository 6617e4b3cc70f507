// Describes fixes in words and as JSON, for the report and for ilp-ground map-check.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "sim/ground/fixes/fix_summary.hpp"
#include "sim/ground/model/joined_model.hpp"

namespace ilp::fixes {

/// The map's id in hexadecimal, as `ilp-ground map-tiles` prints it.
[[nodiscard]] std::string map_name(std::int64_t map_id);

/// Lines for the terminal and the page: how many keyframes are placed on the map, why the others are not, and which
/// errors the fixes have removed. Empty without fix records.
[[nodiscard]] std::vector<std::string> lines_of(const FixSummary& summary);
/// Lines about the model on the map: how well its fixes agree, and which drift they have removed. Empty without such a
/// model.
[[nodiscard]] std::vector<std::string> lines_of(const model::JoinedFlight& joined);

/// The summary as JSON. Lengths are in m; unknown distances are null.
[[nodiscard]] nlohmann::ordered_json json_of(const FixSummary& summary);

}  // namespace ilp::fixes
