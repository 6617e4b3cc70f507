// Reads a COLMAP text model whose images share one camera.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp::lab {

struct ColmapImage {
  std::string name;
  RigidTransform cam_from_world;
  std::map<std::int64_t, Vec2> seen;  ///< id of a 3D point to its px, pixel centres at integers
};

struct ColmapModel {
  CameraModel camera;
  std::vector<ColmapImage> images;
  std::map<std::int64_t, Vec3> points;  ///< by id
};

/// Reads cameras.txt, images.txt and points3D.txt of the folder. Throws std::runtime_error that names file and line,
/// and what was expected; also for an image with another camera than the first one of the file.
[[nodiscard]] ColmapModel read_colmap_model(const std::filesystem::path& folder);

/// Finds the image with the name `file`, or else with the same file name without folders. Throws std::runtime_error if
/// there is none.
[[nodiscard]] const ColmapImage& find_image(const ColmapModel& model, const std::string& file);

}  // namespace ilp::lab
