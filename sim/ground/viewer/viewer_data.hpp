// The data of the viewer's page as JSON: sim/ground/viewer/data.js reads it.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "sim/ground/report/report.hpp"

namespace ilp::viewer {

/// Limits that keep the page small enough for a browser.
struct ViewerBudget {
  std::size_t vertices = 300000;        ///< of the surfaces of all strips together
  std::int32_t texture_side_px = 2048;  ///< of an orthoimage
  std::size_t frames = 20000;           ///< overlaps in the timeline
  std::size_t events = 4000;
};

[[nodiscard]] nlohmann::json viewer_data(const report::Report& report, const ViewerBudget& budget = {});
/// All of it but "keyframes", the list of viewer_keyframe().
[[nodiscard]] nlohmann::json viewer_data_but_keyframes(const report::Report& report, const ViewerBudget& budget = {});

/// The parts.
[[nodiscard]] nlohmann::json viewer_strip(const report::Report& report, const report::StripResult& strip,
                                          const ViewerBudget& budget);
[[nodiscard]] nlohmann::json viewer_keyframe(const report::Report& report, const intake::Keyframe& keyframe);
/// The flight's links with their verdicts. Those whose points the joined model holds have the number of points and
/// their median reprojection error in it, px.
[[nodiscard]] nlohmann::json viewer_links(const report::Report& report);
[[nodiscard]] nlohmann::json viewer_timeline(const report::Report& report, const ViewerBudget& budget);

}  // namespace ilp::viewer
