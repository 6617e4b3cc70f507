// The focal length of a camera over nearly level ground, from the homographies of consecutive keyframes and the
// vehicle's measurements at them.
//
// Images of a plane alone determine the focal length hardly: a longer one looks like a greater height. Measured
// attitudes tell the two apart where the camera swings, because tilts move the ground by f pixels per radian. A
// measured height and a measured baseline do without a swing, because the ground moves by f B / h pixels.
//
// The unknowns are attitude and place of every keyframe, the principal point, the focal length, and for each pair the
// height and the slope of its ground, each with the error that is known of it. An information filter goes along the
// keyframes (P. S. Maybeck, "Stochastic Models, Estimation and Control", 1979), and several times, each time linearised
// about the focal length found before.
#pragma once

#include <cstdint>
#include <span>
#include <type_traits>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/vision/calibration/calibration_views.hpp"
#include "fsw/vision/twoview/solvers/point_pairs.hpp"

namespace ilp {

/// Plane by which one keyframe's image becomes the next one's, in centred coordinates (calibration_views.hpp).
struct PlanePair {
  double homography[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< this keyframe from the one before, row-major
  double rms = 0;                                      ///< of its matches, relief included
  double motion = 0;                                   ///< median displacement
  std::uint32_t matches = 0;                           ///< 0: the keyframe is related to none
};

/// A keyframe, and what the vehicle measured at it. A sigma of 0: not measured.
struct PlaneView {
  PlanePair pair;
  double q_cam_from_level[4] = {1, 0, 0, 0};
  double tilt_sigma_rad = 0, heading_sigma_rad = 0;
  double height_m = 0, height_sigma_m = 0;
  double place_m[3] = {0, 0, 0};  ///< east, north, up from any place
  double horizontal_sigma_m = 0;
};
using PlaneViews = FixedVector<PlaneView, limits::max_plane_views>;
static_assert(std::is_trivially_copyable_v<PlaneViews>);

struct PlaneFocalParams {
  double min_focal = 0.35, max_focal = 3.5;  ///< centred units
  double sigma_centre = 0.02;                ///< of the principal point, centred units
  double least_noise = 0.0001;               ///< error of a homography that no residual shows, centred units
};

struct PlaneFocal {
  bool found = false;
  double focal = 0, sigma = 0;  ///< centred units; the sigma includes the disagreement of the halves
  double consistency = 0;       ///< difference of the halves of the keyframes over its sigma
  std::uint32_t pairs = 0;
};

/// The plane nearest to the matches, in least squares; those far from it are left out. False without enough matches.
bool fit_plane_pair(const PointPairs& pairs, const InlierMask& inliers, const CentredFrame& frame, PlanePair& out);

/// Uses keyframes with attitude, to 2 degrees, and heading; others end the chain of pairs. Heights help, and places do
/// where there are heights. `start` is the nominal focal length.
[[nodiscard]] PlaneFocal find_plane_focal(std::span<const PlaneView> views, double start,
                                          const PlaneFocalParams& params);

}  // namespace ilp
