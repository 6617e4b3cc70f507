#include "sim/ground/intake/strip_track.hpp"

namespace ilp::intake {

std::vector<TrackPoint> track_of(const Flight& flight, const Strip& strip) {
  std::vector<TrackPoint> track;
  for (const std::int64_t id : strip.keyframes) {
    const Keyframe& keyframe = flight.keyframes.at(id);
    if (!keyframe.posed()) continue;
    const double(&c)[3] = keyframe.pose->centre;
    track.push_back({id, Vec3(c[0], c[1], c[2])});
  }
  return track;
}

const char* unit_of(const Flight& flight, const Strip& strip) {
  for (const std::int64_t id : strip.keyframes) {
    const Keyframe& keyframe = flight.keyframes.at(id);
    if (keyframe.posed() && keyframe.pose->scale_source == ScaleSource::altimeter) return "m";
  }
  return "units";
}

}  // namespace ilp::intake
