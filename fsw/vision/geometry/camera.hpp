// Projection, distortion and its inverse for the lenses of fsw/base/geometry.hpp.
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/verdicts.hpp"
#include "fsw/vision/geometry/types.hpp"

namespace ilp {

inline constexpr double max_focal_sides =
    1000;  ///< focal length / longer side of the image: a field of view of 0.06 deg
inline constexpr double max_pixel_aspect = 10;
inline constexpr double max_readout_s = 0.5;

/// Half the field of view that a fisheye may have. At this angle a pixel along the radius is 15 ideal pixels
/// (1 / cos^2): beyond it, an ideal image has no use for a corner's position.
inline constexpr double max_view_angle_deg = 75;

/// Requires finite values, focal lengths above 1 px that differ by less than max_pixel_aspect and are at most
/// max_focal_sides, a size inside the limits, a principal point within one image of the centre, and a distortion that
/// is invertible over the whole image, and of a fisheye a view of at most max_view_angle_deg from its axis. At most
/// max_readout_s between the first row and the last.
/// `invalid_argument` (size, focal length, centre, distortion, view angle, readout, not finite) otherwise.
Status validate(const CameraModel& camera);
/// The same for a camera whose images are reduced before they fly: only the largest size is not checked.
Status validate_of_any_size(const CameraModel& camera);

/// For a camera that passes validate().
[[nodiscard]] CameraSuspicion suspicion_about(const CameraModel& camera);

/// A nominal camera: this horizontal field of view, square pixels, the principal point in the middle, no distortion.
[[nodiscard]] CameraModel camera_of_field(std::int32_t width, std::int32_t height, double field_of_view_rad);
/// Change of the focal length / focal length, per change of the horizontal field of view in rad.
[[nodiscard]] double focal_per_field(const CameraModel& camera);

/// Maps normalised image coordinates (X/Z, Y/Z) to distorted ones.
[[nodiscard]] Vec2 distort(const CameraModel& camera, const Vec2& normalised);
/// [a b; c d], the derivatives of distort().
struct DistortionJacobian {
  double a, b, c, d;
};
// distort() and its derivatives for lenses with is_plain(); here, because loops over many points have them in line.
struct Distorted {
  double x, y;
};
[[nodiscard]] inline Distorted plain_distort(const CameraModel& camera, double x, double y) {
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (camera.k1 + r2 * camera.k2);
  const double xy2 = 2 * x * y;
  return {x * radial + camera.p1 * xy2 + camera.p2 * (r2 + 2 * x * x),
          y * radial + camera.p1 * (r2 + 2 * y * y) + camera.p2 * xy2};
}
[[nodiscard]] inline DistortionJacobian plain_jacobian(const CameraModel& camera, double x, double y) {
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (camera.k1 + r2 * camera.k2);
  const double radial_by_r2 = camera.k1 + 2 * camera.k2 * r2;
  const double cross = 2 * x * y * radial_by_r2 + 2 * camera.p1 * x + 2 * camera.p2 * y;
  return {radial + 2 * x * x * radial_by_r2 + 2 * camera.p1 * y + 6 * camera.p2 * x, cross, cross,
          radial + 2 * y * y * radial_by_r2 + 6 * camera.p1 * y + 2 * camera.p2 * x};
}
[[nodiscard]] DistortionJacobian distortion_jacobian(const CameraModel& camera, double x, double y);
/// For a loop that is compiled for either kind of lens.
template <bool plain>
[[nodiscard]] Distorted distort_point(const CameraModel& camera, double x, double y) {
  if constexpr (plain) return plain_distort(camera, x, y);
  const Vec2 d = distort(camera, Vec2(x, y));
  return {d.x(), d.y()};
}
/// Derivatives of the pixel by the intrinsics of fsw/base/verdicts.hpp; fy keeps its ratio to fx. Those by p1 and p2
/// are 0 for a fisheye.
[[nodiscard]] Eigen::Matrix<double, 2, static_cast<int>(intrinsic_count)> pixel_by_intrinsics(const CameraModel& camera,
                                                                                              const Vec2& normalised);
/// The same lens at `factor` times the focal length: it bends the same pixels. A fisheye keeps its angles instead.
[[nodiscard]] CameraModel with_focal_length(const CameraModel& camera, double factor);
/// The inverse, by Newton's method; at most 20 steps, to 1e-13.
[[nodiscard]] Vec2 undistort(const CameraModel& camera, const Vec2& distorted);
/// The same for `count` points at once, in place, with the same bits.
void undistort(const CameraModel& camera, std::int32_t count, double* x, double* y);

/// Pixel of the real (distorted) image to normalised coordinates.
[[nodiscard]] Vec2 normalised_from_pixel(const CameraModel& camera, const Vec2& pixel);
/// Normalised coordinates to a pixel of the real (distorted) image.
[[nodiscard]] Vec2 pixel_from_normalised(const CameraModel& camera, const Vec2& normalised);

/// Pixel of the real image to the pixel of an ideal pinhole with the same fx, fy, cx, cy. Kernels that estimate
/// geometry work on these *ideal pixels*, so that distortion is removed only once per feature.
[[nodiscard]] Vec2 ideal_from_pixel(const CameraModel& camera, const Vec2& pixel);
[[nodiscard]] Vec2 pixel_from_ideal(const CameraModel& camera, const Vec2& ideal);
[[nodiscard]] Vec2 normalised_from_ideal(const CameraModel& camera, const Vec2& ideal);
[[nodiscard]] Vec2 ideal_from_normalised(const CameraModel& camera, const Vec2& normalised);

}  // namespace ilp
