#include "sim/world/renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/world/camera_effects.hpp"
#include "sim/world/lens.hpp"
#include "sim/world/ray_cast.hpp"
#include "sim/world/sensor.hpp"

namespace ilp::world {
namespace {

/// The farthest a ray may look from straight down: the ground in view grows without bound towards the horizon.
constexpr double least_fall = 0.05;  // cosine of 87.1 degrees
constexpr double max_posts = 1 << 26U;

/// Pixels by which level ground moves in the image during an exposure, at most.
double blur_px(const CameraEffects& effects, const CameraMotion& motion, const PixelFan& fan) {
  const CameraState before = state_after(motion, -0.5 * effects.exposure_s);
  const CameraState after = state_after(motion, 0.5 * effects.exposure_s);
  const CameraState& now = motion.state;
  double longest = 0;
  for (const double share_y : {0.0, 0.5, 1.0}) {
    for (const double share_x : {0.0, 0.5, 1.0}) {
      const Direction& n = fan.at(static_cast<std::int32_t>(share_x * (fan.camera.width - 1)),
                                  static_cast<std::int32_t>(share_y * (fan.camera.height - 1)))
                               .centre;
      const Vec3 d = now.rotation.transpose() * Vec3(n.x, n.y, 1);
      const Vec3 ground = now.centre - now.centre.z() / d.z() * d;
      const Vec3 a = before.rotation * (ground - before.centre);
      const Vec3 b = after.rotation * (ground - after.centre);
      const double dx = fan.camera.fx * (b.x() / b.z() - a.x() / a.z());
      const double dy = fan.camera.fy * (b.y() / b.z() - a.y() / a.z());
      longest = std::max(longest, std::sqrt(dx * dx + dy * dy));
    }
  }
  return longest;
}

/// When the samples of a pixel look, seconds after the middle of its row's exposure; four for each pass over the pixel.
std::vector<double> exposure_instants(const CameraEffects& effects, const CameraMotion& motion, const PixelFan& fan) {
  if (effects.exposure_s <= 0) return std::vector<double>(4, 0.0);
  // An even number of passes, each in the opposite order of samples, keeps time and place in the pixel uncorrelated.
  const int passes = 2 * static_cast<int>(std::clamp(std::ceil(0.25 * blur_px(effects, motion, fan)), 1.0, 4.0));
  std::vector<double> instants;
  for (int k = 0; k < 4 * passes; ++k) instants.push_back(effects.exposure_s * ((k + 0.5) / (4 * passes) - 0.5));
  return instants;
}

/// The sample of the pixel that belongs to the k-th instant.
std::size_t sample_at(std::size_t k) {
  const std::size_t sample = k % 4;
  return k / 4 % 2 == 0 ? sample : 3 - sample;
}

/// A camera in the units of a patch's lattice.
class LatticeCamera {
 public:
  LatticeCamera() = default;
  LatticeCamera(const CameraState& state, const SurfacePatch& patch) : world_from_cam_(state.rotation.transpose()) {
    const double scale = 1 / patch.spacing_m;
    world_from_cam_.row(0) *= scale;
    world_from_cam_.row(1) *= scale;
    origin_ =
        Vec3(state.centre.x() * scale - patch.first_i, state.centre.y() * scale - patch.first_j, state.centre.z());
  }
  /// Directions have z = 1 in the camera, so that the ray's parameter is the depth.
  [[nodiscard]] LatticeRay ray(const Direction& n) const {
    const Mat3& m = world_from_cam_;
    return {origin_.x(),
            origin_.y(),
            origin_.z(),
            m(0, 0) * n.x + m(0, 1) * n.y + m(0, 2),
            m(1, 0) * n.x + m(1, 1) * n.y + m(1, 2),
            m(2, 0) * n.x + m(2, 1) * n.y + m(2, 2)};
  }

