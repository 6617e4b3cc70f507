// The camera that a flight found by itself against the true one.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "fsw/base/geometry.hpp"
#include "sim/ground/intake/flight_model.hpp"

namespace ilp::score {

/// The camera of the truth's COLMAP model; nothing if the folder has no model that can be read.
[[nodiscard]] std::optional<CameraModel> true_camera(const std::filesystem::path& truth);

/// Numbers of the summary; NaN for a flight whose camera was known, and what concerns the answer where there is none.
///   camera_calibrated     1 when the flight found its camera, 0 when it did not
///   calibration_keyframe  at which it did
///   focal_error_percent   of the true focal length, absolute
///   focal_error_sigmas    the same error over the stated one
/// Of the strip with the largest value, whether the camera was known or not:
///   camera_alarm          1 when the images do not fit the camera
///   camera_statistic, camera_spread, camera_field   as in the record `calibration_check`
[[nodiscard]] std::map<std::string, double> calibration_summary(const intake::Flight& flight,
                                                                const std::optional<CameraModel>& truth);

}  // namespace ilp::score
