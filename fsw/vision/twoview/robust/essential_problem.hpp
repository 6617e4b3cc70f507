// Relative pose as a problem for ransac(), with samples of five matches and the test of cheirality (points in front of
// both cameras).
#pragma once

#include "fsw/vision/twoview/refine/epipolar_refinement.hpp"
#include "fsw/vision/twoview/robust/ransac.hpp"
#include "fsw/vision/twoview/solvers/five_point.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

/// Selects the matches within `threshold_px` of the pose's epipolar geometry whose rays meet in front of both cameras
/// or whose parallax is within `threshold_px`. Returns the sum of their squared Sampson distances, px^2.
double select_inliers(const NormalisedPairs& pairs, const RigidTransform& b_from_a, double threshold_px,
                      PairIndices& selected);

struct EssentialProblem {
  using Model = RigidTransform;
  static constexpr std::size_t sample_size = 5;
  static constexpr std::size_t max_models = 4 * max_five_point_solutions;

  const NormalisedPairs& pairs;
  double threshold_px;
  PairIndices& scratch;

  /// Writes the poses with all five points in front of both cameras. Returns their number.
  std::size_t solve(const std::uint16_t* sample, Model* models);
  bool score(const Model& model, const CostBound& bound, RansacScore& score) const;
  bool improve(Model& model);
};

}  // namespace ilp
