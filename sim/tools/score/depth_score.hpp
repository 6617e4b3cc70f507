// Downlinked depths against the true ones, pixel by pixel.
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

// Signed errors in per cent of the flying height, and what is said of many of them.

struct ErrorPercent {
  std::size_t count = 0;
  double bias = unknown;    ///< median of the signed errors
  double median = unknown;  ///< of their absolute values
  double p95 = unknown;     ///< 95 % of the absolute values lie below
};

[[nodiscard]] ErrorPercent error_percent(const std::vector<float>& signed_percent);

/// How the errors compare with the sigmas stated for them: 0.683, 0.954, 1 and 1 are perfect for normal errors.
struct SigmaShares {
  std::size_t count = 0;
  double within_1 = unknown, within_2 = unknown;  ///< shares of the errors
  double squared = unknown;                       ///< mean of (error / sigma)^2
  double squared_robust = unknown;                ///< the same from its median: without the few that are far off
};

[[nodiscard]] SigmaShares sigma_shares(const std::vector<float>& errors_in_sigmas);

/// A strip laid onto the truth by the positions and attitudes of its posed keyframes (host::align_cameras, reach =
/// flying height).
struct AlignedStrip {
  std::int64_t id = 0;
  std::vector<std::int64_t> keyframes;  ///< with a final and a true pose, by id
  host::Similarity3 true_from_strip;
  /// The alignment without estimating the scale, if an altimeter fixed it (PoseRecord::scale_source of every keyframe).
  std::optional<host::Similarity3> true_from_metric_strip;
};

/// None when fewer than two posed keyframes have a true pose. `flying_height` in the truth's unit.
[[nodiscard]] std::optional<AlignedStrip> align_strip(const intake::Flight& flight, const intake::Strip& strip,
                                                      const report::Reference& reference, double flying_height);

/// One-sigma error of a keyframe's inverse depths, 1 / strip unit. What comes down is the median sigma of the disparity
/// (DepthRecord::median_sigma_px) and the step of the coding, uniform over +-step / 2; the sigma of every pixel stays
/// on board. None when the record did not come or states nothing.
[[nodiscard]] std::optional<double> estimated_sigma(const intake::Keyframe& keyframe);

/// Signed errors, one per pixel with depth and true depth, in per cent of the flying height; positive: too deep, too
/// high.
struct DepthErrors {
  double flying_height = 0;          ///< median true depth of the image, truth's unit
  std::vector<float> strip_scale;    ///< of the depth, strip's similarity
  std::vector<float> metric_scale;   ///< of the depth, scale as flown; empty unless metric
  std::vector<float> own_scale;      ///< of the depth, scaled to the true median: shape alone
  std::vector<float> height;         ///< of the reconstructed point's z against the z of the point truly seen there
  std::vector<float> in_sigmas;      ///< inverse depths, strip's similarity; empty when no sigma is stated
  std::vector<float> own_in_sigmas;  ///< inverse depths, own scale: without the error of the baseline's length
  /// As in_sigmas, of matching, both poses (PoseRecord::step_covariance) and the lens.
  std::vector<float> in_sigmas_with_poses;

  void append(const DepthErrors& other);
};

/// `truth` has every pixel; `to_partner` are the keyframes with a pose after this one, up to the one it was matched
/// with; none when that is not known. Empty lists when the keyframe has no depth of this size.
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
