#include "fsw/vision/twoview/robust/homography_problem.hpp"

#include "fsw/vision/twoview/refine/homography_refinement.hpp"
#include "fsw/vision/twoview/refine/match_error.hpp"
#include "fsw/vision/twoview/robust/gric.hpp"
#include "fsw/vision/twoview/robust/local_optimisation.hpp"
#include "fsw/vision/twoview/robust/model_score.hpp"
#include "fsw/vision/twoview/solvers/homography.hpp"

namespace ilp {
namespace {

// They take about 10 ms on a processor of 1000 MIPS.
constexpr std::uint32_t trials_of_a_slice = 64;

}  // namespace

double select_homography_inliers(const NormalisedPairs& pairs, const Mat3& homography, double threshold_px,
                                 PairIndices& selected) {
  return select_matches(pairs, threshold_px, selected,
                        [&](const NormalisedPair& pair) { return transfer_squared(homography, pair, pairs.scale); });
}

std::size_t HomographyProblem::solve(const std::uint16_t* sample, Model* models) const {
  return homography_from_four(pairs, sample, models[0]) ? 1 : 0;
}

bool HomographyProblem::score(const Model& model, const CostBound& bound, RansacScore& score) const {
  return score_homography(pairs, model, threshold_px, bound, score);
}

bool HomographyProblem::improve(Model& model) {
  select_homography_inliers(pairs, model, local_widening * threshold_px, scratch);
  return refine_homography(pairs, {scratch.data(), scratch.size()}, local_refinement(threshold_px), model);
}

void begin_homography(const NormalisedPairs& pairs, const RansacParams& params, PairIndices& scratch,
                      RansacRun<Mat3>& run) {
  begin_ransac(HomographyProblem{pairs, params.threshold_px, scratch}, pairs, params, run);
}

bool homography_slice(const NormalisedPairs& pairs, const RansacParams& params, PairIndices& scratch,
                      RansacRun<Mat3>& run) {
  HomographyProblem problem{pairs, params.threshold_px, scratch};
  return ransac_slice(problem, pairs, params, trials_of_a_slice, run);
}

bool end_homography(const NormalisedPairs& pairs, const RansacParams& params, PairIndices& scratch,
                    const RansacRun<Mat3>& run, Mat3& homography) {
  if (!run.report.found) return false;
  homography = run.best;
  constexpr double widening = 2.5;
  select_homography_inliers(pairs, homography, widening * params.threshold_px, scratch);
  const RefinementParams refinement{RobustLoss::tukey, widening * params.threshold_px, 20, 1e-8};
  refine_homography(pairs, {scratch.data(), scratch.size()}, refinement, homography);
  return true;
}

bool find_homography(const NormalisedPairs& pairs, const RansacParams& params, PairIndices& scratch, Mat3& homography) {
  RansacRun<Mat3> run;
  begin_homography(pairs, params, scratch, run);
  while (homography_slice(pairs, params, scratch, run)) {  // bound: `max_trials`
  }
  return end_homography(pairs, params, scratch, run, homography);
}

double homography_gric(const NormalisedPairs& pairs, const Mat3& homography, double sigma_px) {
  Gric gric(gric_homography, sigma_px);
  for (const NormalisedPair& pair : pairs.exact) {
    gric.add(homography_sampson_squared(homography, pair, pairs.scale));
  }
  return gric.value();
}

}  // namespace ilp
