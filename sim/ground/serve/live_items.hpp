// Converts a run's report to the items of the live page (page/*.js reads them).
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "sim/ground/report/report.hpp"
#include "sim/ground/serve/state_log.hpp"

namespace ilp::serve {

/// PNG files; key: path on the server.
using Pictures = std::map<std::string, std::shared_ptr<const std::vector<std::uint8_t>>>;

/// Makes an item KEY of each member of report.json. A list of objects becomes an empty item KEY, and an item KEY/ID for
/// each object, or KEY/INDEX if the objects have no ids; captures also have captures/list/ID. "files" has only files
/// with a fault. Items of the live page alone are "figures/NAME" (report::map_figures) and "results" (the names
/// `files`). Numbers have nine digits, so that values that only rounding changes are not sent again. Adds the pictures
/// of the figures to `pictures`.
[[nodiscard]] Items live_items(const report::Report& report, const std::set<std::string>& files, Pictures& pictures);

}  // namespace ilp::serve
