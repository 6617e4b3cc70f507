#include "sim/tools/score/calibration_score.hpp"

#include <cmath>

#include "sim/host/colmap.hpp"

namespace ilp::score {

std::optional<CameraModel> true_camera(const std::filesystem::path& truth) {
  const std::filesystem::path file = truth / "colmap" / "cameras.txt";
  std::error_code error;
  if (truth.empty() || !std::filesystem::is_regular_file(file, error)) return std::nullopt;
  try {
    return host::read_colmap_camera(file);
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

std::map<std::string, double> calibration_summary(const intake::Flight& flight,
                                                  const std::optional<CameraModel>& truth) {
  std::map<std::string, double> summary = {{"camera_calibrated", unknown},   {"calibration_keyframe", unknown},
                                           {"focal_error_percent", unknown}, {"focal_error_sigmas", unknown},
                                           {"camera_alarm", unknown},        {"camera_statistic", unknown},
                                           {"camera_spread", unknown},       {"camera_field", unknown}};
  for (const auto& [strip, check] : flight.camera_checks) {
    if (check.verdict == CameraCheckVerdict::nothing_seen) continue;
    const auto raise = [&](const char* name, double value) {
      double& worst = summary[name];
      if (!(worst >= value)) worst = value;
    };
    raise("camera_alarm", check.verdict == CameraCheckVerdict::fits ? 0 : 1);
    raise("camera_statistic", check.statistic);
    raise("camera_spread", check.spread);
    raise("camera_field", check.field);
  }
  if (!flight.camera_record || flight.calibrations.empty()) return summary;
  const CameraRecord& camera = *flight.camera_record;
  const bool calibrated = camera.frozen && camera.source != CameraSource::nominal;
  summary["camera_calibrated"] = calibrated ? 1 : 0;
  if (!camera.frozen) return summary;
  if (calibrated) summary["calibration_keyframe"] = static_cast<double>(flight.calibrations.rbegin()->first);
  if (!truth) return summary;
  const double error_px = std::fabs(camera.fx - truth->fx);
  summary["focal_error_percent"] = 100 * error_px / truth->fx;
  summary["focal_error_sigmas"] = error_px / camera.sigma_focal_px;
  return summary;
}

}  // namespace ilp::score
