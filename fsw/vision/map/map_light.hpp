// The map's window as the camera would see it: light on its heights, and its image under another sun.
#pragma once

#include "fsw/vision/map/map_window.hpp"
#include "fsw/vision/map/map_workspace.hpp"

namespace ilp {

/// Light of a sun on the ground by Lambert's law: n s + ambient, over that of level ground. Unit vector s towards the
/// sun.
struct Lamp {
  double east = 0, north = 0, up = 1;
  double ambient = 0.25;
};
[[nodiscard]] Lamp lamp_of(const SunDirection& sun, double ambient);

/// Of the ground of a cell, from its neighbours: metres up for each metre towards east and north, and the length of the
/// normal (-to_east, -to_north, 1).
struct Slope {
  double to_east = 0, to_north = 0, normal = 1;
};
/// False where one of the neighbours is unknown.
[[nodiscard]] bool slope_of(const MapWindow& window, std::int32_t column, std::int32_t row, Slope& slope);
/// Light on a slope; level ground has 1.
[[nodiscard]] double light_on(const Slope& slope, const Lamp& lamp);

/// The difference of two directions in azimuth, 0 to pi.
[[nodiscard]] double azimuth_between(double a_rad, double b_rad);

struct MapLighting {
  Lamp now, of_image;
};

// Raw values of the window's rows [first, last) into `channels` (MapChannels), unknown_value where there are none.
/// Image / shading under the map's sun x shading under the sun now.
void relight_rows(const MapWindow& window, const MapLighting& lighting, std::int32_t first, std::int32_t last,
                  MapChannels<max_map_window_side>& channels);
/// Shading of the heights under the sun now.
void shade_rows(const MapWindow& window, const MapLighting& lighting, std::int32_t first, std::int32_t last,
                MapChannels<max_map_window_side>& channels);
/// Heights above `level_m`.
void height_rows(const MapWindow& window, double level_m, std::int32_t first, std::int32_t last,
                 MapChannels<max_map_window_side>& channels);
/// A height above the level as a raw value.
[[nodiscard]] std::int16_t raw_height(double above_m, double pixel_m);
[[nodiscard]] double height_of_raw(double raw, double pixel_m);

/// Mean of the known heights; false when none is known.
[[nodiscard]] bool mean_height(const MapWindow& window, double& mean_m);

}  // namespace ilp
