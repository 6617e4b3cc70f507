// Determines the georeference of a strip: its position on a body, or only its local axes.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fsw/vision/geometry/types.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/map/ground_grid.hpp"

namespace ilp::exports {

// The anchor file states the positions of strips on a body. It is a small JSON file that the operator writes:
//
//     {"body": "mars",
//      "strips": [{"strip": 1, "keyframe": 1, "longitude": 137.4, "latitude": -4.6, "height": -4400.0,
//                  "azimuth": 12.5, "metres_per_unit": 2.03}]}
//
// The file has no other members: an unknown member is an error, so that a misspelt one is noticed.

// The bodies on which a flight can be anchored, with the ellipsoids of the IAU's report of 2015
// (doi:10.1007/s10569-017-9805-5) as PROJ has them; for the Earth WGS 84.

struct Body {
  const char* key;     ///< name in the anchor file
  const char* name;    ///< for texts
  const char* crs;     ///< system of longitude (east positive) and latitude, for PROJ
  const char* figure;  ///< name of the ellipsoid, for texts
  /// Range of plausible camera heights above the ellipsoid, m.
  double lowest_m, highest_m;
};

/// The body with this key; null: none.
[[nodiscard]] const Body* find_body(std::string_view key);
/// All keys, such as "mars, titan, ...".
[[nodiscard]] std::string body_names();

/// The body in the description of a flight (`source` of the flight info: "simulated world, scenario titan-shore, seed
/// 1"); null if it names none.
[[nodiscard]] const Body* flown_body(std::string_view description);

struct StripAnchor {
  std::int64_t strip = 0;
  /// The anchored point is this keyframe's camera; none: the origin of the strip's world.
  std::optional<std::int64_t> keyframe;
  double longitude_deg = 0;  ///< of the point; east positive, -180 to 360
  double latitude_deg = 0;
  double height_m = 0;     ///< of the point above the body's ellipsoid
  double azimuth_deg = 0;  ///< azimuth of the world's +y, clockwise from north
  std::optional<double> metres_per_unit;
};

struct Anchors {
  const Body* body = nullptr;
  std::vector<StripAnchor> strips;

  [[nodiscard]] const StripAnchor* of(std::int64_t strip) const;
};

/// Reads an anchor file. Throws std::runtime_error, which names the file, the member and what is expected, if the file
/// is malformed, the body is unknown, a position is impossible on the body, or the body is not `flown` (flown_body;
/// null: unknown).
[[nodiscard]] Anchors read_anchors(const std::filesystem::path& path, const Body* flown);

/// The map coordinates of a strip: east, north and height. With an anchor they are in metres, in a transverse Mercator
/// projection with its centre and true scale at the anchor, and heights are above the body's ellipsoid. Without an
/// anchor they are the strip's own x, y, z in its own unit. A strip that control points, fixes or navigation have
/// placed on a body has an anchor too.
struct Georeference {
  std::string crs;          ///< system of east and north, WKT 2: projected on the body, or a local engineering system
  std::string geographic;   ///< system of longitude and latitude in degrees, WKT 2; empty without an anchor
  std::string unit;         ///< of all three coordinates: "metre" or "strip unit"
  std::string height_name;  ///< description of the heights with their reference surface
  std::string sentence;     ///< describes the georeference, for the report
  std::string body;         ///< key of the body; empty without an anchor
  bool earth = false;
  double longitude_deg = 0;                    ///< longitude of the map's centre
  double scale = 1;                            ///< map units per strip unit
  double sin_azimuth = 0, cos_azimuth = 1;     ///< azimuth of the world's +y, clockwise from north
  std::array<double, 3> anchored = {0, 0, 0};  ///< the anchored point in the strip's world: the map's centre
  double height = 0;                           ///< height of the anchored point
  /// Horizontal standard deviations per axis: of the strip's position (on the orbiter's map, if it is placed on one),
  /// and of that map's position on the body. None: unknown.
  std::optional<double> place_sigma_m, map_sigma_m;
  bool by_map = false;  ///< the strip is placed on an orbiter's map

  [[nodiscard]] bool on_a_body() const { return !geographic.empty(); }
  /// Horizontal standard deviation per axis of the position on the body, from both errors; none if one is unknown.
  [[nodiscard]] std::optional<double> whole_sigma_m() const;
  [[nodiscard]] bool in_metres() const { return unit == "metre"; }
  /// The system for a GeoTIFF. Empty for strip units: GeoTIFF has no such unit, and readers would assume metres.
  [[nodiscard]] std::string raster_crs() const { return in_metres() ? crs : std::string(); }
  /// Unit vector to the north in the strip's world, x and y; none: unknown.
  [[nodiscard]] std::optional<std::array<double, 2>> north() const {
    return on_a_body() ? std::optional(std::array{-sin_azimuth, cos_azimuth}) : std::nullopt;
  }
  [[nodiscard]] Vec3 map_from_world(const Vec3& world) const;
  [[nodiscard]] double height_of(double z) const { return height + scale * (z - anchored[2]); }
};

/// The georeference of a strip, from its entry in `anchors` (may be null), else from what has placed the strip on a
/// body. If there is neither, or the entry names a keyframe whose pose has not come, the georeference is local, and its
/// sentence says so. Throws std::runtime_error if an entry contradicts the strip: metres_per_unit is missing although
/// the strip is not in metres, or given although it is.
[[nodiscard]] Georeference georeference_of(const intake::Flight& flight, const intake::Strip& strip,
                                           const Anchors* anchors);

/// GDAL's six geotransform coefficients, from column and row to map coordinates; (0, 0) is the outer corner of the
/// first cell.
[[nodiscard]] std::array<double, 6> geotransform(const Georeference& place, const map::MapGeometry& map);

/// Converts map coordinates to longitude and latitude in degrees. Longitudes are continuous across 180 degrees. Only
/// for a georeference on a body.
class GeographicFromMap {
 public:
  explicit GeographicFromMap(const Georeference& place);
  ~GeographicFromMap();
  GeographicFromMap(const GeographicFromMap&) = delete;
  GeographicFromMap& operator=(const GeographicFromMap&) = delete;
  /// Throws std::runtime_error if the point is not on the body.
  [[nodiscard]] std::array<double, 2> operator()(double east, double north) const;

 private:
  void* transformation_ = nullptr;
  double centre_deg_ = 0;
};

}  // namespace ilp::exports
