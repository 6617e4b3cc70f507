// Reads and writes COLMAP's cameras.txt, and writes its images.txt and points3D.txt.
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

/// Reads the only camera of a file: SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV,
/// OPENCV_FISHEYE, RADIAL_FISHEYE or SIMPLE_RADIAL_FISHEYE. The principal point is converted from COLMAP's pixel
/// centres (0.5) to integers. A comment "# readout_s 0.03" gives the camera a rolling shutter. The image may be larger
/// than the flight takes. Throws std::runtime_error that names the wrong line and what was expected; also for several
/// cameras, and for one that flight software would refuse (focal length, distortion that folds over, view angle).
CameraModel read_colmap_camera(const std::filesystem::path& path);
/// The line of a camera with its end of line: "1 PINHOLE 640 480 550 550 320 240". Its model is the simplest of
/// PINHOLE, OPENCV, FULL_OPENCV and OPENCV_FISHEYE that holds all parameters.
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
  std::vector<std::pair<std::int64_t, std::size_t>> track;  ///< id of a view, index in its `seen`
};

/// A model whose views all have camera 1. The id of a point is its index + 1.
struct ColmapText {
  std::vector<ColmapView> views;
  std::vector<ColmapPoint> points;
};

/// Writes images.txt and points3D.txt. Throws std::runtime_error if a file cannot be written.
void write_colmap_text(const ColmapText& model, const std::filesystem::path& folder);

}  // namespace ilp::host
