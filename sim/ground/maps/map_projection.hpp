// Converts between the plane of a map (map_directory.hpp) and the coordinates of the rasters that it is made from.
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

/// The body of a raster's coordinate system, recognised by the ellipsoid's equatorial radius to 1 %. Body::none for a
/// local (engineering) system, or without any. Throws std::runtime_error for the ellipsoid of another body.
[[nodiscard]] Body body_of(const OGRSpatialReference* system);

/// The map's plane: metres to the east and north of its origin. For Body::none it is the plane of the raster's own
/// coordinates in metres, with the origin at (0, 0).
struct MapPlane {
  Body body = Body::none;
  double longitude_deg = 0, latitude_deg = 0;  ///< of the origin; planetocentric, on the Earth geodetic
};

/// Converts between the map's plane and one raster's coordinates by longitude and latitude. The radius of the raster's
/// sphere may differ from the body's, as in rasters of HiRISE: longitude and latitude stay. Planetographic latitudes of
/// a raster on an ellipsoid are converted.
class RasterFromMap {
 public:
  /// Throws std::runtime_error if the raster is of another body than the map, or if PROJ has no conversion.
  RasterFromMap(const MapPlane& plane, const OGRSpatialReference* system);
  ~RasterFromMap();
  RasterFromMap(RasterFromMap&&) noexcept;
  RasterFromMap& operator=(RasterFromMap&&) noexcept;

  /// Raster coordinates of a point of the map's plane; none if it has none. A longitude may differ from the raster's
  /// range by multiples of 360 degrees.
  [[nodiscard]] std::optional<Place> operator()(Place map) const;
  [[nodiscard]] std::optional<Place> map_from_raster(Place raster) const;

 private:
  struct Systems;
  std::unique_ptr<Systems> systems_;
};

/// Longitude and latitude in degrees of a point in raster coordinates; latitude as in MapPlane. None if there are none.
[[nodiscard]] std::optional<Place> degrees_from_raster(const OGRSpatialReference* system, Place raster);
/// The point of the map's plane with this longitude (x) and latitude (y) in degrees.
[[nodiscard]] Place map_from_degrees(const MapPlane& plane, Place degrees);

}  // namespace ilp::maps
