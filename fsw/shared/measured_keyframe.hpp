// Combines a keyframe's pose with the vehicle's measurements or a fix, as input for the estimation of the strip frame.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/records/records.hpp"
#include "fsw/shared/body_figure.hpp"
#include "fsw/vision/navigation/strip_frame.hpp"

namespace ilp {

/// Whether keyframes of the mission can have positions on a body: it has a body, and a map or navigation.
[[nodiscard]] inline bool has_places(const MissionParameters& mission) {
  return mission.body != Body::none && (mission.use_map || mission.use_navigation);
}
/// Whether the record has the position on the body at which the keyframe was taken.
[[nodiscard]] inline bool has_place(const NavigationRecord& measured, Body body) {
  return measured.horizontal_sigma_m > 0 && body != Body::none;
}
[[nodiscard]] inline BodyPlace place_of(const NavigationRecord& measured) {
  return {measured.longitude_deg, measured.latitude_deg, measured.elevation_m};
}
/// The origin of the plane of the fix's map.
[[nodiscard]] inline BodyPlace map_origin_of(const FixRecord& fix) {
  return {fix.map_longitude_deg, fix.map_latitude_deg, 0};
}
/// The measurement of an accepted fix on the plane about `origin` (local_plane.hpp), or on the map's own plane if the
/// map has no body. Empty if the fix is not accepted or its record has values that no fix can have.
[[nodiscard]] navigation::FixMeasurement fix_measurement(const FixRecord& fix, const BodyPlace& origin);

/// The pose and the vehicle's measurements of a keyframe. Its position is the offset from `origin`.
[[nodiscard]] navigation::MeasuredKeyframe measured_keyframe(const PoseRecord& pose, const NavigationRecord& measured,
                                                             Body body, const BodyPlace& origin);

}  // namespace ilp
