#include "sim/world/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "fsw/base/rng.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "sim/io/status_error.hpp"
#include "sim/world/ray_cast.hpp"

namespace ilp::sim {
namespace {

constexpr double offsets[5][2] = {{-0.25, -0.25}, {0.25, -0.25}, {-0.25, 0.25}, {0.25, 0.25}, {0, 0}};

/// Sum of four uniform numbers, mean 0, variance 1: close to normal, and the same on every machine.
double unit_noise(std::uint64_t bits) {
  const std::uint64_t sum = (bits & 0xFFFFU) + ((bits >> 16U) & 0xFFFFU) + ((bits >> 32U) & 0xFFFFU) + (bits >> 48U);
  constexpr double sqrt3 = 1.73205080756887729353;
  return (static_cast<double>(sum) * (1.0 / 65536.0) - 2) * sqrt3;
}

double radiance_at(const SurfacePatch& patch, double x, double y) {
  const double scale = 1 / patch.spacing_m;
  const double column = x * scale - patch.first_i;
  const double row = y * scale - patch.first_j;
  const std::int32_t i = std::clamp(static_cast<std::int32_t>(column), 0, patch.columns - 2);
  const std::int32_t j = std::clamp(static_cast<std::int32_t>(row), 0, patch.rows - 2);
  const double u = column - i;
  const double v = row - j;
  const float* const a = patch.radiance.data() + patch.index(i, j);
  const float* const b = a + patch.columns;
  const double near = a[0] + (a[1] - a[0]) * u;
  const double far = b[0] + (b[1] - b[0]) * u;
  return near + (far - near) * v;
}

}  // namespace

Renderer::Renderer(const Terrain& terrain, const CameraModel& camera, const CameraEffects& effects, std::uint64_t seed)
    : terrain_(terrain), camera_(camera), effects_(effects), seed_(seed) {
  const Status status = validate(camera);
  if (!status.ok()) throw std::invalid_argument("renderer: " + describe(status));
  const auto direction = [&](double u, double v) {
    const Vec2 n = normalised_from_pixel(camera, Vec2(u, v));
    return Direction{n.x(), n.y()};
  };
  rays_.reserve(rays_per_pixel * static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      for (const auto& offset : offsets) rays_.push_back(direction(u + offset[0], v + offset[1]));
    }
  }
  for (int u = 0; u <= camera.width; ++u) {
    border_.push_back(direction(u - 0.5, -0.5));
    border_.push_back(direction(u - 0.5, camera.height - 0.5));
  }
  for (int v = 0; v <= camera.height; ++v) {
    border_.push_back(direction(-0.5, v - 0.5));
    border_.push_back(direction(camera.width - 0.5, v - 0.5));
  }
}

Rectangle Renderer::footprint(const CameraState& state) const {
  const Mat3 world_from_cam = state.rotation.transpose();
  const Vec3& c = state.centre;
  if (c.z() <= terrain_.highest()) throw std::runtime_error("renderer: the camera is not above the ground");
  constexpr double far = std::numeric_limits<double>::max();
  Rectangle area{far, far, -far, -far};
  for (const Direction& n : border_) {
    const Vec3 d = world_from_cam * Vec3(n.x, n.y, 1);
    if (d.z() > -0.2 * d.norm()) throw std::runtime_error("renderer: the camera sees the horizon");
    for (const double level : {terrain_.lowest(), terrain_.highest()}) {
      const double t = (level - c.z()) / d.z();
      area.x0 = std::min(area.x0, c.x() + t * d.x());
      area.x1 = std::max(area.x1, c.x() + t * d.x());
      area.y0 = std::min(area.y0, c.y() + t * d.y());
      area.y1 = std::max(area.y1, c.y() + t * d.y());
    }
  }
  const double margin = 2 * terrain_.params().post_spacing_m;
  return {area.x0 - margin, area.y0 - margin, area.x1 + margin, area.y1 + margin};
}

void Renderer::render(const CameraMotion& motion, std::int64_t frame_index, RenderedFrame& out) const {
  const CameraState& state = motion.state;
  const std::uint64_t noise_seed = mix64(mix64(seed_) + static_cast<std::uint64_t>(frame_index));
  const SurfacePatch patch = terrain_.patch(footprint(state));
  const RayCaster ground(patch);
  const Mat3 world_from_cam = state.rotation.transpose();
  const Vec3& c = state.centre;
  out.grey = Image<std::uint8_t>(camera_.width, camera_.height);
  out.depth_m = Image<float>(camera_.width, camera_.height);
  const auto depth_along = [&](const Vec3& direction) {
    const double t = ground.hit(c, direction);
    if (t < 0) throw std::logic_error("renderer: a ray missed the ground");
    return t;
  };
  // Directions have z = 1 in the camera, so that the ray's parameter is the depth.
  for (std::size_t pixel = 0; pixel < out.grey.pixels.size(); ++pixel) {
    const Direction* const rays = rays_.data() + pixel * rays_per_pixel;
    double radiance = 0;
    for (std::size_t k = 0; k + 1 < rays_per_pixel; ++k) {
      const Vec3 d = world_from_cam * Vec3(rays[k].x, rays[k].y, 1);
      const double t = depth_along(d);
      const double x = c.x() + t * d.x();
      const double y = c.y() + t * d.y();
      radiance += 0.25 * radiance_at(patch, x, y) * terrain_.detail(x, y, t / camera_.fx);
    }
    const Direction& centre = rays[rays_per_pixel - 1];
    out.depth_m.pixels[pixel] = static_cast<float>(depth_along(world_from_cam * Vec3(centre.x, centre.y, 1)));
    const double noise = effects_.read_noise_grey * unit_noise(mix64(noise_seed ^ pixel));
    const double grey = 255 * radiance / (radiance + 1) + noise;
    out.grey.pixels[pixel] = static_cast<std::uint8_t>(std::clamp(std::floor(grey + 0.5), 0.0, 255.0));
  }
}

}  // namespace ilp::sim
