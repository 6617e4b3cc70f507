#include "sim/ground/map/merge.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp::map {
namespace {

class PatchBuilder {
 public:
  /// `laid`: inverse depths of pixels without a measured one. If there are any, only faces with such a pixel are made.
  PatchBuilder(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters, const MergeParams& params,
               const host::Raster<float>& laid)
      : keyframe_(keyframe), rasters_(rasters), params_(params), laid_(laid) {}

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
    const host::Raster<float>& counted = laid_.empty() ? inverse : laid_;
    mesh_.vertices.reserve(static_cast<std::size_t>(
        std::count_if(counted.samples.begin(), counted.samples.end(), [](float d) { return d > 0; })));
    for (std::int32_t y = 0; y < index_.height; ++y) {
      for (std::int32_t x = 0; x < index_.width; ++x) {
        const double d = inverse_at(x, y);
        if (!(d > 0) || !(laid_.empty() || beside_laid(x, y))) continue;
        const Ray& ray = rays.at(x, y);
        const Vec3 from_camera = world_from_cam * Vec3(ray.x / d, ray.y / d, 1 / d);
        const Vec3 point = centre + from_camera;
        const double sigma =
            laid_.empty() ? std::fabs(from_camera.z()) * intake::inverse_depth_sigma(rasters_, x, y) / d : 0;
        index_.at(x, y) = static_cast<std::uint32_t>(mesh_.vertices.size());
        mesh_.vertices.push_back({static_cast<float>(point.x()), static_cast<float>(point.y()),
                                  static_cast<float>(point.z()), coloured ? rasters_.image.at(x, y) : std::uint8_t{128},
                                  static_cast<float>(sigma)});
      }
    }
  }

  [[nodiscard]] bool is_laid(std::int32_t x, std::int32_t y) const { return laid_.at(x, y) > 0; }
  [[nodiscard]] double inverse_at(std::int32_t x, std::int32_t y) const {
    return !laid_.empty() && is_laid(x, y) ? laid_.at(x, y) : rasters_.inverse_depth.at(x, y);
  }
  [[nodiscard]] bool beside_laid(std::int32_t x, std::int32_t y) const {
    for (std::int32_t v = std::max(0, y - 1); v <= std::min(laid_.height - 1, y + 1); ++v) {
      for (std::int32_t u = std::max(0, x - 1); u <= std::min(laid_.width - 1, x + 1); ++u) {
        if (is_laid(u, v)) return true;
      }
    }
    return false;
  }
  [[nodiscard]] double depth(std::int32_t x, std::int32_t y) const { return 1.0 / inverse_at(x, y); }

  void add_triangle(const std::array<std::array<std::int32_t, 2>, 3>& corners) {
    double nearest = 0, farthest = 0;
    bool wanted = laid_.empty();
    std::array<std::uint32_t, 3> face{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [x, y] = corners[i];
      face[i] = index_.at(x, y);
      if (face[i] == no_vertex) return;
      wanted = wanted || is_laid(x, y);
      const double z = depth(x, y);
      nearest = i == 0 ? z : std::min(nearest, z);
      farthest = i == 0 ? z : std::max(farthest, z);
    }
    const double spacing = nearest / keyframe_.camera.fx;
    if (wanted && farthest - nearest <= params_.max_depth_jump * spacing) mesh_.faces.push_back(face);
  }

  void add_cell(std::int32_t x, std::int32_t y) {
    add_triangle({{{x, y}, {x, y + 1}, {x + 1, y}}});
    add_triangle({{{x + 1, y}, {x, y + 1}, {x + 1, y + 1}}});
  }

  const intake::Keyframe& keyframe_;
  const intake::KeyframeRasters& rasters_;
  const MergeParams& params_;
  const host::Raster<float>& laid_;
  host::Raster<std::uint32_t> index_;
  SurfaceMesh mesh_;
};

/// Inverse depths of pixels without one, between two measured pixels of both their row and their column; the nearer the
/// two are, the more they count. 0: none.
host::Raster<float> laid_inverse_depth(const host::Raster<float>& inverse) {
  host::Raster<float> sum(inverse.width, inverse.height), weight = sum;
  host::Raster<std::uint8_t> ways(inverse.width, inverse.height);
  const auto along = [&](std::int32_t length, auto index) {
    std::int32_t last = -1;
    for (std::int32_t k = 0; k < length; ++k) {
      if (!(inverse.samples[index(k)] > 0)) continue;
      const std::int32_t gap = k - last;
      if (last >= 0 && gap > 1 && gap <= most_laid_px + 1) {
        const float a = inverse.samples[index(last)], b = inverse.samples[index(k)];
        for (std::int32_t i = last + 1; i < k; ++i) {
          const float share = static_cast<float>(i - last) / static_cast<float>(gap);
          const float counts = 1 / static_cast<float>((i - last) * (k - i));
          sum.samples[index(i)] += counts * (a + share * (b - a));
          weight.samples[index(i)] += counts;
          ++ways.samples[index(i)];
        }
      }
      last = k;
    }
  };
  for (std::int32_t y = 0; y < inverse.height; ++y)
    along(inverse.width, [&](std::int32_t k) { return inverse.index(k, y); });
  for (std::int32_t x = 0; x < inverse.width; ++x)
    along(inverse.height, [&](std::int32_t k) { return inverse.index(x, k); });
  for (std::size_t i = 0; i < sum.samples.size(); ++i)
    sum.samples[i] = ways.samples[i] == 2 ? sum.samples[i] / weight.samples[i] : 0;
  return sum;
}

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
  const host::Raster<float> none;
  return PatchBuilder(keyframe, rasters, params, none).build(rays.of(keyframe.camera));
}

SurfaceMesh laid_surface(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters, PixelRays& rays) {
  const std::int32_t width = keyframe.camera.width, height = keyframe.camera.height;
  if (!rasters.inverse_depth.same_size(width, height) || !rasters.image.same_size(width, height)) return {};
  const host::Raster<float> laid = laid_inverse_depth(rasters.inverse_depth);
  if (std::all_of(laid.samples.begin(), laid.samples.end(), [](float d) { return d == 0; })) return {};
  MergeParams params;
  params.max_depth_jump = std::numeric_limits<double>::infinity();
  return PatchBuilder(keyframe, rasters, params, laid).build(rays.of(keyframe.camera));
}

}  // namespace ilp::map
