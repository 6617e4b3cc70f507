// The pictures of a strip as figures of the page: PNG inside SVG with the track drawn over it.
#pragma once

#include <string>

#include "sim/ground/report.hpp"

namespace ilp::ground {

struct StripFigures {
  std::string ortho, relief, oblique;  ///< <figure> elements; empty without a grid
};
[[nodiscard]] StripFigures strip_figures(const Flight& flight, const StripResult& strip);

/// Camera centres of the posed keyframes, in order, with their ids.
struct TrackPoint {
  std::int64_t keyframe_id = 0;
  Vec3 centre = Vec3::Zero();
};
[[nodiscard]] std::vector<TrackPoint> track_of(const Flight& flight, const Strip& strip);

/// "m" when an altimeter fixed the scale, else "units" (of which the first baseline is 1).
[[nodiscard]] const char* unit_of(const Flight& flight, const Strip& strip);

}  // namespace ilp::ground