 private:
  Mat3 world_from_cam_ = Mat3::Identity();
  Vec3 origin_ = Vec3::Zero();
};

double radiance_at(const SurfacePatch& patch, double column, double row) {
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

double checked(double t) {
  if (t < 0) throw std::logic_error("renderer: a ray missed the ground");
  return t;
}

std::string degrees(double cosine) {
  std::ostringstream text;
  text.precision(3);
  text << std::acos(std::clamp(cosine, -1.0, 1.0)) * (180 / 3.14159265358979323846) << " degrees";
  return text.str();
}

[[noreturn]] void refuse_altitude(double camera_z, double highest) {
  std::ostringstream text;
  text << "renderer: the camera is " << camera_z << " m high, inside the range of the ground's heights, which ends at "
       << highest << " m; raise the flight or lower the relief";
  throw std::runtime_error(text.str());
}

[[noreturn]] void refuse_view(double axis_cosine, double ray_cosine) {
  throw std::runtime_error(
      "renderer: the camera looks " + degrees(axis_cosine) + " off straight down and a corner of its image " +
      degrees(ray_cosine) + ", more than the " + degrees(least_fall) +
      " up to which the ground in view is bounded; tilt or swing it less, or take a narrower lens");
}

[[noreturn]] void refuse_size(double posts, const Rectangle& area, double spacing) {
  std::ostringstream text;
  text << "renderer: the ground in view, " << area.x1 - area.x0 << " m x " << area.y1 - area.y0 << " m, has " << posts
       << " posts of " << spacing << " m, more than " << max_posts
       << "; set a larger post spacing, fly lower or tilt the camera less";
  throw std::runtime_error(text.str());
}

/// Corners moved apart by what a turn of `angle` deviates from its chord, so that rays at any instant of it stay in the
/// hull of those at its ends.
std::array<Direction, 4> spread(const std::array<Direction, 4>& corners, double angle) {
  Direction centre;
  for (const Direction& n : corners) {
    centre.x += 0.25 * n.x;
    centre.y += 0.25 * n.y;
  }
  std::array<Direction, 4> result;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Direction& n = corners[k];
    const double x = n.x - centre.x;
    const double y = n.y - centre.y;
    const double factor = 0.5 * angle * angle * (1 + n.x * n.x + n.y * n.y) / std::sqrt(x * x + y * y);
    result[k] = {n.x + factor * x, n.y + factor * y};
  }
  return result;
}

/// A cloud is as bright as level ground of mean albedo.
void cover(double opacity, host::Raster<float>& depth_m, host::Raster<float>& radiance) {
  if (opacity <= 0) return;
  for (float& light : radiance.samples) light = static_cast<float>(light + opacity * (1 - light));
  if (opacity >= 1) std::fill(depth_m.samples.begin(), depth_m.samples.end(), 0.0F);
}

void resize(const CameraModel& camera, auto& image) {
  image.width = camera.width;
  image.height = camera.height;
  image.samples.resize(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
}

}  // namespace

struct Renderer::View {
  const Terrain& terrain;
  SurfacePatch patch;
  RayCaster ground;
  double pixel_rad;

  View(const Terrain& world, const Rectangle& area, double focal_px)
      : terrain(world), patch(world.patch(area)), ground(patch), pixel_rad(1 / focal_px) {}

