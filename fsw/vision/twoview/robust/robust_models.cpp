#include "fsw/vision/twoview/robust/robust_models.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/vision/twoview/refine/epipolar_refinement.hpp"
#include "fsw/vision/twoview/refine/match_error.hpp"
#include "fsw/vision/twoview/robust/chance_matches.hpp"
#include "fsw/vision/twoview/robust/gric.hpp"
#include "fsw/vision/twoview/robust/homography_problem.hpp"
#include "fsw/vision/twoview/robust/local_optimisation.hpp"
#include "fsw/vision/twoview/robust/model_score.hpp"
#include "fsw/vision/twoview/robust/ransac.hpp"
#include "fsw/vision/twoview/robust/two_view_workspace.hpp"
#include "fsw/vision/twoview/solvers/eight_point.hpp"
#include "fsw/vision/twoview/solvers/seven_point.hpp"

namespace ilp {
namespace {

double select_epipolar_inliers(const NormalisedPairs& pairs, const Mat3& fundamental, double threshold_px,
                               PairIndices& selected) {
  return select_matches(pairs, threshold_px, selected,
                        [&](const NormalisedPair& pair) { return sampson_squared(fundamental, pair, pairs.scale); });
}

struct FundamentalProblem {
  using Model = Mat3;
  static constexpr std::size_t sample_size = 7;
  static constexpr std::size_t max_models = max_seven_point_solutions;

  const NormalisedPairs& pairs;
  double threshold_px;
  PairIndices& scratch;

  std::size_t solve(const std::uint16_t* sample, Model* models) const {
    Vec3 a[sample_size];
    Vec3 b[sample_size];
    for (std::size_t i = 0; i < sample_size; ++i) {
      a[i] = pairs.exact[sample[i]].ray_a();
      b[i] = pairs.exact[sample[i]].ray_b();
    }
    return seven_point(a, b, models);
  }

  bool score(const Model& model, const CostBound& bound, RansacScore& score) const {
    return score_epipolar(pairs, model, threshold_px, bound, score);
  }

