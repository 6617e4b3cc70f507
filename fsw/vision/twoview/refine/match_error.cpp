#include "fsw/vision/twoview/refine/match_error.hpp"

#include <limits>

namespace ilp {

double sampson_squared(const Mat3& m, const NormalisedPair& pair, const PixelScale& scale) {
  const Vec3 line_b = m * pair.ray_a();
  const Vec3 line_a = m.transpose() * pair.ray_b();
  const double error = pair.ray_b().dot(line_b);
  const double g0 = line_b.x() / scale.bx;
  const double g1 = line_b.y() / scale.by;
  const double g2 = line_a.x() / scale.ax;
  const double g3 = line_a.y() / scale.ay;
  return error * error / (g0 * g0 + g1 * g1 + g2 * g2 + g3 * g3);
}

double transfer_squared(const Mat3& homography, const NormalisedPair& pair, const PixelScale& scale) {
  const Vec3 y = homography * pair.ray_a();
  if (!(y.z() > 0)) return std::numeric_limits<double>::infinity();
  const double du = (y.x() / y.z() - pair.xb) * scale.bx;
  const double dv = (y.y() / y.z() - pair.yb) * scale.by;
  return du * du + dv * dv;
}

double homography_sampson_squared(const Mat3& h, const NormalisedPair& p, const PixelScale& scale) {
  const Vec3 y = h * p.ray_a();
  if (!(y.z() > 0)) return std::numeric_limits<double>::infinity();
  // Two algebraic errors x_b w - u and y_b w - v, and their derivatives by the four coordinates in pixels.
  const double error[2] = {p.xb * y.z() - y.x(), p.yb * y.z() - y.y()};
  const double j[2][4] = {
      {(p.xb * h(2, 0) - h(0, 0)) / scale.ax, (p.xb * h(2, 1) - h(0, 1)) / scale.ay, y.z() / scale.bx, 0},
      {(p.yb * h(2, 0) - h(1, 0)) / scale.ax, (p.yb * h(2, 1) - h(1, 1)) / scale.ay, 0, y.z() / scale.by}};
  double c00 = 0;
  double c01 = 0;
  double c11 = 0;
  for (int k = 0; k < 4; ++k) {
    c00 += j[0][k] * j[0][k];
    c01 += j[0][k] * j[1][k];
    c11 += j[1][k] * j[1][k];
  }
  return (error[0] * error[0] * c11 - 2 * error[0] * error[1] * c01 + error[1] * error[1] * c00) /
         (c00 * c11 - c01 * c01);
}

}  // namespace ilp
