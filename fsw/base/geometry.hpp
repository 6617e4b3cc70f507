// Plain geometry that records, configuration and kernels share. Conventions (architecture, "Frames and units"):
// camera x right, y down, z forward; pixel (0,0) is the centre of the top-left pixel; x_cam = R (X_world - C).
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "fsw/base/enumeration.hpp"

namespace ilp {

/// The projection model of a lens.
ILP_ENUMERATION(Lens, (0, brown, "pinhole with Brown or rational distortion"), (1, fisheye, "equidistant fisheye"))

/// Intrinsics of a camera, which project a point (X, Y, Z) of the camera frame to the pixel (u, v). With x = X/Z,
/// y = Y/Z, r2 = x^2 + y^2, and pixel centres at integers (COLMAP's cx is this cx + 0.5),
///   u = fx x_d + cx, v = fy y_d + cy.
/// brown (COLMAP's OPENCV and FULL_OPENCV, OpenCV's four, five and eight coefficients):
///   s = (1 + k1 r2 + k2 r2^2 + k3 r2^3) / (1 + k4 r2 + k5 r2^2 + k6 r2^3)
///   x_d = x s + 2 p1 x y + p2 (r2 + 2 x^2), y_d = y s + p1 (r2 + 2 y^2) + 2 p2 x y
/// fisheye (COLMAP's OPENCV_FISHEYE, OpenCV's fisheye, Kalibr's equidistant; p1 = p2 = k5 = k6 = 0): with the angle
/// a = atan(r) from the optical axis,
///   s = a (1 + k1 a^2 + k2 a^4 + k3 a^6 + k4 a^8) / r, x_d = x s, y_d = y s
struct CameraModel {
  std::int32_t width = 0;   ///< px
  std::int32_t height = 0;  ///< px
  double fx = 0, fy = 0;    ///< px
  double cx = 0, cy = 0;    ///< px
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;
  double k3 = 0, k4 = 0, k5 = 0, k6 = 0;
  Lens lens = Lens::brown;
  /// Rolling shutter: time from the exposure of the first row to that of the last row, s. Negative: the last row is
  /// exposed first. 0: all rows are exposed at once. A frame's time and pose are those of its middle row.
  double readout_s = 0;

  /// A pinhole camera with no other distortion than k1, k2, p1 and p2.
  [[nodiscard]] bool is_plain() const { return lens == Lens::brown && k3 == 0 && k4 == 0 && k5 == 0 && k6 == 0; }
  [[nodiscard]] bool has_distortion() const { return !is_plain() || k1 != 0 || k2 != 0 || p1 != 0 || p2 != 0; }
  bool operator==(const CameraModel&) const = default;
};

/// The intrinsics as a list of numbers, without the image size and the readout: fx fy cx cy k1 k2 p1 p2, and for a
/// camera that is not plain also k3 k4 k5 k6 and the number of the lens.
struct CameraNumbers {
  static constexpr std::size_t plain = 8, most = 13;
  std::array<double, most> values{};
  std::size_t count = 0;

  [[nodiscard]] std::span<const double> span() const { return std::span(values).first(count); }
};
[[nodiscard]] inline CameraNumbers camera_numbers(const CameraModel& c) {
  return {{c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3, c.k4, c.k5, c.k6, static_cast<double>(c.lens)},
          c.is_plain() ? CameraNumbers::plain : CameraNumbers::most};
}
/// The inverse of camera_numbers(). `n` has CameraNumbers::plain or CameraNumbers::most numbers.
[[nodiscard]] inline CameraModel camera_of_numbers(std::int32_t width, std::int32_t height, std::span<const double> n) {
  CameraModel c{width, height, n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7]};
  if (n.size() < CameraNumbers::most) return c;
  c.k3 = n[8];
  c.k4 = n[9];
  c.k5 = n[10];
  c.k6 = n[11];
  c.lens = n[12] == 1 ? Lens::fisheye : Lens::brown;
  return c;
}

/// Whether the squared norm of `q` differs from 1 by less than 1e-3, which is more than rounding causes.
[[nodiscard]] inline bool is_unit_quaternion(const double (&q)[4]) {
  constexpr double most_apart = 1e-3;
  const double norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  return norm2 > 1 - most_apart && norm2 < 1 + most_apart;
}

/// Attitude and position of a camera.
struct Pose {
  double q_cam_from_world[4] = {1, 0, 0, 0};  ///< unit quaternion w, x, y, z
  double centre[3] = {0, 0, 0};               ///< camera centre in the strip's world frame, in strip units
};

/// Similarity b_from_a between two images: x_b = scale * R(rotation_rad) * x_a + shift, with R(a) = [cos a, -sin a;
/// sin a, cos a] and the origin in pixel (0,0).
struct Similarity2 {
  double scale = 1;
  double rotation_rad = 0;
  double shift_x_px = 0;
  double shift_y_px = 0;
};

}  // namespace ilp
