// The same bundle adjustment problems for Ceres Solver, as a peer in tests and benchmarks. Built only where Ceres is
// installed.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"

namespace ilp::test {

struct CeresResult {
  double initial_cost = 0, final_cost = 0;  ///< as in BundleResult
  int iterations = 0;
  double solve_s = 0;  ///< processor time of ceres::Solve alone; setting up the problem is not counted
  std::array<std::array<double, 3>, limits::max_bundle_cameras> centres{};
};

/// Dense Schur complement with the points eliminated first, one thread, Levenberg-Marquardt, analytic derivatives whose
/// parts that belong to a camera are computed once per camera. Loss, iterations and tolerance are those of `params`;
/// a held scale is not supported. The problem must have no observation that the adjuster would drop.
[[nodiscard]] CeresResult adjust_with_ceres(const BundleProblem& problem, const BundleParams& params);

}  // namespace ilp::test
