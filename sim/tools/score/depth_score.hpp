// Scores downlinked depths against the true depths, pixel by pixel.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "fsw/records/records.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/map/pixel_rays.hpp"
#include "sim/ground/report/accuracy.hpp"
#include "sim/host/alignment.hpp"
#include "sim/world/visibility.hpp"

namespace ilp::score {

// Statistics of signed errors in per cent of the flying height.

struct ErrorPercent {
  std::size_t count = 0;
  double bias = unknown;    ///< median of the signed errors
  double median = unknown;  ///< of the absolute errors
  double p95 = unknown;     ///< 95th percentile of the absolute errors
};

[[nodiscard]] ErrorPercent error_percent(const std::vector<float>& signed_percent);

/// Statistics of errors divided by their estimated sigmas. Normal errors with correct sigmas give 0.683, 0.954, 1
/// and 1.
struct SigmaShares {
  std::size_t count = 0;
  double within_1 = unknown, within_2 = unknown;  ///< shares of errors within one and two sigmas
  double squared = unknown;                       ///< mean of (error / sigma)^2
  double squared_robust = unknown;                ///< the same from the median, so that outliers have no effect
};

[[nodiscard]] SigmaShares sigma_shares(const std::vector<float>& errors_in_sigmas);

/// A strip aligned to the truth by the positions and attitudes of its posed keyframes (host::align_cameras with the
/// flying height as reach).
struct AlignedStrip {
  std::int64_t id = 0;
  std::vector<std::int64_t> keyframes;  ///< ids of those with a final and a true pose
  host::Similarity3 true_from_strip;
  /// The alignment with scale 1; empty unless the scale of every keyframe was measured (PoseRecord::scale_source).
  std::optional<host::Similarity3> true_from_metric_strip;
};

/// Empty if fewer than two posed keyframes have a true pose. `flying_height` is in the truth's unit.
[[nodiscard]] std::optional<AlignedStrip> align_strip(const intake::Flight& flight, const intake::Strip& strip,
                                                      const report::Reference& reference, double flying_height);

/// One-sigma error of a keyframe's inverse depths, in 1 / strip unit, for pixels without a sigma of their block.
/// Combines the median sigma of the disparity (DepthRecord::median_sigma_px) and the coding error, uniform over +-step
/// / 2. Empty if the record is missing or has no sigma.
[[nodiscard]] std::optional<double> estimated_sigma(const intake::Keyframe& keyframe);

/// Signed errors of the pixels with a depth and a true depth. Errors of depth (positive: too deep) and of height
/// (positive: too high) are in per cent of the flying height; `in_sigmas` and the like are errors of inverse depth
/// divided by their sigma.
struct DepthErrors {
  double flying_height = 0;          ///< median true depth of the image, truth's unit
  std::vector<float> strip_scale;    ///< depth, scaled by the strip's similarity
  std::vector<float> metric_scale;   ///< depth, scale as flown; empty unless metric
  std::vector<float> own_scale;      ///< depth, scaled by the median ratio to the true depths: error of shape alone
  std::vector<float> height;         ///< z of the reconstructed point minus z of the true point of the pixel
  std::vector<float> in_sigmas;      ///< scaled by the strip's similarity; sigma of matching; empty without sigmas
  std::vector<float> own_in_sigmas;  ///< as in_sigmas with the own scale: without the error of the baseline's length
  /// As in_sigmas, with the joint sigma of matching, both poses (PoseRecord::step_covariance) and the lens.
  std::vector<float> in_sigmas_with_poses;

  void append(const DepthErrors& other);
};

/// Errors of a keyframe. `truth` has every pixel (stride 1). `to_partner` holds the posed keyframes after this one, up
/// to its stereo partner; empty if the partner is not known. The lists are empty if the keyframe has no depth of the
/// truth's size.
[[nodiscard]] DepthErrors depth_errors(const intake::Keyframe& keyframe,
                                       std::span<const intake::Keyframe* const> to_partner,
                                       const world::TrueFrame& truth, const AlignedStrip& strip, map::PixelRays& rays);

struct DepthScore {
  double flying_height = 0;
  ErrorPercent strip_scale, own_scale, height;
  std::optional<ErrorPercent> metric_scale;
  SigmaShares sigma, own_sigma, sigma_with_poses;
};

[[nodiscard]] DepthScore depth_score(const DepthErrors& errors);

}  // namespace ilp::score
