#include "sim/ground/intake/level_strips.hpp"

#include <cmath>

#include "fsw/vision/geometry/similarity.hpp"
#include "sim/ground/intake/move_keyframe.hpp"

namespace ilp::intake {
namespace {

bool plausible(const StripFrameRecord& frame) {
  return is_unit_quaternion(frame.q_level_from_strip) && frame.metres_per_unit > 1e-6 && frame.metres_per_unit < 1e6 &&
         std::isfinite(frame.scale_sigma);
}

}  // namespace

void level_strips(Flight& flight) {
  for (auto& [id, strip] : flight.strips) {
    if (!strip.frame) continue;
    if (!plausible(*strip.frame)) {
      flight.remarks.push_back("strip " + std::to_string(id) + ": its place by the vehicle's navigation is none");
      strip.frame.reset();
      continue;
    }
    const bool metric = strip.frame->scale_sigma > 0;
    Similarity by;
    if (metric) by.scale = strip.frame->metres_per_unit;
    by.rotation = rotation_from_quaternion(strip.frame->q_level_from_strip);
    for (const std::int64_t keyframe_id : strip.keyframes) {
      Keyframe& keyframe = flight.keyframes.at(keyframe_id);
      move(by, keyframe);
      if (metric && keyframe.pose) keyframe.pose->scale_source = ScaleSource::navigation;
    }
  }
}

}  // namespace ilp::intake
