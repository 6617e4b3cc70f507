// Keeps reduced images of the latest keyframes of a strip. If the map is so coarse that one image has too few patches,
// these keyframes are registered together.
#pragma once

#include <array>
#include <span>

#include "fsw/base/fixed_vector.hpp"
#include "fsw/records/records.hpp"
#include "fsw/vision/map/map_plan.hpp"

namespace ilp {

inline constexpr std::size_t most_together = 9;  ///< keyframes that are registered together, the present one included
/// Most pixels of a reduced image, whose sides have at least min_image_side px. A cell of such a coarse map still
/// contains several of these pixels.
inline constexpr std::size_t max_small_pixels = 8640;

/// Trivially copyable, as a part of the stage's state: the image itself may be released before the next keyframe.
struct SmallKeyframe {
  std::int64_t id = 0;
  double q_cam_from_strip[4] = {1, 0, 0, 0};
  double centre[3] = {0, 0, 0};  ///< strip units
  CameraModel camera;            ///< camera of the reduced image
  std::array<std::uint8_t, max_small_pixels> pixels{};
};
/// In order of keyframes, all of one strip.
using SmallKeyframes = FixedVector<SmallKeyframe, most_together>;

/// Whether one image has too few patches for a verdict. `image_pixels` is the ratio of the working pixel to the image's
/// pixel on the ground.
[[nodiscard]] bool holds_few_patches(const CameraModel& camera, double image_pixels);

/// Keeps the image of a keyframe, reduced by mean_of_squares(); drops the oldest one if necessary. An image that is
/// much longer than wide is not kept.
void keep_small(const MapKeyframe& keyframe, const PoseRecord& pose, SmallKeyframes& kept);

/// Fills `together` with `first` and the earlier keyframes of `kept`, the latest first. Their poses on the map follow
/// from that of `first` and the poses of the strip, whose unit is `metres_per_unit`. The list ends at the first
/// keyframe that is farther from `first` than `farthest_m`. Returns the number of keyframes. Their views refer to the
/// images in `kept`.
std::size_t put_together(const MapKeyframe& first, const PoseRecord& pose, const SmallKeyframes& kept,
                         double metres_per_unit, double farthest_m, std::array<MapKeyframe, most_together>& together);

}  // namespace ilp
