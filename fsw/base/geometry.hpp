// Plain geometry that records, configuration and kernels share. Conventions (architecture, "Frames and units"):
// camera x right, y down, z forward; pixel (0,0) is the centre of the top-left pixel; x_cam = R (X_world - C).
#pragma once

#include <cstdint>

namespace ilp {

/// Pinhole with Brown distortion: with x = X/Z, y = Y/Z, r2 = x^2 + y^2,
///   x_d = x (1 + k1 r2 + k2 r2^2) + 2 p1 x y + p2 (r2 + 2 x^2)
///   y_d = y (1 + k1 r2 + k2 r2^2) + p1 (r2 + 2 y^2) + 2 p2 x y
///   u = fx x_d + cx, v = fy y_d + cy                                   (COLMAP's and OpenCV's OPENCV model,
/// but with pixel centres at integers: COLMAP's cx is this cx + 0.5).
struct CameraModel {
  std::int32_t width = 0;   ///< px
  std::int32_t height = 0;  ///< px
  double fx = 0, fy = 0;    ///< px
  double cx = 0, cy = 0;    ///< px
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;
  /// Rolling shutter: from the first row's exposure to the last row's, s; negative: the last row comes first; 0: all
  /// rows at once. A frame's time and pose are those of its middle row.
  double readout_s = 0;

  [[nodiscard]] bool has_distortion() const { return k1 != 0 || k2 != 0 || p1 != 0 || p2 != 0; }
};

/// Attitude and position of a camera.
struct Pose {
  double q_cam_from_world[4] = {1, 0, 0, 0};  ///< unit quaternion w, x, y, z
  double centre[3] = {0, 0, 0};               ///< camera centre in the world, in units of the strip's scale
};

/// Image similarity b_from_a: x_b = scale * R(rotation_rad) * x_a + shift, about the pixel origin; R(a) = [c -s; s c].
struct Similarity2 {
  double scale = 1;
  double rotation_rad = 0;
  double shift_x_px = 0;
  double shift_y_px = 0;
};

}  // namespace ilp
