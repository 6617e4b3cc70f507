#include "sim/ground/maps/map_projection.hpp"

#include <ogr_spatialref.h>

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "fsw/shared/body_figure.hpp"
#include "sim/host/gdal_session.hpp"

namespace ilp::maps {
namespace {

constexpr double degrees = 180 / std::numbers::pi;

std::string number_text(double value) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.13g", value);
  return text.data();
}

/// The figure that the flight has, for PROJ.
std::string figure_of(Body body) {
  const BodyRadii radii = body_radii(body);
  if (!(radii.equatorial_m > 0)) throw std::runtime_error("a map on no body has no longitude and latitude");
  return "+a=" + number_text(radii.equatorial_m) + " +b=" + number_text(radii.polar_m);
}

OGRSpatialReference system_of(const std::string& definition) {
  OGRSpatialReference system;
  if (system.importFromProj4(definition.c_str()) != OGRERR_NONE) {
    throw host::gdal_error("GDAL does not know the coordinate system " + definition);
  }
  system.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return system;
}

using Transformation = std::unique_ptr<OGRCoordinateTransformation>;

Transformation transformation(const OGRSpatialReference& from, const OGRSpatialReference& to) {
  Transformation made(OGRCreateCoordinateTransformation(&from, &to));
  if (!made) throw host::gdal_error("coordinates cannot be converted");
  return made;
}

std::optional<Place> transformed(OGRCoordinateTransformation& transformation, Place place) {
  int good = 0;
  if (transformation.Transform(1, &place.x, &place.y, nullptr, &good) == FALSE || good == 0) return std::nullopt;
  if (!std::isfinite(place.x) || !std::isfinite(place.y)) return std::nullopt;
  return place;
}

bool stands_on_a_body(const OGRSpatialReference* system) {
  return system != nullptr && (system->IsProjected() != 0 || system->IsGeographic() != 0);
}

/// The map's projection and the longitudes and latitudes below it.
struct MapSystems {
  OGRSpatialReference plane, degrees_below;

  explicit MapSystems(const MapPlane& map)
      : plane(system_of("+proj=tmerc +lat_0=" + number_text(map.latitude_deg) +
                        " +lon_0=" + number_text(map.longitude_deg) + " +k=1 +x_0=0 +y_0=0 " + figure_of(map.body) +
                        " +units=m +no_defs")),
        degrees_below(system_of("+proj=longlat " + figure_of(map.body) + " +no_defs")) {}
};

/// A raster's coordinates, and the longitudes and latitudes below them.
struct RasterSystems {
  OGRSpatialReference own, degrees_below;
  double squared_axes =
      1;  ///< of the ellipse through the poles, polar over equatorial; 1 where latitudes stay as they are

  explicit RasterSystems(const OGRSpatialReference& system) : own(system) {
    own.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const std::unique_ptr<OGRSpatialReference> below(own.CloneGeogCS());
    if (!below) throw host::gdal_error("the raster's coordinate system has no longitude and latitude");
    degrees_below = *below;
    degrees_below.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const double ratio = system.GetSemiMinor() / system.GetSemiMajor();
    if (body_of(&system) != Body::earth) squared_axes = ratio * ratio;
  }
  [[nodiscard]] double planetocentric(double latitude_deg) const {
    return std::atan(squared_axes * std::tan(latitude_deg / degrees)) * degrees;
  }
  [[nodiscard]] double own_latitude(double planetocentric_deg) const {
    return std::atan(std::tan(planetocentric_deg / degrees) / squared_axes) * degrees;
  }
};

}  // namespace

Body body_of(const OGRSpatialReference* system) {
  if (!stands_on_a_body(system)) return Body::none;
  const double radius_m = system->GetSemiMajor();
  for (const EnumValue& value : values_of(Body{})) {
    const auto body = static_cast<Body>(value.number);
    if (std::fabs(radius_m / body_radii(body).equatorial_m - 1) < 0.01) return body;
  }
  throw std::runtime_error("its coordinate system is of a body of " + number_text(radius_m) +
                           " m radius; mars, titan, venus, moon or earth expected");
}

struct RasterFromMap::Systems {
  std::optional<RasterSystems> raster;
  Transformation degrees_from_map, map_from_degrees, raster_from_degrees, degrees_from_raster;
  bool in_degrees = false;
};

RasterFromMap::RasterFromMap(const MapPlane& plane, const OGRSpatialReference* system)
    : systems_(std::make_unique<Systems>()) {
  const Body body = body_of(system);
  if (body != plane.body) {
    throw std::runtime_error(std::string("its coordinate system is of ") +
                             (body == Body::none ? "no body" : name_of(body)) + ", that of the map of " +
                             (plane.body == Body::none ? "no body" : name_of(plane.body)));
  }
  if (body == Body::none) return;
  const MapSystems map(plane);
  Systems& s = *systems_;
  s.raster.emplace(*system);
  s.in_degrees = system->IsGeographic() != 0;
  s.degrees_from_map = transformation(map.plane, map.degrees_below);
  s.map_from_degrees = transformation(map.degrees_below, map.plane);
  if (s.in_degrees) return;
  s.raster_from_degrees = transformation(s.raster->degrees_below, s.raster->own);
  s.degrees_from_raster = transformation(s.raster->own, s.raster->degrees_below);
}

RasterFromMap::~RasterFromMap() = default;
RasterFromMap::RasterFromMap(RasterFromMap&&) noexcept = default;
RasterFromMap& RasterFromMap::operator=(RasterFromMap&&) noexcept = default;

std::optional<Place> RasterFromMap::operator()(Place map) const {
  const Systems& s = *systems_;
  if (!s.raster) return map;
  std::optional<Place> place = transformed(*s.degrees_from_map, map);
  if (!place) return std::nullopt;
  place->y = s.raster->own_latitude(place->y);
  return s.in_degrees ? place : transformed(*s.raster_from_degrees, *place);
}

std::optional<Place> RasterFromMap::map_from_raster(Place raster) const {
  const Systems& s = *systems_;
  if (!s.raster) return raster;
  std::optional<Place> place = s.in_degrees ? raster : transformed(*s.degrees_from_raster, raster);
  if (!place) return std::nullopt;
  place->y = s.raster->planetocentric(place->y);
  return transformed(*s.map_from_degrees, *place);
}

std::optional<Place> degrees_from_raster(const OGRSpatialReference* system, Place raster) {
  if (!stands_on_a_body(system)) return raster;
  const RasterSystems systems(*system);
  std::optional<Place> place =
      system->IsGeographic() != 0 ? raster : transformed(*transformation(systems.own, systems.degrees_below), raster);
  if (place) place->y = systems.planetocentric(place->y);
  return place;
}

Place map_from_degrees(const MapPlane& plane, Place degrees) {
  const MapSystems map(plane);
  const std::optional<Place> place = transformed(*transformation(map.degrees_below, map.plane), degrees);
  if (!place) throw std::runtime_error("a place that is not on the map's plane");
  return *place;
}

}  // namespace ilp::maps
