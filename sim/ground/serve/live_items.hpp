// A run's report as the items of the live page (page/*.js reads them).
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

/// PNG by its path on the server.
using Pictures = std::map<std::string, std::shared_ptr<const std::vector<std::uint8_t>>>;

/// Largest side of a picture of a map, and most items of a list whose length the flight does not bound.
struct PageBudget {
  std::int32_t picture_side_px = 1200;
  std::size_t events = 2000;
  std::size_t missing = 100;
};

/// Items: "summary", "k/ID" keyframes, "strip/ID", "e/NUMBER" events, "storage", "timing", "c/ID" components,
/// "missing", "files". Numbers have six digits, so that what only rounding changes is not sent again. Pictures of the
/// maps are put into `pictures`.
[[nodiscard]] Items live_items(const report::Report& report, const std::set<std::string>& files, Pictures& pictures,
                               const PageBudget& budget = {});

/// Only the maps: the items "strip/ID" refer to them.
[[nodiscard]] nlohmann::json map_item(const report::StripResult& strip, std::int32_t side_px, Pictures& pictures);

}  // namespace ilp::serve
