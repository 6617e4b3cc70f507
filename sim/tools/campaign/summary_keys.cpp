#include "sim/tools/campaign/summary_keys.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ilp::batch {
namespace {

constexpr std::array keys = {
    SummaryKey{"frames", "frames", Better::neither},
    SummaryKey{"keyframes", "keyframes", Better::neither},
    SummaryKey{"frames_per_keyframe", "frames per keyframe", Better::neither},
    SummaryKey{"posed_share", "share of keyframes with a final pose", Better::higher},
    SummaryKey{"camera_calibrated", "unknown camera found: 1, not found: 0", Better::higher},
    SummaryKey{"calibration_keyframe", "keyframe at which the camera was found"},
    SummaryKey{"focal_error_percent", "error of the focal length found, %"},
    SummaryKey{"focal_error_sigmas", "error of the focal length found over its sigma", Better::neither},
    SummaryKey{"position_mean_percent", "mean position error, % of distance"},
    SummaryKey{"position_max_percent", "largest position error, % of distance"},
    SummaryKey{"position_rigid_mean_percent", "mean position error without scale alignment, % of distance"},
    SummaryKey{"rotation_mean_deg", "mean rotation error, degrees"},
    SummaryKey{"rotation_max_deg", "largest rotation error, degrees"},
    SummaryKey{"drift_percent", "drift to the far end, % of distance"},
    SummaryKey{"scale_drift_percent", "scale drift over the strip, %"},
    SummaryKey{"bow_percent", "bow of the heights, % of flying height"},
    SummaryKey{"sigma1_share", "share of position errors within 1 sigma", Better::nearer, 0.683},
    SummaryKey{"sigma2_share", "share of position errors within 2 sigma", Better::nearer, 0.954},
    SummaryKey{"position_nes", "normalised position error squared", Better::nearer, 1},
    SummaryKey{"height_bias_percent", "height bias, % of flying height", Better::nearer, 0},
    SummaryKey{"height_median_percent", "median height error, % of flying height"},
    SummaryKey{"height_p95_percent", "95th percentile of the height error, % of flying height"},
    SummaryKey{"depth_median_percent", "median depth error, %"},
    SummaryKey{"depth_p95_percent", "95th percentile of the depth error, %"},
    SummaryKey{"completeness", "share of newly seen ground with depth", Better::higher},
    SummaryKey{"depth_sigma1_share", "share of depth errors within 1 sigma", Better::nearer, 0.683},
    SummaryKey{"depth_sigma2_share", "share of depth errors within 2 sigma", Better::nearer, 0.954},
    SummaryKey{"depth_nes", "normalised depth error squared", Better::nearer, 1},
    SummaryKey{"depth_pose_sigma1_share", "share of depth errors within 1 sigma, poses included", Better::nearer,
               0.683},
    SummaryKey{"depth_pose_sigma2_share", "share of depth errors within 2 sigma, poses included", Better::nearer,
               0.954},
    SummaryKey{"terrain_coverage", "share of all ground seen that has a height on the ground", Better::higher},
    SummaryKey{"terrain_known_share", "share of all ground seen with a height right within 0.1 % of the flying height",
               Better::higher},
    SummaryKey{"terrain_half_percent", "half of all ground seen is right within this share of the flying height, %"},
    SummaryKey{"relief_known_share", "share of all ground seen whose shape is right within 0.05 % of the flying height",
               Better::higher},
    SummaryKey{"relief_median_percent", "error of the ground's shape, median, % of flying height"},
    SummaryKey{"relief_p95_percent", "error of the ground's shape, 95 % are below, % of flying height"},
    SummaryKey{"features", "planted features flown over", Better::neither},
    SummaryKey{"feature_share", "share of planted features seen with heights and 30 dB", Better::higher},
    SummaryKey{"feature_well_share", "share of planted features seen with heights and 35 dB", Better::higher},
    SummaryKey{"feature_psnr_db", "image quality of planted features, dB", Better::higher},
    SummaryKey{"received_mb", "files that came down, MB", Better::neither},
    SummaryKey{"mask_precision", "share of the mask that is right", Better::higher},
    SummaryKey{"mask_recall", "share of new ground in the mask", Better::higher},
    SummaryKey{"double_coded_share", "share of ground coded twice"},
    SummaryKey{"overlap_true_mean", "true overlap of keyframes, mean", Better::neither},
    SummaryKey{"overlap_true_std", "true overlap of keyframes, standard deviation", Better::neither},
    SummaryKey{"overlap_error_p95", "95th percentile of the error of the stated overlap"},
    SummaryKey{"image_psnr_db", "PSNR of the images inside the mask, dB", Better::higher},
    SummaryKey{"image_bytes_per_masked_pixel", "image bytes per pixel of the mask", Better::neither},
};

}  // namespace

std::span<const SummaryKey> summary_keys() {
  return keys;
}

const SummaryKey* find_summary_key(std::string_view name) {
  const auto found = std::find_if(keys.begin(), keys.end(), [&](const SummaryKey& key) { return key.name == name; });
  return found == keys.end() ? nullptr : &*found;
}

std::string summary_key_list() {
  std::string list;
  for (const SummaryKey& key : keys) list += (list.empty() ? "" : ", ") + std::string(key.name);
  return list;
}

double worst_of(const SummaryKey& key, const std::vector<double>& values) {
  const auto badness = [&](double value) {
    if (key.better == Better::higher) return -value;
    return key.better == Better::nearer ? std::fabs(value - key.ideal) : value;
  };
  const auto worst =
      std::max_element(values.begin(), values.end(), [&](double a, double b) { return badness(a) < badness(b); });
  if (worst == values.end() || key.better == Better::neither) return std::numeric_limits<double>::quiet_NaN();
  return *worst;
}

}  // namespace ilp::batch
