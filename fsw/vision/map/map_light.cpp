#include "fsw/vision/map/map_light.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"

namespace ilp {
namespace {

constexpr double darkest = 0.15;   // of a shading that divides: what lies in shadow is not known better
constexpr double mean_grey = 128;  // of a map's image, whose light is then 1
constexpr double least_elevation_rad = 0.05;
constexpr double raw_per_pixel = 64, raw_per_grey = 16;
constexpr double highest_raw = 32000;

/// Grey as a film has it: light of 1 is in the middle, and nothing saturates.
std::int16_t raw_grey(double light) {
  return static_cast<std::int16_t>(std::floor(raw_per_grey * 255 * light / (light + 1) + 0.5));
}

std::size_t index_of(const MapWindow& window, std::int32_t column, std::int32_t row) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(window.width) + static_cast<std::size_t>(column);
}

}  // namespace

Lamp lamp_of(const SunDirection& sun, double ambient) {
  const double elevation = std::max(sun.elevation_rad, least_elevation_rad);
  const double level = det_cos(elevation);
  return {level * det_cos(sun.azimuth_rad), level * det_sin(sun.azimuth_rad), det_sin(elevation), ambient};
}

bool slope_of(const MapWindow& window, std::int32_t column, std::int32_t row, Slope& slope) {
  if (column < 1 || row < 1 || column + 1 >= window.width || row + 1 >= window.height) return false;
  const std::size_t at = index_of(window, column, row);
  const auto width = static_cast<std::size_t>(window.width);
  if (window.known[at] == 0 || window.known[at - 1] == 0 || window.known[at + 1] == 0 ||
      window.known[at - width] == 0 || window.known[at + width] == 0) {
    return false;
  }
  const float* h = window.height_m + at;
  const double per_step = 0.5 / window.pixel_m;
  slope.to_east = per_step * (static_cast<double>(h[1]) - static_cast<double>(*(h - 1)));
  slope.to_north = per_step * (static_cast<double>(*(h - width)) - static_cast<double>(h[width]));
  slope.normal = std::sqrt(1 + slope.to_east * slope.to_east + slope.to_north * slope.to_north);
  return true;
}

double light_on(const Slope& slope, const Lamp& lamp) {
  const double lit = lamp.up - slope.to_east * lamp.east - slope.to_north * lamp.north;
  return lamp.ambient + (1 - lamp.ambient) * std::max(lit, 0.0) / (lamp.up * slope.normal);
}

double azimuth_between(double a_rad, double b_rad) {
  const double difference = a_rad - b_rad;
  return std::fabs(det_atan2(det_sin(difference), det_cos(difference)));
}

void relight_rows(const MapWindow& window, const MapLighting& lighting, std::int32_t first, std::int32_t last,
                  MapChannels<max_map_window_side>& channels) {
  for (std::int32_t row = first; row < last; ++row) {
    for (std::int32_t column = 0; column < window.width; ++column) {
      const std::size_t at = index_of(window, column, row);
      std::int16_t raw = unknown_value;
      if (window.image[at] != 0) {
        double light = window.image[at] / mean_grey;
        Slope slope;
        // Without a slope the image keeps the light that it has.
        if (slope_of(window, column, row, slope)) {
          light *= std::max(light_on(slope, lighting.now), darkest);
          if (!window.image_is_flat) light /= std::max(light_on(slope, lighting.of_image), darkest);
        }
        raw = raw_grey(light);
      }
      channels.value[at] = raw;
    }
  }
}

void shade_rows(const MapWindow& window, const MapLighting& lighting, std::int32_t first, std::int32_t last,
                MapChannels<max_map_window_side>& channels) {
  for (std::int32_t row = first; row < last; ++row) {
    for (std::int32_t column = 0; column < window.width; ++column) {
      Slope slope;
      const bool known = slope_of(window, column, row, slope);
      channels.value[index_of(window, column, row)] = known ? raw_grey(light_on(slope, lighting.now)) : unknown_value;
    }
  }
}

std::int16_t raw_height(double above_m, double pixel_m) {
  return static_cast<std::int16_t>(std::clamp(raw_per_pixel * above_m / pixel_m, -highest_raw, highest_raw));
}

double height_of_raw(double raw, double pixel_m) {
  return raw * pixel_m / raw_per_pixel;
}

void height_rows(const MapWindow& window, double level_m, std::int32_t first, std::int32_t last,
                 MapChannels<max_map_window_side>& channels) {
  for (std::int32_t row = first; row < last; ++row) {
    for (std::int32_t column = 0; column < window.width; ++column) {
      const std::size_t at = index_of(window, column, row);
      channels.value[at] = window.known[at] != 0
                               ? raw_height(static_cast<double>(window.height_m[at]) - level_m, window.pixel_m)
                               : unknown_value;
    }
  }
}

bool mean_height(const MapWindow& window, double& mean_m) {
  double sum = 0;
  std::int64_t count = 0;
  const std::size_t cells = static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height);
  for (std::size_t k = 0; k < cells; ++k) {
    if (window.known[k] == 0) continue;
    sum += static_cast<double>(window.height_m[k]);
    ++count;
  }
  if (count == 0) return false;
  mean_m = sum / static_cast<double>(count);
  return true;
}

}  // namespace ilp
