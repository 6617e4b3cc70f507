// COLMAP text files: cameras (cameras.txt), views and points (images.txt, points3D.txt).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/types.hpp"

namespace ilp::host {

/// The one camera of the file: SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV, OPENCV_FISHEYE,
/// RADIAL_FISHEYE or SIMPLE_RADIAL_FISHEYE. COLMAP's pixel centres (0.5) are turned into ours (integers).
/// std::runtime_error says which line is wrong and what was expected; several cameras, and one that flight software
/// would refuse (focal length, distortion that folds over, view angle) are refused here; the image may be larger than
/// the flight takes. A comment "# readout_s 0.03" gives the camera a rolling shutter.
CameraModel read_colmap_camera(const std::filesystem::path& path);
/// "1 PINHOLE 640 480 550 550 320 240" and the end of the line: the simplest of PINHOLE, OPENCV, FULL_OPENCV and
/// OPENCV_FISHEYE that says all.
[[nodiscard]] std::string colmap_camera_line(const CameraModel& camera);
void write_colmap_camera(const std::filesystem::path& path, const CameraModel& camera);

// Views and points of a sparse model.

struct ColmapObservation {
  double x = 0, y = 0;    ///< px, pixel centres at integers
  std::size_t point = 0;  ///< index in ColmapText::points
};

/// x_cam = R x_world + translation.
struct ColmapView {
  std::int64_t id = 0;
  std::array<double, 4> q_cam_from_world{};  ///< w x y z
  Vec3 translation = Vec3::Zero();
  std::string name;
  std::vector<ColmapObservation> seen;
};

struct ColmapPoint {
  Vec3 position = Vec3::Zero();
  std::uint8_t grey = 128;
  double error_px = 0;
  std::vector<std::pair<std::int64_t, std::size_t>> track;  ///< id of a view, index of the observation there
};

/// All views have camera 1; the id of a point is its index + 1.
struct ColmapText {
  std::vector<ColmapView> views;
  std::vector<ColmapPoint> points;
};

/// Throws std::runtime_error when a file cannot be written.
void write_colmap_text(const ColmapText& model, const std::filesystem::path& folder);

}  // namespace ilp::host
