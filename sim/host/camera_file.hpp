// Camera files of other programs: COLMAP's cameras.txt, and YAML of OpenCV, ROS and Kalibr.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <string>

#include "fsw/base/geometry.hpp"

namespace ilp::host {

/// The camera of a file, whose content says which kind it is:
///   COLMAP   see colmap.hpp
///   OpenCV   camera_matrix, distortion_coefficients (none, 4, 5 or 8; up to 14 where the others are 0), image_width,
///            image_height; a fisheye has distortion_model: fisheye (or equidistant) or fisheye_model: 1. ROS writes
///            the same names.
///   Kalibr   a camchain of one camera: camera_model: pinhole, distortion_model: none, radtan or equidistant,
///            distortion_coeffs, intrinsics, resolution
/// The image may be larger than the flight takes: it is reduced with its camera before it flies.
/// std::runtime_error names what is wrong and what was expected. A build without libyaml refuses YAML.
[[nodiscard]] CameraModel read_camera_file(const std::filesystem::path& path);

/// The same for programs that take images as they are: std::runtime_error for a camera with a rolling shutter, and for
/// images that are larger than the flight takes.
[[nodiscard]] CameraModel read_global_shutter_camera(const std::filesystem::path& path);

/// The same lens before images of this size; a line of `messages` tells where it is another one than the file's.
/// std::runtime_error, which begins with `images`, where the shape is another one, so that they are cut or turned.
[[nodiscard]] CameraModel camera_for_size(const CameraModel& camera, std::int32_t width, std::int32_t height,
                                          const std::string& images, std::ostream& messages);

}  // namespace ilp::host
