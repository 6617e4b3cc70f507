// Non-linear least squares on the transfer error of a homography.
#pragma once

#include "fsw/vision/twoview/refine/robust_loss.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

/// Refines `homography` (normalised coordinates). Returns false if the cost did not fall.
bool refine_homography(const NormalisedPairs& pairs, const PairSelection& selection, const RefinementParams& params,
                       Mat3& homography);

}  // namespace ilp
