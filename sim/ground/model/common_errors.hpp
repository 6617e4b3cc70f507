// Errors that neighbouring sightings of an image have in common.
#pragma once

#include "sim/ground/model/adjustment.hpp"

namespace ilp::model {

/// By how much the variance of sums of residuals over a part of an image exceeds what independent errors would give
/// (the design effect of cluster samples; L. Kish, "Survey Sampling", 1965, 5.4). Images are bent a little, each in its
/// own way, and many points in one place tell no more than few. Parts are squares of a fourth, an eighth and a
/// sixteenth of the image's width; the largest ratio counts. 1 where no ratio is larger than independent errors
/// explain, by three of its standard deviations. Residuals count less by Cauchy's loss of scale `robust_px`.
[[nodiscard]] double common_error_factor(const AdjustmentProblem& problem, double robust_px);

}  // namespace ilp::model
