#include "sim/ground/maps/map_tiles.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "fsw/localisation/sun.hpp"
#include "sim/host/key_file.hpp"
#include "sim/host/longitude.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::maps {
namespace {

constexpr double radians = std::numbers::pi / 180;
constexpr double finest_over_image = 0.5;  // pixel of the map over that of the image
constexpr double default_height_sigma_px = 0.3;

std::string body_name(Body body) {
  return body == Body::none ? "no body" : name_of(body);
}

Body common_body(const MapTilesOptions& options, const MappedRaster& image, const MappedRaster& heights) {
  const Body body = image.body();
  if (heights.body() != body) {
    throw std::runtime_error("the image shows " + body_name(body) + ", the heights are of " +
                             body_name(heights.body()) + ": both must show the same ground");
  }
  if (options.body && *options.body != body) {
    throw std::runtime_error("--body is " + body_name(*options.body) + ", but the rasters are of " + body_name(body) +
                             (body == Body::none ? ": gdal_translate -a_srs states their coordinates" : ""));
  }
  return body;
}

std::string extent_text(const Extent& extent) {
  return host::brief(extent.west) + " to " + host::brief(extent.east) + " m east, " + host::brief(extent.south) +
         " to " + host::brief(extent.north) + " m north";
}

/// The area of the options on the plane: a rectangle about its border.
Extent wanted_extent(const MapPlane& plane, const Extent& area) {
  if (plane.body == Body::none) return area;
  Extent extent{1e18, 1e18, -1e18, -1e18};
  constexpr int steps = 16;
  for (int i = 0; i <= steps; ++i) {
    const double x = area.west + (area.east - area.west) * i / steps;
    const double y = area.south + (area.north - area.south) * i / steps;
    for (const Place& edge : {Place{x, area.south}, Place{x, area.north}, Place{area.west, y}, Place{area.east, y}}) {
      const Place place = map_from_degrees(plane, edge);
      extent = {std::min(extent.west, place.x), std::min(extent.south, place.y), std::max(extent.east, place.x),
                std::max(extent.north, place.y)};
    }
  }
  return extent;
}

MapPlane plane_about(Body body, Place middle) {
  if (body == Body::none) return {};
  return {body, host::longitude_near(middle.x, 0), middle.y};
}

void check_options(const MapTilesOptions& options) {
  if (!(options.pixel_m > 0)) throw std::runtime_error("--pixel must be above 0 m");
  if (options.area && options.area->empty()) {
    throw std::runtime_error(
        "--area is empty: WEST,SOUTH,EAST,NORTH with west below east (179,-1,181,1 across 180 degrees) and south below "
        "north expected");
  }
}

void check_pixel(const MapTilesOptions& options, const MappedRaster& image) {
  const double image_m = image.pixel_m();
  if (options.pixel_m >= finest_over_image * image_m * (1 - 1e-6)) return;
  throw std::runtime_error("--pixel is " + host::brief(options.pixel_m) + " m, and the image has " +
                           host::brief(image_m) + " m per pixel: " + host::brief(finest_over_image * image_m) +
                           " m or more expected");
}

/// Where the calendar puts the sun over the middle of the map.
Sun sun_by_calendar(const char* option, double days, const MapPlane& plane, double ambient) {
  if (plane.body == Body::none) {
    throw std::runtime_error(std::string(option) +
                             ": a date gives the direction of the sun only on a known body, and the rasters name no "
                             "body. Give AZIMUTH,ELEVATION instead");
  }
  const SunPlace sun =
      sun_over(subsolar_point(plane.body, days), plane.longitude_deg * radians, plane.latitude_deg * radians);
  return sun_of(option, sun.azimuth_rad / radians, sun.elevation_rad / radians, ambient);
}

std::string sun_line(const char* what, const Sun& sun) {
  const double azimuth_deg = std::remainder(90 - sun.azimuth_rad / radians, 360);
  return std::string(what) + host::fixed(azimuth_deg < 0 ? azimuth_deg + 360 : azimuth_deg, 1) +
         " degrees clockwise from north, " + host::fixed(sun.elevation_rad / radians, 1) +
         " degrees above the horizon, by the calendar";
}

/// What the map covers.
Extent extent_of_map(const MapTilesOptions& options, const MapPlane& plane, const MappedRaster& image,
                     const MappedRaster& heights) {
  const Extent seen = image.extent(), known = heights.extent();
  Extent extent = common_part(seen, known);
  if (extent.empty()) {
    throw std::runtime_error("image and heights do not overlap: the image covers " + extent_text(seen) +
                             ", the heights " + extent_text(known) + " of the middle of the map");
  }
  if (!options.area) return extent;
  const Extent wanted = wanted_extent(plane, *options.area);
  extent = common_part(extent, wanted);
  if (extent.empty()) {
    throw std::runtime_error("--area lies beside the rasters: they cover " + extent_text(common_part(seen, known)) +
                             " of its middle");
  }
  return extent;
}

}  // namespace

