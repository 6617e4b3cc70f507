// Makes the data of the viewer's page that report.json does not have; sim/ground/viewer/data.js reads both.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "sim/ground/report/report.hpp"

namespace ilp::viewer {

/// Limits that keep the page small enough for a browser.
struct ViewerBudget {
  std::size_t vertices = 300000;        ///< total number of vertices of all strips' surfaces
  std::int32_t texture_side_px = 2048;  ///< largest side of an orthoimage
};

/// Data of a strip or a keyframe in addition to its element of report.json.
[[nodiscard]] nlohmann::ordered_json viewer_strip(const report::Report& report, const report::StripResult& strip,
                                                  const ViewerBudget& budget = {});
[[nodiscard]] nlohmann::ordered_json viewer_keyframe(const report::Report& report, const intake::Keyframe& keyframe);
/// The flight's links with their verdicts.
[[nodiscard]] nlohmann::ordered_json viewer_links(const intake::Flight& flight);
/// Files passed to the link, from the newest record of each: [time sent in s, bytes, time confirmed in s or -1].
[[nodiscard]] nlohmann::ordered_json viewer_downlink(const report::Report& report);

}  // namespace ilp::viewer
