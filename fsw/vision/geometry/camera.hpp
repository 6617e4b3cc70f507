// Camera model: projection, distortion and its inverse for the lenses of fsw/base/geometry.hpp.
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/verdicts.hpp"
#include "fsw/vision/geometry/types.hpp"

namespace ilp {

inline constexpr double max_focal_sides =
    1000;  ///< largest ratio of focal length to the longer side of the image: a field of view of 0.06 deg
inline constexpr double max_pixel_aspect = 10;  ///< largest ratio of fx to fy, or of fy to fx
inline constexpr double max_readout_s = 0.5;    ///< from the exposure of the first row to that of the last

/// Largest angle between a fisheye's view and its optical axis. At this angle a pixel along the radius is 15 ideal
/// pixels (1 / cos^2): beyond it, the ideal position of a corner is useless.
inline constexpr double max_view_angle_deg = 75;

/// Checks a camera: finite values; an image size within the limits; focal lengths above 1 px and within max_focal_sides
/// and max_pixel_aspect; a principal point at most one image size outside the image; a distortion that is invertible
/// over the whole image; for a fisheye, a view of at most max_view_angle_deg from its axis; a readout of at most
/// max_readout_s. Returns `image_too_large`, or `invalid_argument` with the name of the field.
Status validate(const CameraModel& camera);
/// As validate(), without the largest size: for a camera whose images are reduced before the flight.
Status validate_of_any_size(const CameraModel& camera);

/// Says what is unusual about a camera that passes validate(): its field of view, or its principal point.
[[nodiscard]] CameraSuspicion suspicion_about(const CameraModel& camera);

/// A nominal camera with this horizontal field of view: square pixels, principal point in the middle, no distortion.
[[nodiscard]] CameraModel camera_of_field(std::int32_t width, std::int32_t height, double field_of_view_rad);
/// Relative change of the focal length per radian of change of the horizontal field of view, 1/rad; negative.
[[nodiscard]] double focal_per_field(const CameraModel& camera);

/// Maps normalised image coordinates (X/Z, Y/Z) to distorted ones.
[[nodiscard]] Vec2 distort(const CameraModel& camera, const Vec2& normalised);
/// [a b; c d], the derivatives of distort().
struct DistortionJacobian {
  double a, b, c, d;
};
// distort() and its derivatives for lenses with is_plain(), inline for loops over many points.
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
/// distort() for a loop that is compiled once for plain lenses and once for all others.
template <bool plain>
[[nodiscard]] Distorted distort_point(const CameraModel& camera, double x, double y) {
  if constexpr (plain) return plain_distort(camera, x, y);
  const Vec2 d = distort(camera, Vec2(x, y));
  return {d.x(), d.y()};
}
/// Derivatives of the pixel with respect to the intrinsics of fsw/base/verdicts.hpp. The ratio of fy to fx is constant.
/// The derivatives with respect to p1 and p2 are 0 for a fisheye.
[[nodiscard]] Eigen::Matrix<double, 2, static_cast<int>(intrinsic_count)> pixel_by_intrinsics(const CameraModel& camera,
                                                                                              const Vec2& normalised);
/// The camera with `factor` times the focal length. Its distortion displaces the same pixels by the same amount; a
/// fisheye keeps its coefficients instead.
[[nodiscard]] CameraModel with_focal_length(const CameraModel& camera, double factor);
/// The inverse of distort() by Newton's method: at most 20 steps, to 1e-13 in normalised coordinates.
[[nodiscard]] Vec2 undistort(const CameraModel& camera, const Vec2& distorted);
/// undistort() of `count` points in place, with bitwise the same results.
void undistort(const CameraModel& camera, std::int32_t count, double* x, double* y);

/// Normalised coordinates of a pixel of the real (distorted) image.
[[nodiscard]] Vec2 normalised_from_pixel(const CameraModel& camera, const Vec2& pixel);
/// Pixel of the real (distorted) image at normalised coordinates.
[[nodiscard]] Vec2 pixel_from_normalised(const CameraModel& camera, const Vec2& normalised);

/// The *ideal pixel* of a pixel of the real image: where an ideal pinhole with the same fx, fy, cx, cy shows the same
/// point. Kernels that estimate geometry work on ideal pixels, so that distortion is removed only once per feature.
[[nodiscard]] Vec2 ideal_from_pixel(const CameraModel& camera, const Vec2& pixel);
[[nodiscard]] Vec2 pixel_from_ideal(const CameraModel& camera, const Vec2& ideal);
[[nodiscard]] Vec2 normalised_from_ideal(const CameraModel& camera, const Vec2& ideal);
[[nodiscard]] Vec2 ideal_from_normalised(const CameraModel& camera, const Vec2& normalised);

}  // namespace ilp
