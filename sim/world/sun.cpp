#include "sim/world/sun.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"
#include "sim/world/lattice_noise.hpp"

namespace ilp::sim {

SunPath::SunPath(double azimuth_rad, double elevation_rad, double spacing_m) {
  const double x = det_cos(azimuth_rad);
  const double y = det_sin(azimuth_rad);
  sun_ = Vec3(det_cos(elevation_rad) * x, det_cos(elevation_rad) * y, det_sin(elevation_rad));
  along_x_ = std::fabs(x) >= std::fabs(y);
  const double major = along_x_ ? x : y;
  direction_ = major < 0 ? -1 : 1;
  drift_ = (along_x_ ? y : x) / std::fabs(major);
  rise_m_ = spacing_m / std::fabs(major) * det_sin(elevation_rad) / std::max(det_cos(elevation_rad), 1e-9);
}

double SunPath::facing(double slope_x, double slope_y) const {
  const double cosine =
      (sun_.z() - sun_.x() * slope_x - sun_.y() * slope_y) / std::sqrt(1 + slope_x * slope_x + slope_y * slope_y);
  return std::max(0.0, cosine) / sun_.z();
}

void SunPath::shading_heights(const double* row, std::int32_t stride, std::int32_t count,
                              std::vector<double>& out) const {
  out.assign(static_cast<std::size_t>(count), -1e300);
  for (std::int32_t step = 1; step <= length; ++step) {
    const double aside = step * drift_;
    const std::int32_t before = floor_to_int(aside);
    const double weight = aside - before;
    const std::ptrdiff_t major = static_cast<std::ptrdiff_t>(step) * direction_;
    const std::ptrdiff_t near =
        along_x_ ? before * static_cast<std::ptrdiff_t>(stride) + major : major * stride + before;
    // At 45 degrees the last crossing is on a post: its neighbour, of weight zero, may lie outside the grid.
    const std::ptrdiff_t far = weight > 0 ? near + (along_x_ ? stride : 1) : near;
    const double* const a = row + near;
    const double* const b = row + far;
    const double drop = step * rise_m_;
    for (std::int32_t i = 0; i < count; ++i) {
      const double height = a[i] + (b[i] - a[i]) * weight - drop;
      out[static_cast<std::size_t>(i)] = std::max(out[static_cast<std::size_t>(i)], height);
    }
  }
}

}  // namespace ilp::sim
