#include "sim/ground/maps/map_patches.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "sim/host/text_format.hpp"

namespace ilp::maps {

host::Raster<float> heights_of_cells(const host::Raster<float>& posts, std::int32_t columns, std::int32_t rows) {
  host::Raster<float> heights(columns, rows);
  for (std::int32_t y = 0; y < rows; ++y) {
    const std::int32_t j = y / map_post_spacing;
    const float v = (static_cast<float>(y % map_post_spacing) + 0.5F) / map_post_spacing;
    for (std::int32_t x = 0; x < columns; ++x) {
      const std::int32_t i = x / map_post_spacing;
      const float u = (static_cast<float>(x % map_post_spacing) + 0.5F) / map_post_spacing;
      heights.at(x, y) = (1 - v) * ((1 - u) * posts.at(i, j) + u * posts.at(i + 1, j)) +
                         v * ((1 - u) * posts.at(i, j + 1) + u * posts.at(i + 1, j + 1));
    }
  }
  return heights;
}

Sun sun_of(const char* option, double azimuth_deg, double elevation_deg, double ambient) {
  if (!std::isfinite(azimuth_deg) || !(elevation_deg > 0 && elevation_deg <= 90)) {
    throw std::runtime_error(std::string(option) + ": the sun is " + host::brief(elevation_deg) +
                             " degrees above the horizon, at an azimuth of " + host::brief(azimuth_deg) +
                             "; an elevation above 0 and at most 90 expected (AZIMUTH,ELEVATION)");
  }
  constexpr double radians = std::numbers::pi / 180;
  return {std::remainder(90 - azimuth_deg, 360) * radians, elevation_deg * radians, ambient};
}

host::Raster<float> shading_of(const host::Raster<float>& heights, double pixel_m, const Sun& sun) {
  host::Raster<float> shading(heights.width, heights.height, not_known);
  const double sx = std::cos(sun.azimuth_rad) * std::cos(sun.elevation_rad);
  const double sy = std::sin(sun.azimuth_rad) * std::cos(sun.elevation_rad), sz = std::sin(sun.elevation_rad);
  for (std::int32_t y = 0; y < heights.height; ++y) {
    const std::int32_t north = std::max(y - 1, 0), south = std::min(y + 1, heights.height - 1);
    for (std::int32_t x = 0; x < heights.width; ++x) {
      const std::int32_t west = std::max(x - 1, 0), east = std::min(x + 1, heights.width - 1);
      const double gx = double{heights.at(east, y) - heights.at(west, y)} / (pixel_m * (east - west));
      const double gy = double{heights.at(x, north) - heights.at(x, south)} / (pixel_m * (south - north));
      const double facing = (sz - gx * sx - gy * sy) / std::sqrt(1 + gx * gx + gy * gy);
      if (!std::isfinite(facing)) continue;
      shading.at(x, y) = static_cast<float>(sun.ambient + (1 - sun.ambient) * std::max(facing, 0.0) / sz);
    }
  }
  return shading;
}

void flatten(host::Raster<float>& light, const host::Raster<float>& shading) {
  for (std::size_t i = 0; i < light.samples.size(); ++i) {
    if (std::isfinite(shading.samples[i])) light.samples[i] /= std::max(shading.samples[i], least_shading);
  }
}

double roughness_of(const host::Raster<float>& light, const host::Raster<float>& shading) {
  double sum = 0;
  const auto add = [&](std::size_t here, std::size_t there) {
    const float change = light.samples[there] - light.samples[here];
    if (std::isfinite(change + shading.samples[here] + shading.samples[there])) sum += double{change} * double{change};
  };
  for (std::int32_t y = 0; y + map_post_spacing < light.height; ++y) {
    for (std::int32_t x = 0; x + map_post_spacing < light.width; ++x) {
      add(light.index(x, y), light.index(x + map_post_spacing, y));
      add(light.index(x, y), light.index(x, y + map_post_spacing));
    }
  }
  return sum;
}

}  // namespace ilp::maps
