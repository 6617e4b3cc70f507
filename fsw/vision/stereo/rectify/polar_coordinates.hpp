// Polar coordinates of a viewing direction about the baseline: the azimuth, which is common to both cameras, and the
// advance, a function of the angle from the baseline.
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/types.hpp"
#include "fsw/vision/stereo/rectify/rectification.hpp"

namespace ilp {

/// Inverse hyperbolic sine (absolute error 1e-15 for |x| < 1e6), hyperbolic sine and hyperbolic cosine. They give the
/// same value on every machine.
[[nodiscard]] double det_asinh(double x);
[[nodiscard]] double det_sinh(double x);
[[nodiscard]] double det_cosh(double x);

/// Returns the cotangent of the angle between the direction q (any length, axes of RectifiedPair) and the baseline.
[[nodiscard]] double cotangent_of(const Vec3& q);
/// Returns the advance of a direction: asinh of its cotangent, which is -log tan(angle / 2), the latitude of Mercator's
/// projection about the baseline. With the azimuth it is a conformal map.
[[nodiscard]] double advance_of(const Vec3& q);
/// Returns the azimuth of a direction: its angle about the baseline from the z axis towards the y axis, rad in (-pi,
/// pi].
[[nodiscard]] double azimuth_of(const Vec3& q);

[[nodiscard]] bool contains(const PolarSector& sector, double cotangent, double azimuth);

/// Returns the row of an azimuth. Of the rows that differ by full turns, it is the one nearest to the middle of the
/// image.
[[nodiscard]] double polar_row(const RectifiedPair& pair, double azimuth);

}  // namespace ilp