  bool improve(Model& model) {
    select_epipolar_inliers(pairs, model, local_widening * threshold_px, scratch);
    return refine_fundamental(pairs, {scratch.data(), scratch.size()}, local_refinement(threshold_px), model);
  }
};

constexpr double refinement_bound = 2.5;  ///< of Tukey's loss, thresholds

/// Refines on the nearby `pairs`, if that gives a better score.
void refine_if_better(const NormalisedPairs& pairs, const RansacParams& params, double widening, Mat3 candidate,
                      PairIndices& scratch, Mat3& fundamental, RansacScore& best) {
  while (widening >= refinement_bound) {
    const double bound_px = widening * params.threshold_px;
    select_epipolar_inliers(pairs, candidate, bound_px, scratch);
    const bool last = 0.5 * widening < refinement_bound;
    const RefinementParams refinement{RobustLoss::tukey, bound_px, last ? 20U : 4U, last ? 1e-6 : 1e-3};
    refine_fundamental(pairs, {scratch.data(), scratch.size()}, refinement, candidate);
    widening *= 0.5;
  }
  RansacScore score;
  if (!score_epipolar(pairs, candidate, params.threshold_px, {best.cost}, score)) return;
  best = score;
  fundamental = candidate;
}

/// A second start from linear least squares on the inliers. A better score shows that the local search was in a local
/// minimum.
void polish(const NormalisedPairs& pairs, const RansacParams& params, PairIndices& scratch, Mat3& fundamental) {
  select_epipolar_inliers(pairs, fundamental, params.threshold_px, scratch);
  Mat3 linear;
  const bool has_linear = eight_point(pairs, {scratch.data(), scratch.size()}, linear);
  // The smooth cost is preferred to the truncated one that selected the start.
  RansacScore best;
  best.cost = std::numeric_limits<double>::max();
  refine_if_better(pairs, params, refinement_bound, fundamental, scratch, fundamental, best);
  if (has_linear) refine_if_better(pairs, params, refinement_bound, linear, scratch, fundamental, best);
}

/// The homography of the inliers; and where the ground is near enough to a plane, the matrix refined once more among
/// the matches near that plane, which `workspace.subset` then holds. There, from afar: a sample's matrix explains most
/// matches of nearly flat ground even if it is far from the best one, and what matches by chance holds it there.
bool polish_near_plane(const RansacParams& params, TwoViewWorkspace& workspace, Mat3& fundamental, Mat3& homography) {
  const NormalisedPairs& all = workspace.pairs;
  NormalisedPairs& near = workspace.subset;
  PairIndices& scratch = workspace.subset_selected;
  const double bound_px = refinement_bound * params.threshold_px;
  select_epipolar_inliers(all, fundamental, bound_px, workspace.selected);
  select_subset(all, workspace.selected, near);
  // Enough for a homography of half the inliers; one of fewer is never the better explanation.
  RansacParams comparison = params;
  comparison.max_trials = std::min(params.max_trials, 150U);
  if (!find_homography(near, comparison, scratch, homography)) return false;
  constexpr double side_over_scale = 3.7;  // of a square in which matches lie evenly
  if (!remove_chance_matches(all, near, homography, params.threshold_px, bound_px, side_over_scale * all.scale.bx,
                             workspace.scratch, scratch)) {
    return false;
  }
  select_subset(all, scratch, near);
  constexpr double afar = 4 * refinement_bound;
  RansacScore best;
  score_epipolar(near, fundamental, params.threshold_px, {}, best);
  select_epipolar_inliers(near, fundamental, afar * params.threshold_px, scratch);
  Mat3 linear;
  if (eight_point(near, {scratch.data(), scratch.size()}, linear)) {
    refine_if_better(near, params, afar, linear, scratch, fundamental, best);
  }
  return true;
}

void mark(const NormalisedPairs& pairs, const PairIndices& selected, std::size_t size, InlierMask& inliers) {
  inliers.clear();
  static_cast<void>(inliers.resize(size));
  for (const std::uint16_t i : selected) inliers[pairs.source[i]] = 1;
}

/// Checks the parameters and normalises the matches; no match is an inlier yet.
Status prepare(const PointPairs& pairs, const RansacParams& params, ImageNormalisation& a, ImageNormalisation& b,
               NormalisedPairs& all, InlierMask& inliers) {
  inliers.clear();
  static_cast<void>(inliers.resize(pairs.size()));
  ILP_TRY(validate(params));
  isotropic_normalisation(pairs, a, b);
  normalise_pairs(pairs, a, b, params.seed, all);
  return {};
}

}  // namespace

Status estimate_fundamental(const PointPairs& pairs, const RansacParams& params, TwoViewWorkspace& workspace,
                            InlierMask& inliers, FundamentalResult& result) {
  result = {};
  ImageNormalisation a;
  ImageNormalisation b;
  ILP_TRY(prepare(pairs, params, a, b, workspace.pairs, inliers));
  NormalisedPairs& all = workspace.pairs;
  PairIndices& selected = workspace.selected;

  FundamentalProblem problem{all, params.threshold_px, selected};
  Mat3 f;
  if (!ransac(problem, all, params, f).found) return {};
  polish(all, params, selected, f);
  Mat3 h = Mat3::Identity();
  const NormalisedPairs& supporting = polish_near_plane(params, workspace, f, h) ? workspace.subset : all;
  const double sum = select_epipolar_inliers(supporting, f, params.threshold_px, selected);
  result.inliers = static_cast<std::uint32_t>(selected.size());
  if (selected.size() < 8 || selected.size() < params.min_inliers) return {};
  mark(supporting, selected, pairs.size(), inliers);
  result.rms_px = std::sqrt(sum / static_cast<double>(selected.size()));
  result.fundamental = (b.normalised_from_pixel().transpose() * f * a.normalised_from_pixel()).normalized();
  result.found = result.fundamental.allFinite();

  Gric gric(gric_fundamental, sigma_of(params));
  for (const NormalisedPair& pair : all.exact) gric.add(sampson_squared(f, pair, all.scale));
  result.gric = gric.value();
  Gric on_inliers(gric_fundamental, sigma_of(params));
  Gric of_homography(gric_homography, sigma_of(params));
  for (const std::uint16_t i : selected) {
    const NormalisedPair& pair = supporting.exact[i];
    on_inliers.add(sampson_squared(f, pair, all.scale));
    of_homography.add(homography_sampson_squared(h, pair, all.scale));
  }
  result.gric_inliers = on_inliers.value();
  result.gric_homography = of_homography.value();
  return {};
}

Status estimate_homography(const PointPairs& pairs, const RansacParams& params, TwoViewWorkspace& workspace,
                           InlierMask& inliers, HomographyResult& result) {
  result = {};
  NormalisedPairs& all = workspace.pairs;
  PairIndices& selected = workspace.selected;
  ImageNormalisation a;
  ImageNormalisation b;
  ILP_TRY(prepare(pairs, params, a, b, all, inliers));
  Mat3 h;
  if (!find_homography(all, params, selected, h)) return {};
  const double sum = select_homography_inliers(all, h, params.threshold_px, selected);
  result.inliers = static_cast<std::uint32_t>(selected.size());
  if (selected.size() < 5 || selected.size() < params.min_inliers) return {};
  mark(all, selected, pairs.size(), inliers);
  result.rms_px = std::sqrt(sum / static_cast<double>(selected.size()));
  result.gric = homography_gric(all, h, sigma_of(params));
  result.homography = (b.pixel_from_normalised() * h * a.normalised_from_pixel()).normalized();
  result.found = result.homography.allFinite();
  return {};
}

}  // namespace ilp
