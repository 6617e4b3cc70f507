// The sampling loop that all robust estimators share.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fsw/vision/twoview/robust/bail_out.hpp"
#include "fsw/vision/twoview/robust/msac.hpp"
#include "fsw/vision/twoview/robust/prosac.hpp"
#include "fsw/vision/twoview/robust/ransac_params.hpp"

namespace ilp {

struct RansacReport {
  RansacScore score;
  std::uint32_t trials = 0;
  bool found = false;
};

/// LO-RANSAC (O. Chum, J. Matas, J. Kittler, "Locally Optimized RANSAC", 2003): every model better than all before is
/// refined on its inliers, and the number of trials follows the share of inliers. Problem provides
///   Model, sample_size, max_models,
///   std::size_t solve(const std::uint16_t* sample, Model* models);
///   bool score(const Model&, const CostBound&, RansacScore&);   false when scoring was given up
///   bool improve(Model&);                                   local optimisation; false when it cannot
template <class Problem>
RansacReport ransac(Problem& problem, const NormalisedPairs& pairs, const RansacParams& params,
                    typename Problem::Model& best) {
  // One lucky sample may fit a wrong model to most of the matches, so a few more are drawn in any case.
  constexpr std::uint32_t min_trials = 16;
  RansacReport report;
  if (pairs.size() < Problem::sample_size) return report;
  ProsacSampler sampler(pairs, Problem::sample_size, params.max_trials, params.seed);
  report.score.cost = 1e300;
  std::uint32_t needed = params.max_trials;
  typename Problem::Model models[Problem::max_models];
  for (; report.trials < needed; ++report.trials) {
    std::uint16_t sample[Problem::sample_size];
    sampler.next(sample);
    const std::size_t count = problem.solve(sample, models);
    for (std::size_t i = 0; i < count; ++i) {
      RansacScore score;
      if (!problem.score(models[i], {report.score.cost, sample_deviations}, score)) continue;
      report.found = true;
      report.score = score;
      best = models[i];
      typename Problem::Model improved = best;
      if (problem.improve(improved) && problem.score(improved, {report.score.cost}, score)) {
        report.score = score;
        best = improved;
      }
      const double share = static_cast<double>(report.score.inliers) / static_cast<double>(pairs.size());
      needed = required_trials(share, Problem::sample_size, params.confidence, params.max_trials);
      if (needed < min_trials && params.max_trials >= min_trials) needed = min_trials;
    }
  }
  return report;
}

}  // namespace ilp
