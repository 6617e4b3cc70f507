// The pose of a keyframe beside what the vehicle measured there.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/records/records.hpp"
#include "fsw/shared/body_figure.hpp"
#include "fsw/vision/navigation/strip_frame.hpp"

namespace ilp {

/// Whether places come at all: a mission without a body, or without map and measurements, has none.
[[nodiscard]] inline bool has_places(const MissionParameters& mission) {
  return mission.body != Body::none && (mission.use_map || mission.use_navigation);
}
/// Whether the record says where on the body the keyframe was taken.
[[nodiscard]] inline bool has_place(const NavigationRecord& measured, Body body) {
  return measured.horizontal_sigma_m > 0 && body != Body::none;
}
[[nodiscard]] inline BodyPlace place_of(const NavigationRecord& measured) {
  return {measured.longitude_deg, measured.latitude_deg, measured.elevation_m};
}
[[nodiscard]] inline BodyPlace map_origin_of(const FixRecord& fix) {
  return {fix.map_longitude_deg, fix.map_latitude_deg, 0};
}
/// What an accepted fix says, on the plane about `origin` (local_plane.hpp); of a map without a body on its own plane.
/// Empty where the record's numbers are none that a fix can have.
[[nodiscard]] navigation::FixMeasurement fix_measurement(const FixRecord& fix, const BodyPlace& origin);

/// Places count from `origin`.
[[nodiscard]] navigation::MeasuredKeyframe measured_keyframe(const PoseRecord& pose, const NavigationRecord& measured,
                                                             Body body, const BodyPlace& origin);

}  // namespace ilp
