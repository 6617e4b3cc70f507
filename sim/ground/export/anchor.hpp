// Where on a body the strips of a flight were, from a small JSON file that the operator writes:
//
//     {"body": "mars",
//      "strips": [{"strip": 1, "keyframe": 1, "longitude": 137.4, "latitude": -4.6, "height": -4400.0,
//                  "azimuth": 12.5, "metres_per_unit": 2.03}]}
//
// The file has no other members: an unknown member is an error, so that a misspelt one is noticed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "sim/ground/export/body.hpp"

namespace ilp::exports {

struct StripAnchor {
  std::int64_t strip = 0;
  std::optional<std::int64_t> keyframe;  ///< whose camera is meant; none: the origin of the strip's world
  double longitude_deg = 0;              ///< east positive, -180 to 360
  double latitude_deg = 0;
  double height_m = 0;     ///< of the camera or the origin, above the body's figure
  double azimuth_deg = 0;  ///< of the world's +y, clockwise from north
  std::optional<double> metres_per_unit;
};

struct Anchors {
  const Body* body = nullptr;
  std::vector<StripAnchor> strips;

  [[nodiscard]] const StripAnchor* of(std::int64_t strip) const;
};

/// Throws std::runtime_error that names the file, the member and what is expected: malformed, a body that is none, a
/// place that is none on this body, or another body than `flown` (flown_body; null: not known).
[[nodiscard]] Anchors read_anchors(const std::filesystem::path& path, const Body* flown);

}  // namespace ilp::exports
