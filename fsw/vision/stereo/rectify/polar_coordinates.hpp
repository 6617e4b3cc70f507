// Directions around a baseline: the azimuth, common to both cameras, and the advance, how far along the baseline.
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/types.hpp"
#include "fsw/vision/stereo/rectify/rectification.hpp"

namespace ilp {

/// Inverse hyperbolic sine and its inverse, to 1e-15 absolute for |x| < 1e6.
[[nodiscard]] double det_asinh(double x);
[[nodiscard]] double det_sinh(double x);
[[nodiscard]] double det_cosh(double x);

/// Cotangent of the angle between the direction q (any length, axes of RectifiedPair) and the baseline.
[[nodiscard]] double cotangent_of(const Vec3& q);
/// asinh of that: -log tan(angle / 2), Mercator's latitude about the baseline. With the azimuth a conformal map.
[[nodiscard]] double advance_of(const Vec3& q);
/// About the baseline from z towards y, rad in (-pi, pi].
[[nodiscard]] double azimuth_of(const Vec3& q);

[[nodiscard]] bool contains(const PolarSector& sector, double cotangent, double azimuth);

/// Row of an azimuth, of all its turns the one nearest to the middle of the image.
[[nodiscard]] double polar_row(const RectifiedPair& pair, double azimuth);

}  // namespace ilp
