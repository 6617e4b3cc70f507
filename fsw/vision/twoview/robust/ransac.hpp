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
  std::uint32_t trials = 0;  ///< done so far
  bool found = false;        ///< false: no sample gave a model
};

/// LO-RANSAC (O. Chum, J. Matas, J. Kittler, "Locally Optimized RANSAC", 2003): every model better than all before is
/// refined on its inliers, and the number of trials follows the share of inliers. Problem provides
///   Model, sample_size, max_models,
///   std::size_t solve(const std::uint16_t* sample, Model* models);
///   bool score(const Model&, const CostBound&, RansacScore&);   false when scoring was abandoned
///   bool improve(Model&);                                   local optimisation; false when it cannot
///
/// The search runs in slices: call begin_ransac once, then ransac_slice with the same arguments while it returns true.
template <class ModelOfProblem>
struct RansacRun {
  RansacReport report;
  ModelOfProblem best;  ///< if report.found
  ProsacSampler sampler;
  std::uint32_t needed = 0;  ///< trials, estimated from the best model so far
};

template <class Problem>
void begin_ransac(const Problem& /*problem*/, const NormalisedPairs& pairs, const RansacParams& params,
                  RansacRun<typename Problem::Model>& run) {
  run.report = {};
  run.needed = 0;
  if (pairs.size() < Problem::sample_size) return;
  run.sampler = ProsacSampler(pairs, Problem::sample_size, params.max_trials, params.seed);
  run.report.score.cost = 1e300;
  run.needed = params.max_trials;
}

/// Does at most `trials` trials. Returns true if more are needed.
template <class Problem>
bool ransac_slice(Problem& problem, const NormalisedPairs& pairs, const RansacParams& params, std::uint32_t trials,
                  RansacRun<typename Problem::Model>& run) {
  // One lucky sample may fit a wrong model to most of the matches, so a few more are drawn in any case.
  constexpr std::uint32_t min_trials = 16;
  RansacReport& report = run.report;
  typename Problem::Model models[Problem::max_models];
  for (std::uint32_t done = 0; done < trials && report.trials < run.needed; ++done, ++report.trials) {
    std::uint16_t sample[Problem::sample_size];
    run.sampler.next(sample);
    const std::size_t count = problem.solve(sample, models);
    for (std::size_t i = 0; i < count; ++i) {
      RansacScore score;
      if (!problem.score(models[i], {report.score.cost, sample_deviations}, score)) continue;
      report.found = true;
      report.score = score;
      run.best = models[i];
      typename Problem::Model improved = run.best;
      if (problem.improve(improved) && problem.score(improved, {report.score.cost}, score)) {
        report.score = score;
        run.best = improved;
      }
      const double share = static_cast<double>(report.score.inliers) / static_cast<double>(pairs.size());
      run.needed = required_trials(share, Problem::sample_size, params.confidence, params.max_trials);
      if (run.needed < min_trials && params.max_trials >= min_trials) run.needed = min_trials;
    }
  }
  return report.trials < run.needed;
}

/// The complete search in one call. `best` is valid if the report's `found` is true.
template <class Problem>
RansacReport ransac(Problem& problem, const NormalisedPairs& pairs, const RansacParams& params,
                    typename Problem::Model& best) {
  RansacRun<typename Problem::Model> run;
  begin_ransac(problem, pairs, params, run);
  while (ransac_slice(problem, pairs, params, params.max_trials, run)) {  // bound: `max_trials`
  }
  if (run.report.found) best = run.best;
  return run.report;
}

}  // namespace ilp
