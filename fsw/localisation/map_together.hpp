// The latest keyframes of a strip, kept small: where the map's pixel is so coarse that one image holds too few pieces,
// they are registered together.
#pragma once

#include <array>
#include <span>

#include "fsw/base/fixed_vector.hpp"
#include "fsw/records/records.hpp"
#include "fsw/vision/map/map_plan.hpp"

namespace ilp {

inline constexpr std::size_t most_together = 9;  ///< keyframes, the one at work among them
/// Of a small image, whose sides have min_image_side at least: some of them lie in a cell of so coarse a map.
inline constexpr std::size_t max_small_pixels = 8640;

/// Trivially copyable, as a part of the stage's state: the image itself may be released before the next keyframe.
struct SmallKeyframe {
  std::int64_t id = 0;
  double q_cam_from_strip[4] = {1, 0, 0, 0};
  double centre[3] = {0, 0, 0};  ///< strip units
  CameraModel camera;            ///< of the small image
  std::array<std::uint8_t, max_small_pixels> pixels{};
};
/// In order of keyframes, all of one strip.
using SmallKeyframes = FixedVector<SmallKeyframe, most_together>;

/// Whether one image, with so many of its pixels in a working pixel, holds too few patches for a verdict.
[[nodiscard]] bool holds_few_patches(const CameraModel& camera, double image_pixels);

/// Keeps the image of a keyframe by the means of squares; the oldest one makes room. An image that is much longer than
/// wide is not kept.
void keep_small(const MapKeyframe& keyframe, const PoseRecord& pose, SmallKeyframes& kept);

/// Puts `first` and those of `kept` before it, the latest first, as they stand to it by the poses of the strip, whose
/// unit is `metres_per_unit` long. Those are left out that are farther than `farthest_m`. Returns the number of all.
/// The images stay where they are kept.
std::size_t put_together(const MapKeyframe& first, const PoseRecord& pose, const SmallKeyframes& kept,
                         double metres_per_unit, double farthest_m, std::array<MapKeyframe, most_together>& together);

}  // namespace ilp
