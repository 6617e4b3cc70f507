// Upgrade from projective to metric: the dual absolute quadric (W. Triggs, CVPR 1997) with general constraints on
// cameras (M. Pollefeys, R. Koch, L. Van Gool, "Self-Calibration and Metric Reconstruction in spite of Varying and
// Unknown Intrinsic Camera Parameters", IJCV 32(1), 1999; weights as in IJCV 59(3), 2004).
//
// With P_0 = [I | 0] and K = diag(f, f, 1) the quadric is Omega = [D, v; v^T, s], D = diag(f^2, f^2, 1), v = -D pi for
// the plane at infinity (pi, 1), s = v^T D^-1 v (rank 3). For a given f the conditions on P_i Omega P_i^T ~ D are
// linear in v and s. The search therefore covers the range of f and solves for the plane at each value.
#pragma once

#include "fsw/vision/calibration/calibration_views.hpp"

namespace ilp {

struct QuadricParams {
  double min_focal = 0.35, max_focal = 3.5;  ///< centred units
  double sigma_aspect = 0.05;                ///< of the squared aspect ratio about 1
  double sigma_focal = 0.1;                  ///< of the views' squared focal lengths about each other
  double sigma_skew = 0.02;                  ///< relative to the squared focal length
  double sigma_centre = 0.05;                ///< of the principal point, centred units, relative to the focal length
};

struct AbsoluteQuadric {
  double focal = 0;             ///< centred units
  double plane[3] = {0, 0, 0};  ///< at infinity: (plane, 1)
  double cost = 0;              ///< mean squared condition, in sigmas
};

/// False when no focal length in range gives a positive quadric.
bool find_absolute_quadric(const ProjectiveCameras& cameras, ViewSet views, const QuadricParams& params,
                           AbsoluteQuadric& quadric);

/// Transforms cameras and points into the frame of view 0, scaled to a median depth of one. Points that are then behind
/// a camera that sees them become unknown. Returns the share of the points that remain.
double upgrade_to_metric(const ProjectiveCameras& cameras, ViewSet views, const AbsoluteQuadric& quadric,
                         CalibrationTracks& tracks, double* scratch, MetricViews& metric);

}  // namespace ilp
