// What the viewer's page has beside report.json: sim/ground/viewer/data.js reads both.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "sim/ground/report/report.hpp"

namespace ilp::viewer {

/// Limits that keep the page small enough for a browser.
struct ViewerBudget {
  std::size_t vertices = 300000;        ///< of the surfaces of all strips together
  std::int32_t texture_side_px = 2048;  ///< of an orthoimage
};

/// What a strip and a keyframe have beside the elements of report.json.
[[nodiscard]] nlohmann::ordered_json viewer_strip(const report::Report& report, const report::StripResult& strip,
                                                  const ViewerBudget& budget = {});
[[nodiscard]] nlohmann::ordered_json viewer_keyframe(const report::Report& report, const intake::Keyframe& keyframe);
/// The flight's links with their verdicts.
[[nodiscard]] nlohmann::ordered_json viewer_links(const intake::Flight& flight);
/// Files handed to the link, by the newest record of each: [sent, bytes, confirmed or -1], s.
[[nodiscard]] nlohmann::ordered_json viewer_downlink(const report::Report& report);

}  // namespace ilp::viewer
