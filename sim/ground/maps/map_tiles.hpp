// ilp-ground map-tiles: makes the map that a flight carries from an orbiter's orthoimage and terrain model.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/maps/map_writer.hpp"
#include "sim/ground/maps/raster_patches.hpp"

namespace ilp::maps {

struct MapTilesOptions {
  std::filesystem::path image, heights;  ///< rasters of one band that GDAL reads
  double sun_azimuth_deg = 0;            ///< of the sun in the image, clockwise from north
  double sun_elevation_deg = 0;          ///< of the sun in the image, above the horizon
  /// Time of the image in days of UTC since 2000-01-01 12:00. It gives the sun's direction at the middle of the map,
  /// instead of azimuth and elevation. None: not given.
  std::optional<double> sun_days;
  std::optional<Sun> flight_sun;          ///< sun during the flight; none: that of the image
  std::optional<double> flight_sun_days;  ///< time of the flight as in sun_days, instead of flight_sun
  double pixel_m = 0;                     ///< pixel size of the finest layer
  int coarse = 4;                         ///< ratio of the second layer's pixel size to the first's; 1: one layer
  std::optional<Body> body;               ///< none: that of the rasters
  std::optional<Extent> area;             ///< degrees, or metres for Body::none; none: what both rasters cover
  double ambient = 0.25;                  ///< share of the light on level ground that comes from the whole sky
  double image_sigma = 2;                 ///< standard deviation of the image's noise, grey levels (mean 128)
  std::optional<double> height_sigma_m;   ///< standard deviation of a height; none: 0.3 pixels
  double place_sigma_m = 0;               ///< horizontal sigma per axis of the map's position on the body
  bool flat = true;                       ///< divide the image by its shading
  std::size_t features = 256;             ///< features per tile
  double image_bits = 0.5;                ///< bits per pixel of the coded image
  std::filesystem::path key;              ///< empty: not signed
  std::filesystem::path out;
};

/// Makes the map, and returns lines for the user about it. Throws std::runtime_error that says what is wrong with the
/// rasters or the options, and what to do.
std::vector<std::string> make_map_tiles(const MapTilesOptions& options, std::ostream& messages);

}  // namespace ilp::maps
