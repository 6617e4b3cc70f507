// Reads and writes reference poses of images as text: for the comparison of recorded strips, and for the truth of
// simulated flights.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/types.hpp"

namespace ilp::host {

/// Pose and intrinsics of an image: x_cam = cam_from_world * (X_world - centre). Pixel centres are integers; the format
/// has no distortion.
struct ReferenceCamera {
  std::string name;  ///< image file
  CameraModel camera;
  Mat3 cam_from_world = Mat3::Identity();
  Vec3 centre = Vec3::Zero();  ///< in the file's world unit
};

/// Reads a line per image: `name width height fx fy cx cy r11 r12 r13 r21 ... r33 Cx Cy Cz`; `#` begins a comment.
/// Throws std::runtime_error that names the line if it has too few or too many words, a number that is not finite, a
/// size or focal length that is not positive, a matrix that is no rotation (to 0.001) or a repeated name. Throws also
/// for a file without cameras.
std::vector<ReferenceCamera> read_reference_cameras(const std::filesystem::path& path);

/// Writes the same format. Numbers read back as the same bits. `title` becomes the first comment line. Throws
/// std::runtime_error for a name that is empty, contains blanks or begins with `#`.
void write_reference_cameras(const std::filesystem::path& path, const std::string& title,
                             const std::vector<ReferenceCamera>& cameras);

}  // namespace ilp::host
