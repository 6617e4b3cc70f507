// Computes raw values of a map's window for each sense: the image relit by another sun, shaded heights, heights.
#pragma once

#include "fsw/vision/map/map_window.hpp"
#include "fsw/vision/map/map_workspace.hpp"

namespace ilp {

/// Sunlight by Lambert's law, plus ambient light. (east, north, up) is the unit vector towards the sun; `ambient` is
/// the share of the sky in the light on level ground.
struct Lamp {
  double east = 0, north = 0, up = 1;
  double ambient = 0.25;
};
[[nodiscard]] Lamp lamp_of(const SunDirection& sun, double ambient);

/// Slope of the ground of a cell, from its neighbours: rise per metre towards east and north, and the length of the
/// normal (-to_east, -to_north, 1).
struct Slope {
  double to_east = 0, to_north = 0, normal = 1;
};
/// Returns false if the cell is at the border, or if it or a neighbour is unknown.
[[nodiscard]] bool slope_of(const MapWindow& window, std::int32_t column, std::int32_t row, Slope& slope);
/// Light on a slope relative to level ground, which has 1.
[[nodiscard]] double light_on(const Slope& slope, const Lamp& lamp);

/// The difference of two directions in azimuth, 0 to pi.
[[nodiscard]] double azimuth_between(double a_rad, double b_rad);

struct MapLighting {
  Lamp now, of_image;
};

// The next three functions write raw values (MapChannels) of the window's rows [first, last); unknown_value where
// unknown.
/// The image divided by its shading under the map's sun, times the shading under the present sun. Needs an image.
void relight_rows(const MapWindow& window, const MapLighting& lighting, std::int32_t first, std::int32_t last,
                  MapChannels<max_map_window_side>& channels);
/// Shading of the heights under the present sun.
void shade_rows(const MapWindow& window, const MapLighting& lighting, std::int32_t first, std::int32_t last,
                MapChannels<max_map_window_side>& channels);
/// Heights above `level_m`, as raw_height().
void height_rows(const MapWindow& window, double level_m, std::int32_t first, std::int32_t last,
                 MapChannels<max_map_window_side>& channels);
/// A height above the level as a raw value: sixty-fourths of a pixel, clamped.
[[nodiscard]] std::int16_t raw_height(double above_m, double pixel_m);
[[nodiscard]] double height_of_raw(double raw, double pixel_m);

/// Mean of the known heights. Returns false if no height is known.
[[nodiscard]] bool mean_height(const MapWindow& window, double& mean_m);

}  // namespace ilp
