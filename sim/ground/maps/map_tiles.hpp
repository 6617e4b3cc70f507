// ilp-ground map-tiles: an orbiter's orthoimage and terrain model become the map that a flight carries.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/maps/map_writer.hpp"
#include "sim/ground/maps/raster_pieces.hpp"

namespace ilp::maps {

struct MapTilesOptions {
  std::filesystem::path image, heights;  ///< rasters of one band that GDAL reads
  double sun_azimuth_deg = 0;            ///< of the image, clockwise from north
  double sun_elevation_deg = 0;
  std::optional<Sun> flight_sun;
  double pixel_m = 0;
  int coarse = 4;                        ///< pixel of the second layer over that of the first; 1: one layer
  std::optional<Body> body;              ///< none: that of the rasters
  std::optional<Extent> area;            ///< degrees; on no body metres. None: what both rasters cover
  double ambient = 0.25;                 ///< share of the light on level ground that comes from the whole sky
  double image_sigma = 2;                ///< grey levels
  std::optional<double> height_sigma_m;  ///< none: 0.3 px
  double place_sigma_m = 0;
  bool flat = true;  ///< divide the image by its shading
  std::size_t features = 64;
  double image_bits = 0.5;
  std::filesystem::path key;  ///< empty: not signed
  std::filesystem::path out;
};

/// std::runtime_error says what is wrong with the rasters or the options, and what to do. The lines are for people.
std::vector<std::string> make_map_tiles(const MapTilesOptions& options, std::ostream& messages);

}  // namespace ilp::maps
