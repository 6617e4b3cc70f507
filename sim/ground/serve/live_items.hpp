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

/// report.json as items KEY. A list of objects is empty in it, and has an item KEY/ID or, without numbers of their own,
/// KEY/INDEX for each of them; captures also have captures/list/ID. Of "files" there are those with a fault.
/// "figures/NAME" (report::map_figures) and "results", the names of the files, are of the live page only. Numbers have
/// nine digits, so that what only rounding changes is not sent again. The figures' pictures are put into `pictures`.
[[nodiscard]] Items live_items(const report::Report& report, const std::set<std::string>& files, Pictures& pictures);

}  // namespace ilp::serve
