#include "sim/ground/report/score_names.hpp"

#include <cmath>

#include "sim/host/text_format.hpp"

namespace ilp::ground {
namespace {

constexpr ScoreName names[] = {
    {"frames", "Flight", "frames", ""},
    {"keyframes", "Flight", "keyframes", ""},
    {"frames_per_keyframe", "Flight", "frames per keyframe", ""},
    {"posed_share", "Flight", "keyframes with a final pose, share", "1"},
    {"position_mean_percent", "Poses", "position error, mean, % of distance", "0"},
    {"position_max_percent", "Poses", "position error, largest, % of distance", "0"},
    {"position_rigid_mean_percent", "Poses", "the same without scale alignment, mean, %", "0"},
    {"rotation_mean_deg", "Poses", "rotation error, mean, degrees", "0"},
    {"rotation_max_deg", "Poses", "rotation error, largest, degrees", "0"},
    {"drift_percent", "Poses", "drift to the far end, % of distance", "0"},
    {"scale_drift_percent", "Poses", "scale drift along the strip, %", "0"},
    {"bow_percent", "Poses", "bow of the heights, % of flying height", "0"},
    {"sigma1_share", "Poses", "position errors within 1 sigma, share", "0.683"},
    {"sigma2_share", "Poses", "position errors within 2 sigma, share", "0.954"},
    {"position_nes", "Poses", "normalised position error squared", "1"},
    {"height_bias_percent", "Heights and depths", "height bias, % of flying height", "0"},
    {"height_median_percent", "Heights and depths", "height error, median, %", "0"},
    {"height_p95_percent", "Heights and depths", "height error, 95 % are below, %", "0"},
    {"depth_median_percent", "Heights and depths", "depth error, median, %", "0"},
    {"depth_p95_percent", "Heights and depths", "depth error, 95 % are below, %", "0"},
    {"completeness", "Heights and depths", "completeness of depth, share", "1"},
    {"depth_sigma1_share", "Heights and depths", "depth errors within 1 sigma, share", "0.683"},
    {"depth_sigma2_share", "Heights and depths", "depth errors within 2 sigma, share", "0.954"},
    {"depth_nes", "Heights and depths", "normalised depth error squared", "1"},
    {"depth_pose_sigma1_share", "Heights and depths", "the same with the poses' error, 1 sigma, share", "0.683"},
    {"depth_pose_sigma2_share", "Heights and depths", "the same with the poses' error, 2 sigma, share", "0.954"},
    {"terrain_coverage", "What the ground has", "ground with a height, share of all seen", "1"},
    {"terrain_known_share", "What the ground has", "right within 0.1 % of flying height, share", "1"},
    {"terrain_half_percent", "What the ground has", "half of all ground is right within, % of flying height", "0"},
    {"relief_known_share", "What the ground has", "shape right within 0.05 % of flying height, share", "1"},
    {"relief_median_percent", "What the ground has", "error of the ground's shape, median, % of flying height", "0"},
    {"relief_p95_percent", "What the ground has", "error of the ground's shape, 95 % are below, %", "0"},
    {"features", "What the ground has", "planted features flown over", ""},
    {"feature_share", "What the ground has", "of them seen with heights and 30 dB, share", "1"},
    {"feature_well_share", "What the ground has", "seen with heights and 35 dB, share", "1"},
    {"feature_psnr_db", "What the ground has", "image quality of features, dB", ""},
    {"received_mb", "What the ground has", "files that came down, MB", ""},
    {"mask_precision", "Masks, overlap, images", "mask: share of it that is new ground", "1"},
    {"mask_recall", "Masks, overlap, images", "mask: share of new ground in it", "1"},
    {"double_coded_share", "Masks, overlap, images", "ground coded twice, share", "0"},
    {"overlap_true_mean", "Masks, overlap, images", "true overlap of keyframes, mean", ""},
    {"overlap_true_std", "Masks, overlap, images", "true overlap of keyframes, deviation", "0"},
    {"overlap_error_p95", "Masks, overlap, images", "error of the stated overlap, 95 % are below", "0"},
    {"image_psnr_db", "Masks, overlap, images", "image quality inside the mask, dB", ""},
    {"image_bytes_per_masked_pixel", "Masks, overlap, images", "image bytes per pixel of the mask", ""},
};

}  // namespace

std::span<const ScoreName> score_names() {
  return names;
}

std::string score_text(double value) {
  return value == std::floor(value) ? fixed(value, 0) : brief(value);
}

}  // namespace ilp::ground
