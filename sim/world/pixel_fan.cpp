#include "sim/world/pixel_fan.hpp"

#include <algorithm>
#include <stdexcept>

#include "fsw/vision/geometry/camera.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::world {

PixelFan::PixelFan(const CameraModel& model) : camera(model) {
  const Status status = validate(camera);
  if (!status.ok()) throw std::invalid_argument("renderer: " + host::describe(status));
  const auto direction = [&](double u, double v) {
    const Vec2 n = normalised_from_pixel(camera, Vec2(u, v));
    return Direction{n.x(), n.y()};
  };
  constexpr double off = 0.25;
  pixels.reserve(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
  for (std::int32_t v = 0; v < camera.height; ++v) {
    for (std::int32_t u = 0; u < camera.width; ++u) {
      pixels.push_back({direction(u, v),
                        {direction(u - off, v - off), direction(u + off, v - off), direction(u - off, v + off),
                         direction(u + off, v + off)}});
    }
  }
  for (std::int32_t v0 = 0; v0 < camera.height; v0 += tile_side) {
    for (std::int32_t u0 = 0; u0 < camera.width; u0 += tile_side) {
      const std::int32_t u1 = std::min(u0 + tile_side, camera.width);
      const std::int32_t v1 = std::min(v0 + tile_side, camera.height);
      tiles.push_back({u0,
                       v0,
                       u1,
                       v1,
                       {direction(u0 - 0.5, v0 - 0.5), direction(u1 - 0.5, v0 - 0.5), direction(u0 - 0.5, v1 - 0.5),
                        direction(u1 - 0.5, v1 - 0.5)}});
    }
  }
  for (std::int32_t u = 0; u <= camera.width; ++u) {
    border.push_back(direction(u - 0.5, -0.5));
    border.push_back(direction(u - 0.5, camera.height - 0.5));
  }
  for (std::int32_t v = 0; v <= camera.height; ++v) {
    border.push_back(direction(-0.5, v - 0.5));
    border.push_back(direction(camera.width - 0.5, v - 0.5));
  }
}

}  // namespace ilp::world
