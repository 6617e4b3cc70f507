// Scores the camera that a flight has calibrated itself against the true camera, and its camera check.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "fsw/base/geometry.hpp"
#include "sim/ground/intake/flight_model.hpp"

namespace ilp::score {

/// Reads the camera of the COLMAP model in the truth's folder; empty if there is no readable model.
[[nodiscard]] std::optional<CameraModel> true_camera(const std::filesystem::path& truth);

/// Numbers for the summary of a score. NaN for a flight whose camera was known; all but `camera_calibrated` also if the
/// flight has not decided on a camera.
///   camera_calibrated     1 if the flight has calibrated its camera, 0 if not
///   calibration_keyframe  id of the keyframe at which it did
///   focal_error_percent   absolute error of fx, % of the true fx
///   focal_error_sigmas    the same error divided by the flight's sigma of the focal length
/// The largest value over the strips, for calibrated and known cameras; NaN if no strip was checked:
///   camera_alarm          1 if the images do not fit the camera, else 0
///   camera_statistic, camera_spread, camera_field   as in the record `calibration_check`
[[nodiscard]] std::map<std::string, double> calibration_summary(const intake::Flight& flight,
                                                                const std::optional<CameraModel>& truth);

}  // namespace ilp::score
