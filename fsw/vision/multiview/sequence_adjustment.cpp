#include "fsw/vision/multiview/sequence_adjustment.hpp"

#include <cmath>

namespace ilp {

BundleParams SequenceAdjustment::bundle_params(std::uint32_t max_iterations) const {
  BundleParams params;
  params.max_iterations = max_iterations;
  params.robust_px = s_.params.robust_px;
  return params;
}

Status SequenceAdjustment::adjust(std::uint32_t max_iterations, SequencePhase errors, SequencePhase next) {
  const BundleParams params = bundle_params(max_iterations);
  build_window(s_, w_.problem, w_.map);
  const Status begun =
      s_.adjusting ? w_.adjuster.resume(w_.problem, params, s_.bundle) : w_.adjuster.begin(w_.problem, params);
  if (!begun.ok()) {
    // Without anything to adjust the keyframe is kept, with its resected pose.
    s_.adjusting = false;
    s_.phase = next;
    return begun.is(StatusCode::no_model) ? Status{} : begun;
  }
  if (!s_.adjusting || !s_.bundle.descent.done) {
    ILP_TRY(w_.adjuster.step());
    s_.bundle = w_.adjuster.progress();
    s_.adjusting = true;
  } else {
    ILP_TRY(finish_adjustment());
    s_.adjusting = false;
    s_.phase = errors;
  }
  store_window(w_.problem, w_.map, s_);
  return {};
}

Status SequenceAdjustment::finish_adjustment() {
  BundleResult result;
  ILP_TRY(w_.adjuster.finish(result, &w_.errors.window));
  s_.report.rms_px = result.final_rms_px;
  s_.report.bundle_points = result.points;
  s_.report.bundle_observations = result.observations;
  s_.report.bundle_iterations += result.iterations;
  s_.report.unadjusted_points = w_.map.left_out;
  s_.report.scale_held = w_.problem.hold.held;
  return {};
}

void SequenceAdjustment::state_errors(std::uint32_t max_iterations, SequencePhase next) {
  if (s_.params.lens_covariance[0] > 0) {
    derive_by_intrinsics(w_.problem, bundle_params(max_iterations), s_.camera, w_.errors);
  } else {
    w_.errors.by_intrinsics.fill(0);
  }
  allow_correlated_tracks(w_.problem, bundle_params(max_iterations), w_.errors);
  propagate_covariance(w_.problem, w_.map, w_.errors, s_.covariance);
  write_errors();
  s_.phase = next;
}

void SequenceAdjustment::write_errors() {
  for (std::size_t i = 0; i < w_.problem.cameras.size(); ++i) {
    if (w_.problem.cameras[i].fixed) continue;
    const std::size_t index = w_.map.camera[i];
    const bool known = ((s_.covariance.known >> index) & 1U) != 0;
    double by_lens[21] = {};
    add_error_of_lens(s_.covariance, index, intrinsics_covariance(s_.params.lens_covariance), by_lens);
    for (std::size_t k = 0; k < 3; ++k) {
      const double variance = known ? s_.covariance.variance_of_centre(index, k) : 0;
      const std::size_t diagonal = (k + 3) * (k + 4) / 2 + k + 3;
      const double factor = s_.params.error_factor;
      const double sigma = factor * std::sqrt(variance);
      // A known lens leaves every bit of it.
      const bool open = by_lens[diagonal] > 0;
      s_.cameras[index].sigma_position[k] = variance > 0 && open ? std::sqrt(sigma * sigma + by_lens[diagonal]) : sigma;
    }
  }
}

}  // namespace ilp