  /// Light from where a ray ends.
  [[nodiscard]] double light(const LatticeRay& ray, double t) const {
    const double column = ray.x + t * ray.dx;
    const double row = ray.y + t * ray.dy;
    return radiance_at(patch, column, row) * terrain.detail((column + patch.first_i) * patch.spacing_m,
                                                            (row + patch.first_j) * patch.spacing_m, ray.z + t * ray.dz,
                                                            t * pixel_rad);
  }
};

Renderer::Renderer(const Terrain& terrain, const CameraModel& camera, const CameraEffects& effects, std::uint64_t seed)
    : terrain_(terrain), fan_(camera), effects_(effects), seed_(seed) {
  check_parameters(parameters(effects_), "camera");
}

Rectangle Renderer::footprint(std::span<const CameraState> states) const {
  constexpr double far = std::numeric_limits<double>::max();
  Rectangle area{far, far, -far, -far};
  for (const CameraState& state : states) {
    const Mat3 world_from_cam = state.rotation.transpose();
    const Vec3& c = state.centre;
    if (!(c.z() > terrain_.highest())) refuse_altitude(c.z(), terrain_.highest());
    double least = 1;
    for (const Direction& n : fan_.border) {
      const Vec3 d = world_from_cam * Vec3(n.x, n.y, 1);
      least = std::min(least, -d.z() / d.norm());
    }
    if (!(least > least_fall)) refuse_view(-world_from_cam(2, 2), least);
    for (const Direction& n : fan_.border) {
      const Vec3 d = world_from_cam * Vec3(n.x, n.y, 1);
      for (const double level : {terrain_.lowest(), terrain_.highest()}) {
        const double t = (level - c.z()) / d.z();
        area.x0 = std::min(area.x0, c.x() + t * d.x());
        area.x1 = std::max(area.x1, c.x() + t * d.x());
        area.y0 = std::min(area.y0, c.y() + t * d.y());
        area.y1 = std::max(area.y1, c.y() + t * d.y());
      }
    }
  }
  const double spacing = terrain_.params().post_spacing_m;
  const double margin = 2 * spacing;
  area = {area.x0 - margin, area.y0 - margin, area.x1 + margin, area.y1 + margin};
  const double posts = (area.x1 - area.x0) * (area.y1 - area.y0) / (spacing * spacing);
  if (!(posts < max_posts)) refuse_size(posts, area, spacing);
  return area;
}

void Renderer::look(const View& view, const CameraState& state, host::Raster<float>& depth_m,
                    host::Raster<float>& radiance) const {
  const LatticeCamera camera(state, view.patch);
  const bool lit = !radiance.samples.empty();
  for (const PixelTile& tile : fan_.tiles) {
    std::array<LatticeRay, 4> outer;
    for (std::size_t k = 0; k < outer.size(); ++k) outer[k] = camera.ray(tile.corners[k]);
    const HitInterval interval = view.ground.narrow(outer);
    for (std::int32_t v = tile.v0; v < tile.v1; ++v) {
      double depth = interval.far;
      for (std::int32_t u = tile.u0; u < tile.u1; ++u) {
        const PixelRays& pixel = fan_.at(u, v);
        depth = checked(view.ground.hit(camera.ray(pixel.centre), interval, depth));
        depth_m.at(u, v) = static_cast<float>(depth);
        if (!lit) continue;
        double sum = 0;
        for (const Direction& n : pixel.samples) {
          const LatticeRay ray = camera.ray(n);
          sum += view.light(ray, checked(view.ground.hit(ray, interval, depth)));
        }
        radiance.at(u, v) = static_cast<float>(0.25 * sum);
      }
    }
  }
}

void Renderer::look_while_moving(const View& view, const CameraMotion& motion, host::Raster<float>& radiance) const {
  const std::int32_t rows = fan_.camera.height;
  const std::vector<double> instants = exposure_instants(effects_, motion, fan_);
  const std::size_t count = instants.size();
  std::vector<LatticeCamera> cameras;  // for each row, at each instant
  cameras.reserve(count * static_cast<std::size_t>(rows));
  const auto camera_at = [&](double seconds) { return LatticeCamera(state_after(motion, seconds), view.patch); };
  for (std::int32_t v = 0; v < rows; ++v) {
    for (const double instant : instants) cameras.push_back(camera_at(row_time_s(effects_, v, rows) + instant));
  }
  for (const PixelTile& tile : fan_.tiles) {
    const double begin = row_time_s(effects_, tile.v0, rows) - 0.5 * effects_.exposure_s;
    const double end = row_time_s(effects_, tile.v1 - 1, rows) + 0.5 * effects_.exposure_s;
    const std::array<Direction, 4> corners = spread(tile.corners, motion.turn_rad_s.norm() * (end - begin));
    const LatticeCamera first = camera_at(begin);
    const LatticeCamera last = camera_at(end);
    std::array<LatticeRay, 8> outer;
    for (std::size_t k = 0; k < 4; ++k) {
      outer[k] = first.ray(corners[k]);
      outer[4 + k] = last.ray(corners[k]);
    }
    const HitInterval interval = view.ground.narrow(outer);
    for (std::int32_t v = tile.v0; v < tile.v1; ++v) {
      const LatticeCamera* const row = cameras.data() + static_cast<std::size_t>(v) * count;
      double depth = interval.far;
      for (std::int32_t u = tile.u0; u < tile.u1; ++u) {
        const PixelRays& pixel = fan_.at(u, v);
        double sum = 0;
        for (std::size_t k = 0; k < count; ++k) {
          const LatticeRay ray = row[k].ray(pixel.samples[sample_at(k)]);
          depth = checked(view.ground.hit(ray, interval, depth));
          sum += view.light(ray, depth);
        }
        radiance.at(u, v) = static_cast<float>(sum / static_cast<double>(count));
      }
    }
  }
}

void Renderer::cross_the_haze(const CameraState& state, const host::Raster<float>& depth_m,
                              host::Raster<float>& radiance) const {
  const Haze haze(effects_.haze, effects_.haze_scale_height_m, state.centre.z());
  const Vec3 up = state.rotation.col(2);  // the world's z axis in the camera
  for (std::size_t k = 0; k < radiance.samples.size(); ++k) {
    const Direction& n = fan_.pixels[k].centre;
    const double depth = depth_m.samples[k];
    const double z = state.centre.z() + depth * (up.x() * n.x + up.y() * n.y + up.z());
    const double path = depth * std::sqrt(n.x * n.x + n.y * n.y + 1);
    radiance.samples[k] = static_cast<float>(haze.seen(radiance.samples[k], z, path));
  }
}

void Renderer::pass_the_lens(host::Raster<float>& radiance) const {
  if (effects_.vignetting > 0) {
    const Vignetting vignetting(fan_.camera, effects_.vignetting);
    for (std::size_t k = 0; k < radiance.samples.size(); ++k) {
      radiance.samples[k] = static_cast<float>(radiance.samples[k] * vignetting.share(fan_.pixels[k].centre));
    }
  }
  if (effects_.psf_sigma_px > 0) blur(radiance, effects_.psf_sigma_px);
}

void Renderer::render(const CameraMotion& motion, std::int64_t frame_index, RenderedFrame& out) const {
  const double span_s = effects_.readout_s + effects_.exposure_s;
  const bool moving = span_s > 0 && (motion.velocity_m_s.norm() > 0 || motion.turn_rad_s.norm() > 0);
  std::vector<CameraState> states{motion.state};
  if (moving) {
    for (const double share : {-0.5, -0.25, 0.25, 0.5}) states.push_back(state_after(motion, share * span_s));
  }
  const View view(terrain_, footprint(states), fan_.camera.fx);
  host::Raster<float> radiance;
  resize(fan_.camera, out.depth_m);
  resize(fan_.camera, out.grey);
  if (moving) look(view, motion.state, out.depth_m, radiance);
  resize(fan_.camera, radiance);
  if (moving) {
    look_while_moving(view, motion, radiance);
  } else {
    look(view, motion.state, out.depth_m, radiance);
  }
  if (effects_.haze > 0) cross_the_haze(motion.state, out.depth_m, radiance);
  cover(cloud_at(effects_, motion.state.time_ns), out.depth_m, radiance);
  pass_the_lens(radiance);
  expose(effects_, seed_, frame_index, radiance, out.grey);
}

}  // namespace ilp::world
