// ilp-ground map-tiles: an orbiter's orthoimage and terrain model become the map that a flight carries.
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
  double sun_azimuth_deg = 0;            ///< of the image, clockwise from north
  double sun_elevation_deg = 0;
  /// Days of UTC since 2000-01-01 12:00, when the image was taken: the sun stands where the calendar puts it over the
  /// middle of the map. None: as azimuth and elevation say.
  std::optional<double> sun_days;
  std::optional<Sun> flight_sun;          ///< none: that of the image
  std::optional<double> flight_sun_days;  ///< the same as sun_days, in place of flight_sun
  double pixel_m = 0;
  int coarse = 4;                        ///< pixel of the second layer over that of the first; 1: one layer
  std::optional<Body> body;              ///< none: that of the rasters
  std::optional<Extent> area;            ///< degrees; on no body metres. None: what both rasters cover
  double ambient = 0.25;                 ///< share of the light on level ground that comes from the whole sky
  double image_sigma = 2;                ///< grey levels
  std::optional<double> height_sigma_m;  ///< none: 0.3 px
  double place_sigma_m = 0;
  bool flat = true;  ///< divide the image by its shading
  std::size_t features = 256;
  double image_bits = 0.5;
  std::filesystem::path key;  ///< empty: not signed
  std::filesystem::path out;
};

/// std::runtime_error says what is wrong with the rasters or the options, and what to do. The lines are for people.
std::vector<std::string> make_map_tiles(const MapTilesOptions& options, std::ostream& messages);

}  // namespace ilp::maps
