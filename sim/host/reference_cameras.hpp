// Reference poses in text files: what a strip's images are compared with, and how a simulated flight states its truth.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/types.hpp"

namespace ilp::host {

/// x_cam = cam_from_world * (X_world - centre). The camera's pixel centres are integers; the format has no distortion.
struct ReferenceCamera {
  std::string name;  ///< of the image file
  CameraModel camera;
  Mat3 cam_from_world = Mat3::Identity();
  Vec3 centre = Vec3::Zero();  ///< in the file's world unit
};

/// A line per image: `name width height fx fy cx cy r11 r12 r13 r21 ... r33 Cx Cy Cz`, `#` begins a comment.
/// std::runtime_error names the line and what is wrong: too few or too many words, a word that is no finite number, a
/// size or focal length that is not positive, a matrix that is no rotation, a name that stands twice, no camera at all.
std::vector<ReferenceCamera> read_reference_cameras(const std::filesystem::path& path);

/// Numbers are written so that reading gives back the same bits. `title` becomes the first comment line.
/// std::runtime_error for a name that the format cannot hold (empty, blanks, beginning with `#`).
void write_reference_cameras(const std::filesystem::path& path, const std::string& title,
                             const std::vector<ReferenceCamera>& cameras);

}  // namespace ilp::host
