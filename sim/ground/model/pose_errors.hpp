// Covariances of the poses of adjusted cameras.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "sim/ground/model/adjustment.hpp"
#include "sim/ground/model/camera_system.hpp"

namespace ilp::model {

/// Covariance of rotation vector (in the camera's axes, rad) and centre, lower triangle row by row.
using PoseCovariance = std::array<double, 21>;

[[nodiscard]] PoseCovariance lower_triangle(const Mat6& covariance);

/// Variance of one coordinate of a sighting: sum of squared residuals divided by the degrees of freedom, px^2. None if
/// there are not more residuals than unknowns.
[[nodiscard]] std::optional<double> variance_of_sightings(const AdjustmentProblem& problem);

/// Covariances of all cameras to first order: the inverse of the reduced normal equations (Triggs et al. 2000, 9.4)
/// times the variance of sightings. Without priors the unknowns of the gauge have no error. Suits any number of
/// cameras, because only the diagonal blocks of the inverse, and the blocks that these need, are computed. Empty if the
/// observations do not determine some camera.
[[nodiscard]] std::vector<PoseCovariance> pose_covariances(const AdjustmentProblem& problem);

}  // namespace ilp::model
