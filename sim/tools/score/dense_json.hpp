// The dense scores as JSON and as flat numbers.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "sim/tools/score/dense_score.hpp"

namespace ilp::score {

/// Objects `depth`, `height`, `mask`, `quality`, `overlap` of the flight, `strips`, `keyframes` and `remarks`. Errors
/// are in per cent of the flying height, shares in [0, 1], profiles in the truth's unit; what is not known is null.
[[nodiscard]] nlohmann::ordered_json dense_json(const DenseScore& score);

/// For tables over many flights; NaN where a flight gives no value:
///   height_bias_percent, height_median_percent, height_p95_percent   merged heights, strip's similarity
///   depth_median_percent, depth_p95_percent                          depths, strip's similarity
///   completeness                                                     share of the newly seen ground with depth
///   depth_sigma1_share, depth_sigma2_share, depth_nes                errors against the stated sigmas of matching
///   depth_pose_sigma1_share, depth_pose_sigma2_share                 against those of matching and poses together
///   mask_precision, mask_recall, double_coded_share                  against what was truly newly seen
///   overlap_true_mean, overlap_true_std, overlap_error_p95           of keyframes in a row; of all measurements
///   image_psnr_db, image_bytes_per_masked_pixel                      inside the masks
[[nodiscard]] std::map<std::string, double> dense_summary(const DenseScore& score);

}  // namespace ilp::score
