#include "fsw/vision/stereo/depth/normalised_row.hpp"

#include <algorithm>
#include <array>

#include "cfg/limits.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

constexpr std::int32_t anchor_step = 4;
constexpr std::int32_t max_anchors = limits::max_image_width / anchor_step + 2;
using Anchors = std::array<double, static_cast<std::size_t>(max_anchors)>;

/// The exact coordinates at every fourth pixel from `first` on, the last one beyond the end.
void find_anchors(const CameraModel& camera, std::int32_t y, std::int32_t first, std::int32_t count, Anchors& x_out,
                  Anchors& y_out) {
  const double distorted_y = normalised_from_ideal(camera, Vec2(0, y)).y();
  for (std::int32_t i = 0; i < count; ++i) {
    x_out[static_cast<std::size_t>(i)] = (first + i * anchor_step - camera.cx) / camera.fx;
    y_out[static_cast<std::size_t>(i)] = distorted_y;
  }
  undistort(camera, count, x_out.data(), y_out.data());
}

void interpolate(const Anchors& anchors, std::int32_t width, double* __restrict out) {
  std::int32_t first = 0;
  for (; first + anchor_step <= width; first += anchor_step) {
    const auto k = static_cast<std::size_t>(first / anchor_step);
    const double step = (anchors[k + 1] - anchors[k]) / anchor_step;
    for (std::int32_t i = 0; i < anchor_step; ++i) out[first + i] = anchors[k] + i * step;
  }
  for (std::int32_t x = first; x < width; ++x) {
    const auto k = static_cast<std::size_t>(first / anchor_step);
    out[x] = anchors[k] + (x - first) * ((anchors[k + 1] - anchors[k]) / anchor_step);
  }
}

}  // namespace

void normalised_row(const CameraModel& camera, std::int32_t y, std::int32_t first, std::int32_t count, double* x_out,
                    double* y_out) {
  Anchors anchors_x, anchors_y;
  find_anchors(camera, y, first, (count + anchor_step - 1) / anchor_step + 1, anchors_x, anchors_y);
  with_widest_vectors([&] {
    interpolate(anchors_x, count, x_out);
    interpolate(anchors_y, count, y_out);
  });
}

}  // namespace ilp
