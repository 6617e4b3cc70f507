// Normal equations of the camera centres of a window, and of their distances from the ground, against the places and
// heights that the vehicle measured. A similarity relates the window's world to the vehicle's; it is eliminated
// (B. Triggs et al., "Bundle Adjustment - A Modern Synthesis", 2000, section 6).
#pragma once

#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {

/// Where a view's camera was, m, in a level world of the vehicle: east, north, up.
struct MeasuredPlace {
  std::uint16_t view = 0;
  double place_m[3] = {};
  double sigma_m[3] = {1, 1, 1};  ///< along each axis
};
using MeasuredPlaces = FixedVector<MeasuredPlace, limits::max_calibration_views>;

/// How far below a view's camera the ground was, m, and what is up there: a unit vector in the view's axes.
struct MeasuredHeight {
  std::uint16_t view = 0;
  double height_m = 0;
  double sigma_m = 1;
  double up[3] = {0, 0, -1};
};
using MeasuredHeights = FixedVector<MeasuredHeight, limits::max_calibration_views>;

/// The same distance as the window has it, in units of its world.
struct HeightInWindow {
  double distance = 0;
  double sigma = 0;  ///< of the ground near the place below the camera
  double height_m = 0, sigma_m = 1;
};
using HeightsInWindow = FixedVector<HeightInWindow, limits::max_calibration_views>;

/// Normal equations of the centres of the measured views, three rows for each in the order of the places, and of the
/// distances, a row for each in the order of the heights; in units of the window's world. The similarity is eliminated:
/// a common turn, shift or scale costs nothing.
struct PlaceEquations {
  static constexpr std::size_t centre_rows = 3 * limits::max_calibration_views;
  static constexpr std::size_t size = centre_rows + limits::max_calibration_views;
  double information[size][size] = {};
  double gradient[size] = {};
  double squared = 0;  ///< weighted squares of what the similarity leaves, in variances
};

/// False, with nothing to add: fewer than three places, centres that do not spread, or places that are further from the
/// centres than a lens can explain. Heights that are further than that from the distances add nothing. Cauchy weights
/// at `loss_sigmas`.
[[nodiscard]] bool place_equations(std::span<const RigidTransform> cam_from_world, const MeasuredPlaces& places,
                                   const HeightsInWindow& heights, double loss_sigmas, PlaceEquations& out);

}  // namespace ilp
