// Errors of adjusted cameras.
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

/// Squared error of one coordinate of a sighting, by the residuals for each degree of freedom, px^2. None where there
/// are not more residuals than unknowns.
[[nodiscard]] std::optional<double> variance_of_sightings(const AdjustmentProblem& problem);

/// To first order: the inverse of the normal equations without the points (Triggs et al. 2000, 9.4), times the variance
/// of sightings. Without priors the gauge has no error. Of any number of cameras: only the blocks of
/// the inverse that the factors need are computed. Empty where the observations leave some camera free.
[[nodiscard]] std::vector<PoseCovariance> pose_covariances(const AdjustmentProblem& problem);

}  // namespace ilp::model
