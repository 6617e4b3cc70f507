#include "sim/world/visibility.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "fsw/vision/geometry/camera.hpp"

namespace ilp::world {
namespace {

constexpr double occlusion_tolerance = 0.01;  // of the depth

bool is_depth(float z) {
  return z > 0 && std::isfinite(z);
}

bool inside_box(const TrueFrame& frame, const Vec3& point) {
  return (point.array() >= frame.low.array()).all() && (point.array() <= frame.high.array()).all();
}

void find_box(TrueFrame& frame) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  frame.low = Vec3::Constant(infinite);
  frame.high = Vec3::Constant(-infinite);
  double farthest = 0;
  for (std::size_t i = 0; i < frame.depth.size(); ++i) {
    if (!is_depth(frame.depth[i])) continue;
    frame.low = frame.low.cwiseMin(frame.ground[i]);
    frame.high = frame.high.cwiseMax(frame.ground[i]);
    farthest = std::max(farthest, static_cast<double>(frame.depth[i]));
  }
  // Outermost samples stand half a block inside the image; relief between samples may rise above them.
  const double margin =
      2.0 * frame.stride * farthest / std::min(frame.camera.fx, frame.camera.fy) + occlusion_tolerance * farthest;
  frame.low.array() -= margin;
  frame.high.array() += margin;
}

/// All four samples around the pixel are nearer than the point.
bool hidden(const TrueFrame& frame, const Vec2& pixel, double depth) {
  const double middle = 0.5 * (frame.stride - 1);
  const auto left = static_cast<std::int32_t>(std::floor((pixel.x() - middle) / frame.stride));
  const auto top = static_cast<std::int32_t>(std::floor((pixel.y() - middle) / frame.stride));
  for (std::int32_t j = top; j <= top + 1; ++j) {
    for (std::int32_t i = left; i <= left + 1; ++i) {
      const float z = frame.depth[frame.index(std::clamp(i, 0, frame.columns - 1), std::clamp(j, 0, frame.rows - 1))];
      if (!is_depth(z) || depth <= z * (1 + occlusion_tolerance)) return false;
    }
  }
  return true;
}

/// Share of an interval of length `size` around `middle` that lies in [-0.5, extent - 0.5].
double share_inside(double middle, double size, double extent) {
  const double low = std::max(middle - 0.5 * size, -0.5), high = std::min(middle + 0.5 * size, extent - 0.5);
  return std::max(0.0, high - low) / size;
}

bool project_anywhere(const TrueFrame& frame, const Vec3& point, Vec2& pixel, double& depth) {
  const Vec3 p = frame.cam_from_world * (point - frame.centre);
  depth = p.z();
  if (!(depth > 0)) return false;
  pixel = Vec2(p.x() / depth, p.y() / depth);
  // Distortion is defined over the image only: far outside, its polynomial may come back into it.
  const CameraModel& c = frame.camera;
  const double reach_x = 1.5 * std::max(c.cx, c.width - c.cx) / c.fx;
  const double reach_y = 1.5 * std::max(c.cy, c.height - c.cy) / c.fy;
  const bool bounded = c.lens != Lens::fisheye;
  if (bounded && (std::fabs(pixel.x()) > reach_x || std::fabs(pixel.y()) > reach_y)) return false;
  pixel = pixel_from_normalised(c, pixel);
  return true;
}

double overlap(const TrueFrame& a, const TrueFrame& b, bool with_occlusion) {
  double seen = 0, area = 0;
  for (std::int32_t j = 0; j < a.rows; ++j) {
    const double block_height = std::min(a.stride, a.camera.height - j * a.stride);
    for (std::int32_t i = 0; i < a.columns; ++i) {
      const double block_width = std::min(a.stride, a.camera.width - i * a.stride);
      area += block_width * block_height;
      const std::size_t k = a.index(i, j);
      if (!is_depth(a.depth[k])) continue;
      Vec2 pixel;
      double depth = 0;
      if (!project_anywhere(b, a.ground[k], pixel, depth)) continue;
      const double scale = a.depth[k] / depth;
      const double share = share_inside(pixel.x(), block_width * scale * b.camera.fx / a.camera.fx, b.camera.width) *
                           share_inside(pixel.y(), block_height * scale * b.camera.fy / a.camera.fy, b.camera.height);
      if (share > 0 && !(with_occlusion && hidden(b, pixel, depth))) seen += share * block_width * block_height;
    }
  }
  return area > 0 ? seen / area : 0;
}

template <typename Predicate>
host::Raster<std::uint8_t> mask_of(const TrueFrame& frame, Predicate inside) {
  host::Raster<std::uint8_t> mask(frame.columns, frame.rows);
  for (std::size_t k = 0; k < frame.ground.size(); ++k) {
    mask.samples[k] = inside(frame.ground[k], frame.depth[k]) ? 255 : 0;
  }
  return mask;
}

double depth_in(const TrueFrame& frame, const Vec3& point) {
  return frame.cam_from_world.row(2) * (point - frame.centre);
}

bool can_meet(const TrueFrame& a, const TrueFrame& b) {
  return (a.low.array() <= b.high.array()).all() && (b.low.array() <= a.high.array()).all();
}

}  // namespace

