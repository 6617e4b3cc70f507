// Projection, distortion and its inverse for the pinhole camera with Brown distortion (fsw/base/geometry.hpp).
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

/// Requires finite values, focal lengths above 1 px that differ by less than max_pixel_aspect and are at most
/// max_focal_sides, a size inside the limits, a principal point within one image of the centre, a distortion that
/// is invertible over the whole image, and at most max_readout_s between the rows. `invalid_argument` (size, focal
/// length, centre, distortion, readout, not finite) otherwise.
Status validate(const CameraModel& camera);

/// For a camera that passes validate().
[[nodiscard]] CameraDoubt doubt_about(const CameraModel& camera);

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
// Here, because loops over many points have it in line.
[[nodiscard]] inline DistortionJacobian distortion_jacobian(const CameraModel& camera, double x, double y) {
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (camera.k1 + r2 * camera.k2);
  const double radial_by_r2 = camera.k1 + 2 * camera.k2 * r2;
  const double cross = 2 * x * y * radial_by_r2 + 2 * camera.p1 * x + 2 * camera.p2 * y;
  return {radial + 2 * x * x * radial_by_r2 + 2 * camera.p1 * y + 6 * camera.p2 * x, cross, cross,
          radial + 2 * y * y * radial_by_r2 + 6 * camera.p1 * y + 2 * camera.p2 * x};
}
/// The inverse, by Newton's method on the two distortion polynomials; at most 20 steps, to 1e-13.
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
