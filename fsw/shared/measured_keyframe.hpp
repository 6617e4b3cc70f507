// The pose of a keyframe beside what the vehicle measured there.
#pragma once

#include "fsw/records/records.hpp"
#include "fsw/shared/body_figure.hpp"
#include "fsw/vision/navigation/strip_frame.hpp"

namespace ilp {

/// Whether the record says where on the body the keyframe was taken.
[[nodiscard]] inline bool has_place(const NavigationRecord& measured, Body body) {
  return measured.horizontal_sigma_m > 0 && body != Body::none;
}
[[nodiscard]] inline BodyPlace place_of(const NavigationRecord& measured) {
  return {measured.longitude_deg, measured.latitude_deg, measured.elevation_m};
}
/// Places count from `origin`.
[[nodiscard]] navigation::MeasuredKeyframe measured_keyframe(const PoseRecord& pose, const NavigationRecord& measured,
                                                             Body body, const BodyPlace& origin);

}  // namespace ilp