TrueFrame true_frame(const CameraModel& camera, const Mat3& cam_from_world, const Vec3& centre,
                     ImageView<const float> depth, std::int32_t stride) {
  if (depth.width != camera.width || depth.height != camera.height || depth.empty()) {
    throw std::invalid_argument("a true depth map of " + std::to_string(depth.width) + " x " +
                                std::to_string(depth.height) + " pixels; the camera has " +
                                std::to_string(camera.width) + " x " + std::to_string(camera.height));
  }
  if (stride < 1 || stride % 2 == 0) {
    throw std::invalid_argument("a sampling stride of " + std::to_string(stride) + "; expected an odd number from 1");
  }
  TrueFrame frame;
  frame.camera = camera;
  frame.cam_from_world = cam_from_world;
  frame.centre = centre;
  frame.stride = stride;
  frame.columns = (camera.width + stride - 1) / stride;
  frame.rows = (camera.height + stride - 1) / stride;
  const Mat3 world_from_cam = cam_from_world.transpose();
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  for (std::int32_t j = 0; j < frame.rows; ++j) {
    const std::int32_t y = j * stride + (std::min(stride, camera.height - j * stride) - 1) / 2;
    for (std::int32_t i = 0; i < frame.columns; ++i) {
      const std::int32_t x = i * stride + (std::min(stride, camera.width - i * stride) - 1) / 2;
      const float z = depth.at(x, y);
      const Vec2 n = normalised_from_pixel(camera, Vec2(x, y));
      frame.depth.push_back(z);
      frame.ground.push_back(is_depth(z) ? Vec3(centre + world_from_cam * (z * Vec3(n.x(), n.y(), 1)))
                                         : Vec3(none, none, none));
    }
  }
  find_box(frame);
  return frame;
}

std::int32_t sample_stride(const CameraModel& camera) {
  return std::max(1, camera.width / 256 * 2 + 1);
}

bool project(const TrueFrame& frame, const Vec3& point, Vec2& pixel, double& depth) {
  return project_anywhere(frame, point, pixel, depth) && pixel.x() >= -0.5 && pixel.y() >= -0.5 &&
         pixel.x() <= frame.camera.width - 0.5 && pixel.y() <= frame.camera.height - 0.5;
}

bool sees(const TrueFrame& frame, const Vec3& point) {
  if (!inside_box(frame, point)) return false;  // also what is not finite
  Vec2 pixel;
  double depth = 0;
  return project(frame, point, pixel, depth) && !hidden(frame, pixel, depth);
}

double true_overlap(const TrueFrame& a, const TrueFrame& b) {
  return can_meet(a, b) ? overlap(a, b, true) : 0;
}

double true_footprint_overlap(const TrueFrame& a, const TrueFrame& b) {
  return can_meet(a, b) ? overlap(a, b, false) : 0;
}

host::Raster<std::uint8_t> visible_before_mask(const TrueFrame& frame, std::span<const TrueFrame* const> earlier) {
  // Latest first: nearly everything is seen in the frame before.
  std::vector<const TrueFrame*> near;
  for (auto other = earlier.rbegin(); other != earlier.rend(); ++other) {
    if (can_meet(frame, **other)) near.push_back(*other);
  }
  return mask_of(frame, [&](const Vec3& point, double) {
    return std::any_of(near.begin(), near.end(), [&](const TrueFrame* other) { return sees(*other, point); });
  });
}

host::Raster<std::uint8_t> newly_seen_mask(const TrueFrame& frame, const TrueFrame* partner,
                                           std::span<const FramePair> earlier_pairs, double finer) {
  std::vector<FramePair> near;
  for (auto pair = earlier_pairs.rbegin(); pair != earlier_pairs.rend(); ++pair) {
    if (can_meet(frame, *pair->first) && can_meet(frame, *pair->second)) near.push_back(*pair);
  }
  const auto seen_by = [&frame](const TrueFrame& other, const Vec3& point) {
    return &other == &frame || sees(other, point);
  };
  return mask_of(frame, [&](const Vec3& point, double depth) {
    if (partner != nullptr && !sees(*partner, point)) return false;
    return std::none_of(near.begin(), near.end(), [&](const FramePair& pair) {
      return depth_in(*pair.first, point) <= finer * depth && seen_by(*pair.first, point) &&
             seen_by(*pair.second, point);
    });
  });
}

}  // namespace ilp::world
