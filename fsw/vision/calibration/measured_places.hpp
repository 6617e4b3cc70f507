// Normal equations that compare a window's camera centres, and their distances from the ground, with the places and
// heights that the vehicle measured. A similarity relates the window's world to the vehicle's; it is eliminated (B.
// Triggs et al., "Bundle Adjustment - A Modern Synthesis", 2000, section 6).
#pragma once

#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {

/// Measured position of a view's camera, m: east, north, up in the vehicle's level frame.
struct MeasuredPlace {
  std::uint16_t view = 0;
  double place_m[3] = {};
  double sigma_m[3] = {1, 1, 1};  ///< along each axis
};
using MeasuredPlaces = FixedVector<MeasuredPlace, limits::max_calibration_views>;

/// Measured height of a view's camera above the ground, m, and the vertical (upwards) as a unit vector in the view's
/// axes.
struct MeasuredHeight {
  std::uint16_t view = 0;
  double height_m = 0;
  double sigma_m = 1;
  double up[3] = {0, 0, -1};
};
using MeasuredHeights = FixedVector<MeasuredHeight, limits::max_calibration_views>;

/// The distance of a view's camera from the ground in the window, in units of its world frame, and the measured height.
struct HeightInWindow {
  double distance = 0;
  double sigma = 0;  ///< standard deviation of `distance`
  double height_m = 0, sigma_m = 1;
};
using HeightsInWindow = FixedVector<HeightInWindow, limits::max_calibration_views>;

/// Normal equations in units of the window's world frame: three rows for the centre of each place, in the order of the
/// places, and from row `centre_rows` on one row for the distance of each height, in the order of the heights. The
/// similarity is eliminated: a common rotation, shift or scale does not change the cost.
struct PlaceEquations {
  static constexpr std::size_t centre_rows = 3 * limits::max_calibration_views;
  static constexpr std::size_t size = centre_rows + limits::max_calibration_views;
  double information[size][size] = {};
  double gradient[size] = {};
  double squared = 0;  ///< sum of the weighted squared residuals after the similarity, in variances
};

/// Computes the equations. Returns false, with nothing to add, if there are fewer than three places, if the centres do
/// not spread, or if places are farther from the centres than a lens can explain. If a height differs from its distance
/// by more than a lens can explain, all heights are ignored. Residuals have Cauchy weights with the scale
/// `loss_sigmas`.
[[nodiscard]] bool place_equations(std::span<const RigidTransform> cam_from_world, const MeasuredPlaces& places,
                                   const HeightsInWindow& heights, double loss_sigmas, PlaceEquations& out);

}  // namespace ilp
