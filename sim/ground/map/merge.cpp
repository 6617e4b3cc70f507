#include "sim/ground/map/merge.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp::map {
namespace {

class PieceBuilder {
 public:
  PieceBuilder(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters, const MergeParams& params)
      : keyframe_(keyframe), rasters_(rasters), params_(params) {}

  SurfaceMesh build(const host::Raster<Ray>& rays) {
    add_vertices(rays);
    for (std::int32_t y = 0; y + 1 < index_.height; ++y) {
      for (std::int32_t x = 0; x + 1 < index_.width; ++x) add_cell(x, y);
    }
    mesh_.faces.shrink_to_fit();
    return std::move(mesh_);
  }

 private:
  void add_vertices(const host::Raster<Ray>& rays) {
    const host::Raster<float>& inverse = rasters_.inverse_depth;
    const bool coloured = rasters_.image.same_size(inverse.width, inverse.height);
    const Pose pose = pose_of(*keyframe_.pose);
    const Mat3 world_from_cam = rotation_from_quaternion(pose.q_cam_from_world).transpose();
    const Vec3 centre(pose.centre[0], pose.centre[1], pose.centre[2]);
    index_ = host::Raster<std::uint32_t>(inverse.width, inverse.height, no_vertex);
    mesh_.vertices.reserve(static_cast<std::size_t>(
        std::count_if(inverse.samples.begin(), inverse.samples.end(), [](float d) { return d > 0; })));
    for (std::int32_t y = 0; y < index_.height; ++y) {
      for (std::int32_t x = 0; x < index_.width; ++x) {
        const double d = inverse.at(x, y);
        if (!(d > 0)) continue;
        const Ray& ray = rays.at(x, y);
        const Vec3 from_camera = world_from_cam * Vec3(ray.x / d, ray.y / d, 1 / d);
        const Vec3 point = centre + from_camera;
        const double sigma = std::fabs(from_camera.z()) * intake::inverse_depth_sigma(rasters_, x, y) / d;
        index_.at(x, y) = static_cast<std::uint32_t>(mesh_.vertices.size());
        mesh_.vertices.push_back({static_cast<float>(point.x()), static_cast<float>(point.y()),
                                  static_cast<float>(point.z()), coloured ? rasters_.image.at(x, y) : std::uint8_t{128},
                                  static_cast<float>(sigma)});
      }
    }
  }

  [[nodiscard]] double depth(std::int32_t x, std::int32_t y) const { return 1.0 / rasters_.inverse_depth.at(x, y); }

  void add_triangle(const std::array<std::array<std::int32_t, 2>, 3>& corners) {
    double nearest = 0, farthest = 0;
    std::array<std::uint32_t, 3> face{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [x, y] = corners[i];
      face[i] = index_.at(x, y);
      if (face[i] == no_vertex) return;
      const double z = depth(x, y);
      nearest = i == 0 ? z : std::min(nearest, z);
      farthest = i == 0 ? z : std::max(farthest, z);
    }
    const double spacing = nearest / keyframe_.camera.fx;
    if (farthest - nearest <= params_.max_depth_jump * spacing) mesh_.faces.push_back(face);
  }

  void add_cell(std::int32_t x, std::int32_t y) {
    add_triangle({{{x, y}, {x, y + 1}, {x + 1, y}}});
    add_triangle({{{x + 1, y}, {x, y + 1}, {x + 1, y + 1}}});
  }

  const intake::Keyframe& keyframe_;
  const intake::KeyframeRasters& rasters_;
  const MergeParams& params_;
  host::Raster<std::uint32_t> index_;
  SurfaceMesh mesh_;
};

}  // namespace

bool has_surface(const intake::Keyframe& keyframe) {
  if (!keyframe.posed() || !(keyframe.camera.fx > 0) || !keyframe.has_depth()) return false;
  const std::int32_t width = keyframe.camera.width, height = keyframe.camera.height;
  if (keyframe.inverse_depth.empty()) return keyframe.mask_width == width && keyframe.mask_height == height;
  return keyframe.inverse_depth.same_size(width, height);
}

SurfaceMesh keyframe_surface(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters,
                             const MergeParams& params, PixelRays& rays) {
  if (!rasters.inverse_depth.same_size(keyframe.camera.width, keyframe.camera.height)) return {};
  return PieceBuilder(keyframe, rasters, params).build(rays.of(keyframe.camera));
}

}  // namespace ilp::map
