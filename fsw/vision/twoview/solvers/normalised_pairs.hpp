// Matches in normalised coordinates, in the layouts that solvers and scoring need.
#pragma once

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/types.hpp"
#include "fsw/vision/twoview/solvers/point_pairs.hpp"

namespace ilp {

/// Pixels per unit of the normalised coordinates, for each image and axis.
struct PixelScale {
  double ax = 1, ay = 1, bx = 1, by = 1;
};

struct NormalisedPair {
  double xa = 0, ya = 0, xb = 0, yb = 0;

  [[nodiscard]] Vec3 ray_a() const { return {xa, ya, 1}; }
  [[nodiscard]] Vec3 ray_b() const { return {xb, yb, 1}; }
};

/// The finite matches in a random but reproducible order, so that the first n matches are a random sample
/// (bail_out.hpp). `source` has the index of each match in the caller's list.
struct NormalisedPairs {
  FixedVector<NormalisedPair, limits::max_matches> exact;
  FixedVector<std::uint16_t, limits::max_matches> source;
  FixedVector<std::uint16_t, limits::max_matches> by_quality;  ///< indices into `exact`, best first; ties by index
  bool qualities_differ = false;
  PixelScale scale;
  // Copies for scoring: single precision is exact to 1e-4 px, and a vector register holds twice as many.
  float xa[limits::max_matches], ya[limits::max_matches];
  float xb[limits::max_matches], yb[limits::max_matches];

  [[nodiscard]] std::size_t size() const { return exact.size(); }
};

/// A list of indices into NormalisedPairs::exact.
struct PairSelection {
  const std::uint16_t* indices = nullptr;
  std::size_t count = 0;
};

using PairIndices = FixedVector<std::uint16_t, limits::max_matches>;

/// x_pixel = scale * x_normalised + centre, for each axis of an image.
struct ImageNormalisation {
  double scale_x = 1, scale_y = 1;
  double centre_x = 0, centre_y = 0;

  [[nodiscard]] Mat3 pixel_from_normalised() const;
  [[nodiscard]] Mat3 normalised_from_pixel() const;
};

/// The normalisation that divides by the intrinsics.
[[nodiscard]] ImageNormalisation intrinsics_of(const CameraModel& camera);
/// The normalisation that moves the centroid of the finite matches to the origin and makes their mean distance sqrt(2)
/// (R. Hartley, "In Defence of the 8-Point Algorithm", 1995). Its scale is 1 if all points coincide.
void isotropic_normalisation(const PointPairs& pairs, ImageNormalisation& a, ImageNormalisation& b);

/// Writes the finite matches of `pairs`, normalised by `a` and `b`, to `out` in an order that `seed` determines.
void normalise_pairs(const PointPairs& pairs, const ImageNormalisation& a, const ImageNormalisation& b,
                     std::uint64_t seed, NormalisedPairs& out);

/// Copies the matches `selected` (indices into `pairs`) in their order. All have the same quality in `subset`, because
/// they are inliers: samples of them are uniform.
void select_subset(const NormalisedPairs& pairs, const PairIndices& selected, NormalisedPairs& subset);

}  // namespace ilp
