// What the viewer's page knows of a flight, as JSON: sim/ground/viewer/data.js reads it.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "sim/ground/report/report.hpp"

namespace ilp::ground {

/// Bounds that keep the page a page.
struct ViewerBudget {
  std::size_t vertices = 300000;        ///< of the surfaces of all strips together
  std::int32_t texture_side_px = 2048;  ///< of an orthoimage
  std::size_t frames = 20000;           ///< overlaps in the timeline
  std::size_t events = 4000;
};

[[nodiscard]] nlohmann::json viewer_data(const Report& report, const ViewerBudget& budget = {});

/// The parts.
[[nodiscard]] nlohmann::json viewer_strip(const Report& report, const StripResult& strip, const ViewerBudget& budget);
[[nodiscard]] nlohmann::json viewer_keyframes(const Report& report);
[[nodiscard]] nlohmann::json viewer_timeline(const Report& report, const ViewerBudget& budget);

}  // namespace ilp::ground
