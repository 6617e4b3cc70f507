// The focal length that a metric reconstruction supports, its error, and the agreement of its parts.
//
// Small residuals prove nothing here: over a critical motion (F. Kahl, B. Triggs, K. Astrom, "Critical motions for
// auto-calibration when some intrinsic parameters can vary", JMIV 13(2), 2000) every focal length fits. The evidence
// is the covariance of the focal length, its spread over parts of the data, and the end of the search from other
// starts.
#pragma once

#include <array>

#include "fsw/vision/calibration/views_adjustment.hpp"

namespace ilp {

/// The first of `views` views is fixed. Residuals count within Huber's `robust` bound (centred; 0: none).
struct RefinementSetup {
  std::size_t views = 0;
  double sigma_centre = 0.02;  ///< of the principal point, centred units
  double noise = 0.0005;       ///< expected error of a coordinate, centred units
};
[[nodiscard]] AdjustmentParams metric_adjustment(const RefinementSetup& setup, double robust,
                                                 std::uint32_t max_iterations);

/// Which part a slice leaves out: a view, a block of points, or nothing, with another start of the search.
inline constexpr std::size_t other_starts = 2;
inline constexpr std::size_t max_verification_slices =
    limits::max_calibration_views + static_cast<std::size_t>(track_blocks) + other_starts;
[[nodiscard]] constexpr std::size_t verification_slices(std::size_t views) {
  return views + static_cast<std::size_t>(track_blocks) + other_starts;
}

struct VerificationSlice {
  bool told = false;
  double focal = 0;  ///< centred units
  double sigma = 0;
  double cost = 0;  ///< of the other starts
};
using Verification = std::array<VerificationSlice, max_verification_slices>;

struct VerificationWorkspace {
  AdjustmentWorkspace adjustment;
  CalibrationTracks tracks;
  MetricViews part;
  AdjustmentProgress progress;  ///< of the part at work; set it to {} before the first one
};

/// Adjusts a copy without one part, one iteration a call. `tracks` and `views` are the adjusted whole. Yes: call it
/// again for the same slice.
bool verify_focal(std::size_t slice, const CalibrationTracks& tracks, const MetricViews& views,
                  const RefinementSetup& setup, VerificationWorkspace& workspace, VerificationSlice& out);

struct FocalJudgement {
  double consistency = 0;  ///< spread of the parts' focal lengths over the predicted spread: near 1
  /// Centred units: the sigma of the covariance with a noise of at least `least_noise`, times `consistency`, which
  /// counts as at least 1.25.
  double sigma_focal = 0;
  bool unique = true;  ///< no other start found a different focal length that fits as well
};
/// The difference between the estimate from a part and that from the whole has the variance sigma_part^2 - sigma^2
/// (J. Hausman, "Specification Tests in Econometrics", 1978). Registration errors that neighbouring points share leave
/// no residual and are alike in all parts, so that images without noise would seem too reliable otherwise.
[[nodiscard]] FocalJudgement judge_focal(const Verification& verification, std::size_t views, const MetricViews& whole,
                                         const MetricCovariance& covariance, double cost, double least_noise);

/// Largest angle between the optical axes of two views.
[[nodiscard]] double axes_spread_rad(const MetricViews& views, std::size_t count);

}  // namespace ilp
