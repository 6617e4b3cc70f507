#include "sim/world/flight_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "fsw/vision/geometry/camera.hpp"
#include "sim/world/parameter.hpp"

namespace ilp::world {
namespace {

constexpr double least_sine = 0.25;  // of the angle below the horizon; the renderer itself needs 0.2
constexpr double most_posts = 4e7;   // of one image: about a gigabyte

/// Unit directions along the image's border, in the camera.
std::vector<Vec3> border_directions(const CameraModel& camera) {
  constexpr int steps = 16;
  std::vector<Vec3> directions;
  const auto add = [&](double u, double v) {
    const Vec2 n = normalised_from_pixel(camera, Vec2(u - 0.5, v - 0.5));
    directions.push_back(Vec3(n.x(), n.y(), 1).normalized());
  };
  for (int k = 0; k <= steps; ++k) {
    const double u = k * camera.width / double{steps};
    const double v = k * camera.height / double{steps};
    add(u, 0);
    add(u, camera.height);
    add(0, v);
    add(camera.width, v);
  }
  return directions;
}

[[noreturn]] void refuse(std::size_t frame, const CameraState& state, const std::string& message) {
  throw std::invalid_argument("frame " + std::to_string(frame + 1) + ", at " +
                              number_text(1e-9 * static_cast<double>(state.time_ns)) + " s: " + message);
}

double rounded(double value) {
  return std::floor(100 * value + 0.5) / 100;
}

}  // namespace

void check_flight(const Terrain& terrain, const CameraModel& camera, std::span<const CameraState> states) {
  const std::vector<Vec3> border = border_directions(camera);
  for (std::size_t k = 0; k < states.size(); ++k) {
    const CameraState& state = states[k];
    const double z = state.centre.z();
    if (z <= terrain.highest()) {
      refuse(k, state,
             "the camera is at " + number_text(rounded(z)) + " m and the ground reaches up to " +
                 number_text(rounded(terrain.highest())) +
                 " m: expected a higher [flight] altitude_m, less descent or a lower [world] relief");
    }
    Vec2 low(std::numeric_limits<double>::max(), std::numeric_limits<double>::max());
    Vec2 high = -low;
    for (const Vec3& direction : border) {
      const Vec3 d = state.rotation.transpose() * direction;
      if (d.z() > -least_sine) {
        refuse(k, state,
               "the camera sees the horizon: expected a smaller [flight] off_nadir_rad or swing, or a longer [camera] "
               "focal length");
      }
      const Vec2 place = (terrain.lowest() - z) / d.z() * d.head<2>();
      low = low.cwiseMin(place);
      high = high.cwiseMax(place);
    }
    const double spacing = terrain.params().post_spacing_m;
    const double posts = (high - low).prod() / (spacing * spacing);
    if (posts > most_posts) {
      refuse(k, state,
             "the image shows " + number_text(std::floor(posts / 1e6)) +
                 " million posts of ground: expected a wider [world] post_spacing_m (and wavelengths), a lower "
                 "[flight] altitude_m or a smaller off_nadir_rad");
    }
  }
}

}  // namespace ilp::world
