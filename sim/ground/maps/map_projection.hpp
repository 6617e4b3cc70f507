// From the coordinates of a map (map_directory.hpp) to those of the rasters that it is made from.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "cfg/choices.hpp"

class OGRSpatialReference;
class OGRCoordinateTransformation;

namespace ilp::maps {

struct Place {
  double x = 0, y = 0;
};

/// The body whose figure a raster's coordinates stand on: by the length of its equatorial radius, to a hundredth. Body
/// none for coordinates that stand on no body: engineering systems, or no system at all.
/// std::runtime_error for the figure of another body.
[[nodiscard]] Body body_of(const OGRSpatialReference* system);

/// The map's plane: metres to the east and north of the origin. On no body it is the plane of the raster's own
/// coordinates, in metres, with the origin at (0, 0).
struct MapPlane {
  Body body = Body::none;
  double longitude_deg = 0, latitude_deg = 0;  ///< of the origin; planetocentric, but on the Earth
};

/// Between the map's plane and one raster's coordinates. Longitude and latitude are the same on both sides: a body's
/// sphere of another radius, as rasters of HiRISE have it, moves nothing. Latitudes on an ellipsoid are planetographic
/// and are converted.
class RasterFromMap {
 public:
  /// std::runtime_error if the raster stands on another body than the map, or PROJ cannot do it.
  RasterFromMap(const MapPlane& plane, const OGRSpatialReference* system);
  ~RasterFromMap();
  RasterFromMap(RasterFromMap&&) noexcept;
  RasterFromMap& operator=(RasterFromMap&&) noexcept;

  /// None where the place has no coordinates in the raster. Longitudes may be whole turns away from the raster's.
  [[nodiscard]] std::optional<Place> operator()(Place map) const;
  [[nodiscard]] std::optional<Place> map_from_raster(Place raster) const;

 private:
  struct Systems;
  std::unique_ptr<Systems> systems_;
};

/// Longitude and latitude of a raster's place, in degrees, as MapPlane has them.
[[nodiscard]] std::optional<Place> degrees_from_raster(const OGRSpatialReference* system, Place raster);
/// The map's place of a longitude and latitude in degrees.
[[nodiscard]] Place map_from_degrees(const MapPlane& plane, Place degrees);

}  // namespace ilp::maps
