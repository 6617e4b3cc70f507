// Reads camera files of other programs: COLMAP's cameras.txt, and YAML of OpenCV, ROS and Kalibr.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <string>

#include "fsw/base/geometry.hpp"

namespace ilp::host {

/// Reads a camera from a file. The format is recognised by content:
///   COLMAP   see colmap.hpp
///   OpenCV   camera_matrix, distortion_coefficients (none, 4, 5 or 8; up to 14 if those after the 8th are 0),
///            image_width, image_height; a fisheye has distortion_model: fisheye (or equidistant) or fisheye_model: 1.
///            ROS writes the same names.
///   Kalibr   a camchain of one camera: camera_model: pinhole, distortion_model: none, radtan or equidistant,
///            distortion_coeffs, intrinsics, resolution
/// The image may be larger than the flight takes, because images and camera are reduced before the flight. Throws
/// std::runtime_error that names what is wrong and what was expected. A build without libyaml refuses YAML.
[[nodiscard]] CameraModel read_camera_file(const std::filesystem::path& path);

/// As read_camera_file, for programs that do not reduce images. Throws std::runtime_error also for a rolling shutter,
/// and for images that are larger than the flight takes.
[[nodiscard]] CameraModel read_global_shutter_camera(const std::filesystem::path& path);

/// Scales the intrinsics to images of this size, in px. Writes a line to `messages` if the size differs from the
/// camera's. Throws std::runtime_error, whose text begins with `images`, if the aspect ratio differs: then the images
/// are cut or turned.
[[nodiscard]] CameraModel camera_for_size(const CameraModel& camera, std::int32_t width, std::int32_t height,
                                          const std::string& images, std::ostream& messages);

}  // namespace ilp::host
