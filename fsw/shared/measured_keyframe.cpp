#include "fsw/shared/measured_keyframe.hpp"

#include <algorithm>

namespace ilp {

navigation::MeasuredKeyframe measured_keyframe(const PoseRecord& pose, const NavigationRecord& measured, Body body,
                                               const BodyPlace& origin) {
  navigation::MeasuredKeyframe out;
  out.keyframe_id = pose.id;
  out.time_ns = measured.time_ns;
  std::copy_n(pose.centre, 3, out.centre);
  std::copy_n(pose.q_cam_from_world, 4, out.q_cam_from_strip);
  out.ground_distance = pose.ground_distance;
  out.ground_distance_sigma = pose.ground_distance_sigma;
  out.height_m = measured.height_m;
  out.height_sigma_m = measured.height_sigma_m;
  std::copy_n(measured.q_cam_from_level, 4, out.q_cam_from_level);
  out.tilt_sigma_rad = measured.tilt_sigma_rad;
  out.heading_sigma_rad = measured.heading_sigma_rad;
  if (has_place(measured, body)) {
    offset_from(body, origin, place_of(measured), out.place_m);
    out.horizontal_sigma_m = measured.horizontal_sigma_m;
    out.vertical_sigma_m = measured.vertical_sigma_m;
  }
  std::copy_n(measured.velocity_m_s, 3, out.velocity_m_s);
  out.velocity_sigma_m_s = measured.velocity_sigma_m_s;
  return out;
}

}  // namespace ilp
