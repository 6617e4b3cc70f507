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
  std::map<std::int64_t, Vec2> seen;  ///< 3D point id to px, pixel centres at integers
};

struct ColmapModel {
  CameraModel camera;
  std::vector<ColmapImage> images;
  std::map<std::int64_t, Vec3> points;
};

/// cameras.txt, images.txt and points3D.txt of the folder. std::runtime_error names file and line and what was
/// expected; an image with another camera than the file's first is refused.
[[nodiscard]] ColmapModel read_colmap_model(const std::filesystem::path& folder);

/// The image whose name is `file`, or has its file name. std::runtime_error when there is none.
[[nodiscard]] const ColmapImage& find_image(const ColmapModel& model, const std::string& file);

}  // namespace ilp::lab
