// Writes a score as JSON, and as a table for people.
#pragma once

#include <iosfwd>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "sim/tools/score/dense_score.hpp"
#include "sim/tools/score/score.hpp"

namespace ilp::score {

// The dense scores as JSON objects and as summary numbers.

/// The objects `depth`, `height`, `metric_height`, `mask`, `quality`, `overlap` and `links` of the flight, and the
/// arrays `strips`, `keyframes` and `remarks`. Errors are in per cent of the flying height, shares in [0, 1], profiles
/// in the truth's unit. Unknown values are null.
[[nodiscard]] nlohmann::ordered_json dense_json(const DenseScore& score);

/// Numbers for tables over many flights, among them these; NaN where a flight gives no value:
///   height_bias_percent, height_median_percent, height_p95_percent   merged heights, strip's similarity
///   depth_median_percent, depth_p95_percent                          depths, strip's similarity
///   completeness                                                     share of the newly seen ground with depth
///   depth_sigma1_share, depth_sigma2_share, depth_nes                errors against the estimated sigmas of matching
///   depth_pose_sigma1_share, depth_pose_sigma2_share                 against those of matching and poses together
///   track_mapped_share, track_depth_median_percent, landing_sampling_ratio   TrackScore
///   mask_precision, mask_recall, double_coded_share                  against what was truly newly seen
///   overlap_true_mean, overlap_true_std, overlap_error_p95           of keyframes in a row; of all measurements
///   image_psnr_db, image_bytes_per_masked_pixel                      inside the masks
[[nodiscard]] std::map<std::string, double> dense_summary(const DenseScore& score);

inline constexpr int score_version = 1;

/// Version, completeness, counts, `strips`, `keyframes` and `remarks`. Lengths are in the truth's unit, angles in
/// degrees; `sigma` and `relative_error` are along the strip's axes in the truth's unit. Unknown values are null.
[[nodiscard]] nlohmann::ordered_json score_json(const Score& score, const FlightFiles& files);

/// The summary as an object. Metrics are in the order of host::metrics, then all others; NaN becomes null.
[[nodiscard]] nlohmann::ordered_json summary_json(const std::map<std::string, double>& summary);

void write_table(const Score& score, const std::map<std::string, double>& summary, std::ostream& out);

}  // namespace ilp::score
