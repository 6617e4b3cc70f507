// Refines the points of a model for fixed cameras.
#pragma once

#include "sim/ground/model/model.hpp"

namespace ilp::model {

/// Minimises the reprojection errors of each placed point by two to six Gauss-Newton steps, with Cauchy's loss of scale
/// `robust_px`. Points placed by depth (ModelPoint::by_depth) do not change.
void refine_points(const Scene& scene, double robust_px, Model& model);

}  // namespace ilp::model
