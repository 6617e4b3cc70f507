#include "fsw/vision/twoview/robust_models.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/twoview/eight_point.hpp"
#include "fsw/vision/twoview/epipolar_error.hpp"
#include "fsw/vision/twoview/gric.hpp"
#include "fsw/vision/twoview/homography_problem.hpp"
#include "fsw/vision/twoview/seven_point.hpp"
#include "fsw/vision/twoview/two_view_workspace.hpp"

namespace ilp {
namespace {

double select_epipolar_inliers(const NormalisedPairs& pairs, const Mat3& fundamental, double threshold_px,
                               PairIndices& selected) {
  double sum = 0;
  selected.clear();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double squared = sampson_squared(fundamental, pairs.exact[i], pairs.scale);
    if (!(squared < threshold_px * threshold_px)) continue;
    static_cast<void>(selected.push_back(static_cast<std::uint16_t>(i)));  // same capacity as `pairs`
    sum += squared;
  }
  return sum;
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
    constexpr double widening = 2;
    constexpr int steps = 5;
    select_epipolar_inliers(pairs, model, widening * threshold_px, scratch);
    const RefinementParams params{RobustLoss::truncated, threshold_px, steps, 1e-4};
    return refine_fundamental(pairs, {scratch.data(), scratch.size()}, params, model);
  }
};

/// Linear least squares on the inliers as a second start: where it scores better, the local search was caught.
void polish(const NormalisedPairs& pairs, const RansacParams& params, PairIndices& scratch, Mat3& fundamental) {
  select_epipolar_inliers(pairs, fundamental, params.threshold_px, scratch);
  constexpr double widening = 2.5;
  const RefinementParams refinement{RobustLoss::tukey, widening * params.threshold_px, 20, 1e-8};
  RansacScore best;
  score_epipolar(pairs, fundamental, params.threshold_px, {}, best);
  Mat3 candidates[2] = {fundamental, fundamental};
  const bool linear = eight_point(pairs, {scratch.data(), scratch.size()}, candidates[1]);
  for (int k = 0; k < (linear ? 2 : 1); ++k) {
    select_epipolar_inliers(pairs, candidates[k], widening * params.threshold_px, scratch);
    refine_fundamental(pairs, {scratch.data(), scratch.size()}, refinement, candidates[k]);
    RansacScore score;
    // The smooth cost of the first candidate is preferred to the truncated one that it started from.
    if (k == 0 || score_epipolar(pairs, candidates[k], params.threshold_px, {best.cost}, score)) {
      fundamental = candidates[k];
      score_epipolar(pairs, fundamental, params.threshold_px, {}, best);
    }
  }
}

void mark(const NormalisedPairs& pairs, const PairIndices& selected, std::size_t size, InlierMask& inliers) {
  inliers.clear();
  static_cast<void>(inliers.resize(size));
  for (const std::uint16_t i : selected) inliers[pairs.source[i]] = 1;
}

}  // namespace

Status validate(const RansacParams& params) {
  if (!(params.threshold_px > 0) || !(params.threshold_px < 1000)) return {StatusCode::invalid_argument, 1};
  if (!(params.confidence > 0) || !(params.confidence < 1)) return {StatusCode::invalid_argument, 2};
  if (params.max_trials == 0 || params.max_trials > limits::max_ransac_trials) {
    return {StatusCode::invalid_argument, 3, params.max_trials};
  }
  if (!(params.min_parallax_px >= 0)) return {StatusCode::invalid_argument, 6};
  if (!(params.max_sigma_direction_rad > 0)) return {StatusCode::invalid_argument, 7};
  return {};
}

Status estimate_fundamental(const PointPairs& pairs, const RansacParams& params, TwoViewWorkspace& workspace,
                            InlierMask& inliers, FundamentalResult& result) {
  result = {};
  inliers.clear();
  static_cast<void>(inliers.resize(pairs.size()));
  ILP_TRY(validate(params));
  NormalisedPairs& all = workspace.pairs;
  PairIndices& selected = workspace.selected;
  ImageNormalisation a;
  ImageNormalisation b;
  isotropic_normalisation(pairs, a, b);
  normalise_pairs(pairs, a, b, params.seed, all);

  FundamentalProblem problem{all, params.threshold_px, selected};
  Mat3 f;
  if (!ransac(problem, all, params, f).found) return {};
  polish(all, params, selected, f);
  const double sum = select_epipolar_inliers(all, f, params.threshold_px, selected);
  result.inliers = static_cast<std::uint32_t>(selected.size());
  if (selected.size() < 8 || selected.size() < params.min_inliers) return {};
  mark(all, selected, pairs.size(), inliers);
  result.rms_px = std::sqrt(sum / static_cast<double>(selected.size()));
  result.fundamental = (b.normalised_from_pixel().transpose() * f * a.normalised_from_pixel()).normalized();
  result.found = result.fundamental.allFinite();

  Gric gric(gric_fundamental, sigma_of(params));
  for (const NormalisedPair& pair : all.exact) gric.add(sampson_squared(f, pair, all.scale));
  result.gric = gric.value();
  Gric on_inliers(gric_fundamental, sigma_of(params));
  select_subset(all, selected, workspace.subset);
  for (const NormalisedPair& pair : workspace.subset.exact) {
    on_inliers.add(sampson_squared(f, pair, workspace.subset.scale));
  }
  result.gric_inliers = on_inliers.value();
  // Enough for a homography of half the inliers; one of fewer is never the better explanation.
  RansacParams comparison = params;
  comparison.max_trials = std::min(params.max_trials, 150U);
  Mat3 h = Mat3::Identity();
  find_homography(workspace.subset, comparison, workspace.subset_selected, h);
  result.gric_homography = homography_gric(workspace.subset, h, sigma_of(params));
  return {};
}

Status estimate_homography(const PointPairs& pairs, const RansacParams& params, TwoViewWorkspace& workspace,
                           InlierMask& inliers, HomographyResult& result) {
  result = {};
  inliers.clear();
  static_cast<void>(inliers.resize(pairs.size()));
  ILP_TRY(validate(params));
  NormalisedPairs& all = workspace.pairs;
  PairIndices& selected = workspace.selected;
  ImageNormalisation a;
  ImageNormalisation b;
  isotropic_normalisation(pairs, a, b);
  normalise_pairs(pairs, a, b, params.seed, all);

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
