#include "tests/unit/tools/score/made_up_strip.hpp"

#include <cmath>

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp::test {

host::Similarity3 strip_from_true() {
  host::Similarity3 s{
      .scale = 1 / 23.7, .rotation = rotation_from_vector(Vec3(0.9, -1.7, 0.6)), .translation = Vec3(11, -3, 0.7)};
  return s;
}

score::StripTrack make_track(std::size_t count, double step) {
  const host::Similarity3 moved = strip_from_true();
  score::StripTrack track{.flying_height = 100};
  Mat3 nadir;
  nadir << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = step * static_cast<double>(i);
    score::PoseSample s;
    s.keyframe_id = static_cast<std::int64_t>(i + 1);
    s.true_centre = Vec3(x, 6 * std::sin(x / 90), 100 + 2 * std::sin(x / 40));
    s.true_cam_from_world = rotation_from_vector(Vec3(0.02 * std::sin(x / 30), 0.03 * std::cos(x / 50), 0)) * nadir;
    s.centre = moved * s.true_centre;
    s.cam_from_world = s.true_cam_from_world * moved.rotation.transpose();
    track.samples.push_back(s);
  }
  return track;
}

void displace(score::PoseSample& sample, const Vec3& error) {
  const host::Similarity3 moved = strip_from_true();
  sample.centre += moved.scale * (moved.rotation * error);
}

}  // namespace ilp::test
