#include "fsw/vision/calibration/focal_refinement.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"

namespace ilp {
namespace {

constexpr std::uint32_t part_iterations = 12;  // parts start at the whole's solution
constexpr std::uint32_t restart_iterations = 40;
// The covariance assumes white noise; errors that follow a track from image to image have a larger effect.
constexpr double least_inflation = 1.25;
constexpr double restart_factor[2] = {0.8, 1.25};

/// Sets another focal length, and the depths that compensate for it as far as parallel axes would allow.
void stretch(double factor, CalibrationTracks& tracks, MetricViews& views) {
  views.focal *= factor;
  for (CalibrationTrack& track : tracks) {
    for (double& value : track.point) value /= factor;
  }
  for (MetricCamera& camera : views.cameras) camera.translation[2] *= factor;
}

/// Params that leave one view out.
AdjustmentParams without_view(std::size_t view, AdjustmentParams params) {
  params.views &= static_cast<ViewSet>(~only_view(view));
  params.fixed_view = view == 0 ? 1 : 0;
  return params;
}

double mean_square_of_differences(const VerificationSlice* slices, std::size_t count, double focal, double sigma) {
  double sum = 0;
  double told = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (!slices[i].told) continue;
    const double difference = slices[i].focal - focal;
    // A part with almost no influence still differs by rounding and by nonlinearity.
    const double variance = std::fmax(slices[i].sigma * slices[i].sigma - sigma * sigma, 0.05 * sigma * sigma);
    sum += difference * difference / variance;
    told += 1;
  }
  return told > 0 ? sum / told : 0;
}

}  // namespace

AdjustmentParams metric_adjustment(const RefinementSetup& setup, double robust, std::uint32_t max_iterations) {
  AdjustmentParams params;
  params.views = static_cast<ViewSet>((1U << setup.views) - 1U);
  // A wrong match on its epipolar line is not detectable in two views, and such points far off the ground have a large
  // influence. A third view reveals them.
  params.min_views = 3;
  params.robust = robust;
  params.max_iterations = max_iterations;
  params.centre_weight = setup.noise * setup.noise / (setup.sigma_centre * setup.sigma_centre);
  return params;
}

bool verify_focal(std::size_t slice, const CalibrationTracks& tracks, const MetricViews& views,
                  const RefinementSetup& setup, VerificationWorkspace& workspace, VerificationSlice& out) {
  const std::size_t blocks_end = setup.views + static_cast<std::size_t>(track_blocks);
  const bool restart = slice >= blocks_end;
  AdjustmentParams params = metric_adjustment(setup, 0, restart ? restart_iterations : part_iterations);
  if (slice < setup.views) {
    params = without_view(slice, params);
  } else if (!restart) {
    params.left_out = static_cast<std::int32_t>(slice - setup.views);
  }
  if (workspace.progress.iterations == 0) {
    workspace.tracks = tracks;
    workspace.part = views;
    if (restart) stretch(restart_factor[slice - blocks_end], workspace.tracks, workspace.part);
  }
  adjust_metric(workspace.tracks, workspace.part, params, workspace.adjustment, workspace.progress);
  if (!workspace.progress.done) return true;
  MetricCovariance covariance;
  metric_covariance(workspace.tracks, workspace.part, params, workspace.adjustment, covariance);
  out = {covariance.valid, workspace.part.focal, covariance.sigma_focal, workspace.progress.cost};
  workspace.progress = {};
  return false;
}

FocalJudgement judge_focal(const Verification& verification, std::size_t views, const MetricViews& whole,
                           const MetricCovariance& covariance, double cost, double least_noise) {
  FocalJudgement out;
  const double sigma = covariance.sigma_focal;
  const double by_views = mean_square_of_differences(verification.data(), views, whole.focal, sigma);
  const double by_blocks = mean_square_of_differences(verification.data() + views,
                                                      static_cast<std::size_t>(track_blocks), whole.focal, sigma);
  out.consistency = std::sqrt(std::fmax(by_views, by_blocks));
  const double unseen = covariance.noise > 0 ? std::fmax(1, least_noise / covariance.noise) : 1;
  out.sigma_focal = std::fmax(least_inflation, out.consistency) * unseen * sigma;
  for (std::size_t i = 0; i < 2; ++i) {
    const VerificationSlice& other = verification[views + static_cast<std::size_t>(track_blocks) + i];
    // Chi-square by which the other result costs more: below 16 the data do not decide between the two.
    const double worse = 2 * (other.cost - cost) / (covariance.noise * covariance.noise);
    const bool elsewhere = !(std::fabs(other.focal - whole.focal) <= sigma);
    if (elsewhere && worse < 16) out.unique = false;
  }
  return out;
}

double axes_spread_rad(const MetricViews& views, std::size_t count) {
  double smallest = 1;
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      double cosine = 0;
      for (std::size_t k = 6; k < 9; ++k) cosine += views.cameras[a].rotation[k] * views.cameras[b].rotation[k];
      smallest = std::fmin(smallest, cosine);
    }
  }
  return det_acos(smallest);
}

}  // namespace ilp
