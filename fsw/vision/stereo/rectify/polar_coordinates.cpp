#include "fsw/vision/stereo/rectify/polar_coordinates.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"

namespace ilp {

double det_asinh(double x) {
  const double size = std::min(std::fabs(x), 1e15);
  const double value = det_log(size + std::sqrt(size * size + 1));
  return x < 0 ? -value : value;
}

double det_sinh(double x) {
  const double e = det_exp(x);
  return 0.5 * (e - 1 / e);
}

double det_cosh(double x) {
  const double e = det_exp(x);
  return 0.5 * (e + 1 / e);
}

double cotangent_of(const Vec3& q) {
  return q.x() / std::sqrt(q.y() * q.y() + q.z() * q.z());
}

double advance_of(const Vec3& q) {
  return det_asinh(cotangent_of(q));
}

double azimuth_of(const Vec3& q) {
  return det_atan2(q.y(), q.z());
}

bool contains(const PolarSector& sector, double cotangent, double azimuth) {
  return cotangent >= sector.low_cotangent && cotangent < sector.high_cotangent && azimuth >= sector.low_azimuth &&
         azimuth < sector.high_azimuth;
}

double polar_row(const RectifiedPair& pair, double azimuth) {
  const double row = pair.focal_px * azimuth + pair.cy;
  const double turn = 2 * pi * pair.focal_px;
  return row - turn * std::floor((row - 0.5 * (pair.height - 1)) / turn + 0.5);
}

}  // namespace ilp
