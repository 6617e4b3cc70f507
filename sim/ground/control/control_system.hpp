// Converts control points from the coordinates, heights and pixels of their file to those of the flight.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "sim/ground/control/control_file.hpp"

namespace ilp::control {

/// The coordinate systems of a file's numbers.
struct ControlSystem {
  std::string body_crs;  ///< system of longitude and latitude on the map's body, for GDAL
  std::string crs;       ///< system of x and y, such as EPSG:32633; empty: what the file states
  /// Height of the geoid above the body's ellipsoid: metres, or a raster in degrees that GDAL reads
  /// (host/height_units.hpp). Empty: heights are above the ellipsoid.
  std::string geoid;
};

/// Whether x and y have a coordinate system of the Earth. Then the body need not be given.
[[nodiscard]] bool is_on_earth(const ControlFile& file, const ControlSystem& system);

/// Converts x and y to longitude and latitude if they have a coordinate system, and heights above the geoid to heights
/// above the ellipsoid if a geoid is given. Throws std::runtime_error for an unknown system or geoid, for another body,
/// and for points without a value in the geoid's raster.
void resolve(const ControlSystem& system, ControlFile& file);

/// Size of the flight's images.
struct FlownImages {
  std::int32_t width = 0, height = 0;                          ///< px
  int binning = 1;                                             ///< side of the block of photograph pixels per pixel
  std::function<bool(const std::string& image)> is_of_flight;  ///< whether the flight has this image
};
/// Converts all marks from pixels of the original photographs to those of the flight's images, if the marks are in the
/// former: the file says so, `original` is true, or some mark in an image of the flight lies outside of it. Throws
/// std::runtime_error that names a mark outside its image after that.
void fit_marks(const FlownImages& images, bool original, ControlFile& file);

}  // namespace ilp::control