std::vector<std::string> make_map_tiles(const MapTilesOptions& options, std::ostream& messages) {
  check_options(options);
  Sun sun;
  if (!options.sun_days) sun = sun_of("--sun", options.sun_azimuth_deg, options.sun_elevation_deg, options.ambient);
  const std::vector<std::uint8_t> key =
      options.key.empty() ? std::vector<std::uint8_t>{} : host::read_key_file(options.key).octets;
  MappedRaster image(options.image, host::RasterBand::Content::brightness);
  MappedRaster heights(options.heights, host::RasterBand::Content::heights);
  const Body body = common_body(options, image, heights);
  if (heights.band().unit() == "strip unit") {
    throw std::runtime_error(options.heights.string() +
                             ": heights in a unit of their own; metres expected (ilp-ground --anchor gives them)");
  }
  const MapPlane plane = plane_about(body, options.area ? options.area->middle() : image.middle());
  std::optional<Sun> flight_sun = options.flight_sun;
  if (options.sun_days) sun = sun_by_calendar("--sun", *options.sun_days, plane, options.ambient);
  if (options.flight_sun_days)
    flight_sun = sun_by_calendar("--flight-sun", *options.flight_sun_days, plane, options.ambient);
  image.lay_on(plane);
  heights.lay_on(plane);
  check_pixel(options, image);
  const Extent extent = extent_of_map(options, plane, image, heights);
  const auto directory = std::make_unique<MapDirectory>();
  directory->body = body;
  directory->longitude_rad = plane.longitude_deg * radians;
  directory->latitude_rad = plane.latitude_deg * radians;
  directory->sun_azimuth_rad = sun.azimuth_rad;
  directory->sun_elevation_rad = sun.elevation_rad;
  directory->ambient = sun.ambient;
  directory->image_sigma = options.image_sigma;
  directory->height_sigma_m = options.height_sigma_m.value_or(default_height_sigma_px * options.pixel_m);
  directory->place_sigma_m = options.place_sigma_m;
  set_layers(*directory, extent.west, extent.north, extent.east - extent.west, extent.north - extent.south,
             options.pixel_m, options.coarse);
  TileParams params;
  params.sun = sun;
  params.flat = options.flat;
  params.features = options.features;
  params.flight_sun = flight_sun;
  params.image_bits = options.image_bits;
  RasterPatches patches(image, heights, extent);
  const MapSummary summary = write_map(
      *directory, [&](const MapLayer& layer, const PatchArea& area) { return patches(layer, area); }, params, key,
      options.out, messages);
  std::vector<std::string> lines = lines_of(summary);
  lines.push_back((body == Body::none ? "on no body"
                                      : "on " + body_name(body) + " about " + host::fixed(plane.longitude_deg, 5) +
                                            " degrees east, " + host::fixed(plane.latitude_deg, 5) + " degrees north") +
                  "; the map as a whole may be off by " + host::brief(options.place_sigma_m) +
                  " m (one sigma, --place-sigma), its heights by " + host::brief(directory->height_sigma_m) + " m");
  if (options.sun_days) lines.push_back(sun_line("the sun of the image stood ", sun));
  if (options.flight_sun_days) lines.push_back(sun_line("the sun of the flight stands ", *flight_sun));
  return lines;
}

}  // namespace ilp::maps
