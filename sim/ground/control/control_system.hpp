// Control points from the coordinates, heights and pixels in which they were surveyed and marked.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "sim/ground/control/control_file.hpp"

namespace ilp::control {

/// How the file's numbers are meant.
struct ControlSystem {
  std::string body_crs;  ///< longitude and latitude on the body of the map, for GDAL
  std::string crs;       ///< of x and y, such as EPSG:32633; empty: what the file states
  /// Height of the geoid above the body's figure: metres, or a raster in degrees that GDAL reads
  /// (host/height_units.hpp).
  std::string geoid;
};

/// Whether x and y have a coordinate system of the Earth: the body need not be named then.
[[nodiscard]] bool is_on_earth(const ControlFile& file, const ControlSystem& system);

/// x and y with a coordinate system become longitude and latitude, and heights above the geoid heights above the
/// figure. Without either the file stays as it is. std::runtime_error for a system or a geoid that is not known, for
/// another body, and for points where the geoid's raster knows nothing.
void resolve(const ControlSystem& system, ControlFile& file);

/// Marks in photographs of which `binning` x `binning` pixels became one of the flight, which has `width` x `height`:
/// all of them become pixels of the flight where the file says so, `original` does, or a mark in an image of the flight
/// lies outside of it. `is_of_flight` says which images are. std::runtime_error names a mark that lies outside all the
/// same.
struct FlownImages {
  std::int32_t width = 0, height = 0;
  int binning = 1;
  std::function<bool(const std::string& image)> is_of_flight;
};
void fit_marks(const FlownImages& images, bool original, ControlFile& file);

}  // namespace ilp::control
