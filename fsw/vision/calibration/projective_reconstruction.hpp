// Cameras and points up to a projectivity, from matches alone (paper 3.2; M. Pollefeys et al., "Visual modeling with a
// hand-held camera", IJCV 59(3), 2004): a first pair, then each further view from the points known so far.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/base/result.hpp"
#include "fsw/vision/calibration/calibration_views.hpp"
#include "fsw/vision/twoview/robust/robust_models.hpp"
#include "fsw/vision/twoview/robust/two_view_workspace.hpp"

namespace ilp {

struct ProjectiveWorkspace {
  TwoViewWorkspace two_view;
  PointPairs pairs;
  InlierMask inliers;
  std::array<std::uint16_t, limits::max_calibration_tracks> selected;  ///< tracks
  std::array<double, limits::max_calibration_tracks> values;
};

/// The view that makes the best first pair with view 0: far away, with many common tracks. 0 if no view shares enough.
[[nodiscard]] std::size_t choose_second_view(const CalibrationTracks& tracks, std::size_t views);

/// Cameras of view 0 and `second`, and the points that both see; w = 0 is the plane nearest to them, and w has unit
/// root mean square. False when the common tracks support no fundamental matrix, or one that a plane explains.
/// `invalid_argument` for the parameters of RANSAC (px).
Result<bool> reconstruct_pair(const CentredFrame& frame, std::size_t second, const RansacParams& params,
                              CalibrationTracks& tracks, ProjectiveWorkspace& workspace, ProjectiveCameras& cameras);

/// Estimates the camera of `view` from the known points that it sees: 6-point RANSAC, then linearly from all inliers.
/// Outlier tracks lose their observation there, and tracks that can now be triangulated become known. False when fewer
/// than `min_inliers` agree. `bound` is in centred units.
bool resect_projective(std::size_t view, ViewSet posed, double bound, std::uint32_t min_inliers, std::uint64_t seed,
                       CalibrationTracks& tracks, ProjectiveWorkspace& workspace, ProjectiveCameras& cameras);

/// Drops observations further than `bound` (centred units) from their projection, and points left with fewer than two.
/// Returns the number of known points.
std::uint32_t prune_tracks(const ProjectiveCameras& cameras, double bound, CalibrationTracks& tracks);

/// Root mean square of the residuals in use, per coordinate.
[[nodiscard]] double residual_rms(const ProjectiveCameras& cameras, const CalibrationTracks& tracks);

}  // namespace ilp
