// The track of the camera over a strip, and its unit.
#pragma once

#include <vector>

#include "fsw/vision/geometry/types.hpp"
#include "sim/ground/intake/flight_model.hpp"

namespace ilp::intake {

/// Camera centres of the posed keyframes, in order, with their ids.
struct TrackPoint {
  std::int64_t keyframe_id = 0;
  Vec3 centre = Vec3::Zero();
};
[[nodiscard]] std::vector<TrackPoint> track_of(const Flight& flight, const Strip& strip);

/// "m" when an altimeter fixed the scale, else "units" (of which the first baseline is 1).
[[nodiscard]] const char* unit_of(const Flight& flight, const Strip& strip);

}  // namespace ilp::intake
