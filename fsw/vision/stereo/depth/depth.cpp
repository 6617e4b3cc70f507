#include "fsw/vision/stereo/depth/depth.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "cfg/limits.hpp"
#include "fsw/vision/stereo/depth/normalised_row.hpp"
#include "fsw/vision/stereo/rectify/polar_coordinates.hpp"

namespace ilp {
namespace {

constexpr float max_spread_px = 1.0F;

struct Sample {
  float disparity_px = 0;
  float sigma_px = 0;
};

float between(float first, float second, float weight) {
  return first + weight * (second - first);
}

Sample sample(ImageView<const float> disparity, ImageView<const float> sigma, double x, double y) {
  if (!(x > -0.5 && y > -0.5 && x < disparity.width - 0.5 && y < disparity.height - 0.5)) return {};
  const auto x0 = std::clamp(static_cast<std::int32_t>(std::floor(x)), 0, disparity.width - 2);
  const auto y0 = std::clamp(static_cast<std::int32_t>(std::floor(y)), 0, disparity.height - 2);
  const auto wx = static_cast<float>(std::clamp(x - x0, 0.0, 1.0));
  const auto wy = static_cast<float>(std::clamp(y - y0, 0.0, 1.0));
  const float* d0 = disparity.row(y0) + x0;
  const float* d1 = disparity.row(y0 + 1) + x0;
  const float* s0 = sigma.row(y0) + x0;
  const float* s1 = sigma.row(y0 + 1) + x0;
  const bool all_valid = s0[0] != 0 && s0[1] != 0 && s1[0] != 0 && s1[1] != 0;
  const bool supported = s0[0] < 0 || s0[1] < 0 || s1[0] < 0 || s1[1] < 0;
  const float lowest = std::min(std::min(d0[0], d0[1]), std::min(d1[0], d1[1]));
  const float highest = std::max(std::max(d0[0], d0[1]), std::max(d1[0], d1[1]));
  if (all_valid && highest - lowest <= max_spread_px) {
    const float upper = between(d0[0], d0[1], wx);
    const float lower = between(d1[0], d1[1], wx);
    const float s_upper = between(std::fabs(s0[0]), std::fabs(s0[1]), wx);
    const float s_lower = between(std::fabs(s1[0]), std::fabs(s1[1]), wx);
    const float s = between(s_upper, s_lower, wy);
    return {between(upper, lower, wy), supported ? -s : s};
  }
  const std::int32_t nx = wx >= 0.5F ? 1 : 0;
  return wy >= 0.5F ? Sample{d1[nx], s1[nx]} : Sample{d0[nx], s0[nx]};
}

struct InverseDepth {
  double value = 0, sigma = 0;
};

InverseDepth behind_homography(const RectifiedPair& pair, ImageView<const float> disparity,
                               ImageView<const float> sigma, const Vec3& q) {
  const double scale = pair.focal_px / q.z();
  const Sample s = sample(disparity, sigma, scale * q.x() + pair.cx_left, scale * q.y() + pair.cy);
  const double per_pixel = q.z() / (pair.focal_px * pair.baseline);
  return {(s.disparity_px - pair.disparity_offset_px()) * per_pixel, s.sigma_px * per_pixel};
}

InverseDepth behind_polar(const RectifiedPair& pair, ImageView<const float> disparity, ImageView<const float> sigma,
                          const Vec3& q, double cotangent, double azimuth) {
  const double advance = det_asinh(cotangent);
  const Sample s = sample(disparity, sigma, pair.focal_px * advance + pair.cx_left, polar_row(pair, azimuth));
  const double right = advance - (s.disparity_px - pair.disparity_offset_px()) / pair.focal_px;
  const double per_cotangent = std::sqrt(q.y() * q.y() + q.z() * q.z()) / pair.baseline;
  return {(cotangent - det_sinh(right)) * per_cotangent, s.sigma_px * det_cosh(right) * per_cotangent / pair.focal_px};
}

void store(const InverseDepth& inverse, float& value, float& sigma) {
  const bool usable = inverse.sigma != 0 && inverse.value > 0;
  value = usable ? static_cast<float>(inverse.value) : 0.0F;
  sigma = usable ? static_cast<float>(inverse.sigma) : 0.0F;
}

}  // namespace

Status depth_rows(const RectifiedPair& pair, const CameraModel& camera, ImageView<const float> disparity_px,
                  ImageView<const float> disparity_sigma_px, std::int32_t y_begin, std::int32_t y_end,
                  const DepthView& depth) {
  if (camera.width > limits::max_image_width || depth.inverse_depth.width != camera.width ||
      depth.inverse_depth.height != camera.height || depth.sigma.width != camera.width ||
      depth.sigma.height != camera.height) {
    return {StatusCode::invalid_argument, 1, depth.inverse_depth.width};
  }
  if (disparity_px.width != pair.width || disparity_px.height != pair.height ||
      disparity_sigma_px.width != pair.width || disparity_sigma_px.height != pair.height || pair.width < 2 ||
      pair.height < 2) {
    return {StatusCode::invalid_argument, 2, disparity_px.width};
  }
  if (y_begin < 0 || y_end > camera.height || y_begin > y_end) return {StatusCode::invalid_argument, 3, y_begin};
  std::array<double, static_cast<std::size_t>(limits::max_image_width)> ray_x;
  std::array<double, static_cast<std::size_t>(limits::max_image_width)> ray_y;
  for (std::int32_t y = y_begin; y < y_end; ++y) {
    float* out = depth.inverse_depth.row(y);
    float* out_sigma = depth.sigma.row(y);
    normalised_row(camera, y, ray_x.data(), ray_y.data());
    for (std::int32_t x = 0; x < camera.width; ++x) {
      const auto k = static_cast<std::size_t>(x);
      const Vec3 q = pair.rect_from_left * Vec3(ray_x[k], ray_y[k], 1);
      if (pair.method == RectificationMethod::homography) {
        store(behind_homography(pair, disparity_px, disparity_sigma_px, q), out[x], out_sigma[x]);
        continue;
      }
      const double cotangent = cotangent_of(q);
      // It is cheaper than the azimuth, and most pixels belong to other rings.
      if (!(cotangent >= pair.sector.low_cotangent && cotangent < pair.sector.high_cotangent)) continue;
      const double azimuth = azimuth_of(q);
      if (!contains(pair.sector, cotangent, azimuth)) continue;
      store(behind_polar(pair, disparity_px, disparity_sigma_px, q, cotangent, azimuth), out[x], out_sigma[x]);
    }
  }
  return {};
}

}  // namespace ilp
