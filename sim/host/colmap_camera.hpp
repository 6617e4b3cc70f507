// Camera files in COLMAP's text format (cameras.txt).
#pragma once

#include <filesystem>

#include "fsw/base/geometry.hpp"

namespace ilp::host {

/// The first camera of the file: SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL or OPENCV. COLMAP's pixel centres (0.5)
/// are turned into ours (integers). std::runtime_error says which line is wrong and what was expected; a camera that
/// flight software would refuse (size, focal length, distortion that folds over) is refused here.
CameraModel read_colmap_camera(const std::filesystem::path& path);
void write_colmap_camera(const std::filesystem::path& path, const CameraModel& camera);

}  // namespace ilp::host
