#include "fsw/localisation/map_together.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/localisation/reduced_image.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {
namespace {

constexpr double least_patches = 16;

/// Pixels along a side that become one; 0: no number serves.
std::int32_t reduction_of(const GrayView& image) {
  const std::int32_t most = std::min(image.width, image.height) / limits::min_image_side;
  for (std::int32_t factor = 1; factor <= most; ++factor) {
    const std::int64_t pixels = std::int64_t{image.width / factor} * (image.height / factor);
    if (pixels <= static_cast<std::int64_t>(max_small_pixels)) return factor;
  }
  return 0;
}

/// Of the image reduced: pixel 0 covers the first `factor` ones.
CameraModel reduced(CameraModel camera, std::int32_t factor) {
  camera.width /= factor;
  camera.height /= factor;
  camera.fx /= factor;
  camera.fy /= factor;
  camera.cx = (camera.cx + 0.5) / factor - 0.5;
  camera.cy = (camera.cy + 0.5) / factor - 0.5;
  return camera;
}

}  // namespace

bool holds_few_patches(const CameraModel& camera, double image_pixels) {
  const double side = image_pixels * map_patch_px(image_pixels);
  return camera.width / side * (camera.height / side) < least_patches;
}

void keep_small(const MapKeyframe& keyframe, const PoseRecord& pose, SmallKeyframes& kept) {
  const std::int32_t factor = reduction_of(keyframe.image);
  if (factor == 0) return;
  if (kept.full()) kept.erase(0);
  static_cast<void>(kept.push_back({}));
  SmallKeyframe& small = kept.back();
  small.id = pose.id;
  std::copy_n(pose.q_cam_from_world, 4, small.q_cam_from_strip);
  std::copy_n(pose.centre, 3, small.centre);
  small.camera = reduced(keyframe.camera, factor);
  mean_of_squares(keyframe.image, factor, {small.pixels.data(), small.camera.width, small.camera.height});
}

std::size_t put_together(const MapKeyframe& first, const PoseRecord& pose, const SmallKeyframes& kept,
                         double metres_per_unit, double farthest_m, std::array<MapKeyframe, most_together>& together) {
  together[0] = first;
  std::size_t count = 1;
  const Mat3 map_from_strip =
      first.camera_from_map.rotation.transpose() * rotation_from_quaternion(pose.q_cam_from_world);
  const Vec3 centre = camera_centre(first.camera_from_map);
  for (std::size_t back = 0; back < kept.size() && count < most_together; ++back) {
    const SmallKeyframe& small = kept[kept.size() - 1 - back];
    if (small.id >= pose.id) continue;
    const Vec3 way = metres_per_unit * (map_from_strip * (vector_of(small.centre) - vector_of(pose.centre)));
    if (!(way.norm() <= farthest_m)) break;
    MapKeyframe& keyframe = together[count++];
    keyframe.image = {small.pixels.data(), small.camera.width, small.camera.height};
    keyframe.camera = small.camera;
    keyframe.camera_from_map.rotation = rotation_from_quaternion(small.q_cam_from_strip) * map_from_strip.transpose();
    keyframe.camera_from_map.translation = -(keyframe.camera_from_map.rotation * (centre + way));
  }
  return count;
}

}  // namespace ilp
