// Where the world of a strip is: on a body, or only in its own axes.
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

// Where on a body the strips of a flight were, from a small JSON file that the operator writes:
//
//     {"body": "mars",
//      "strips": [{"strip": 1, "keyframe": 1, "longitude": 137.4, "latitude": -4.6, "height": -4400.0,
//                  "azimuth": 12.5, "metres_per_unit": 2.03}]}
//
// The file has no other members: an unknown member is an error, so that a misspelt one is noticed.

// The bodies over which a flight can be anchored, with the figures of the IAU's report of 2015
// (doi:10.1007/s10569-017-9805-5) as PROJ has them; the Earth's is WGS 84.

struct Body {
  const char* key;     ///< as the anchor file names it
  const char* name;    ///< for people
  const char* crs;     ///< of longitude (east positive) and latitude, for PROJ
  const char* figure;  ///< for people
  /// No camera of ours is lower or higher, in metres from the figure.
  double lowest_m, highest_m;
};

/// Null for a name that is none.
[[nodiscard]] const Body* find_body(std::string_view key);
/// "mars, titan, ..."
[[nodiscard]] std::string body_names();

/// The body that a flight's own description names (`source` of the flight info: "simulated world, scenario titan-shore,
/// seed 1"), null where it names none.
[[nodiscard]] const Body* flown_body(std::string_view description);

struct StripAnchor {
  std::int64_t strip = 0;
  std::optional<std::int64_t> keyframe;  ///< whose camera is meant; none: the origin of the strip's world
  double longitude_deg = 0;              ///< east positive, -180 to 360
  double latitude_deg = 0;
  double height_m = 0;     ///< of the camera or the origin, above the body's figure
  double azimuth_deg = 0;  ///< of the world's +y, clockwise from north
  std::optional<double> metres_per_unit;
};

struct Anchors {
  const Body* body = nullptr;
  std::vector<StripAnchor> strips;

  [[nodiscard]] const StripAnchor* of(std::int64_t strip) const;
};

/// Throws std::runtime_error that names the file, the member and what is expected: malformed, a body that is none, a
/// place that is none on this body, or another body than `flown` (flown_body; null: not known).
[[nodiscard]] Anchors read_anchors(const std::filesystem::path& path, const Body* flown);

/// Map coordinates are east, north and height. With an anchor they are metres in a transverse Mercator projection with
/// its centre and true scale at the anchor, heights counting from where the anchor's height does; without one, the
/// strip's own x, y, z in its own unit.
struct Georeference {
  std::string crs;          ///< of east and north, WKT 2: projected on the body, or a local engineering system
  std::string geographic;   ///< of longitude and latitude in degrees, WKT 2; empty without an anchor
  std::string unit;         ///< of all three: "metre" or "strip unit"
  std::string height_name;  ///< what heights count from
  std::string sentence;     ///< for the report
  std::string body;         ///< key of the body; empty without an anchor
  bool earth = false;
  double longitude_deg = 0;                    ///< of the map's centre
  double scale = 1;                            ///< map units per strip unit
  double sin_azimuth = 0, cos_azimuth = 1;     ///< of the world's +y, clockwise from north
  std::array<double, 3> anchored = {0, 0, 0};  ///< the point of the strip's world at the map's centre
  double height = 0;                           ///< of that point
  /// One sigma of the place on the body, to each side: of the strip, and of the map of an orbiter that it stands on,
  /// which errs as a whole. None where nothing states it.
  std::optional<double> place_sigma_m, map_sigma_m;
  bool by_map = false;  ///< it stands on such a map

  [[nodiscard]] bool on_a_body() const { return !geographic.empty(); }
  /// Both errors together; none where one of them is not known.
  [[nodiscard]] std::optional<double> whole_sigma_m() const;
  [[nodiscard]] bool in_metres() const { return unit == "metre"; }
  /// Of a GeoTIFF: empty for strip units, which it cannot name; readers would take any system to be in metres.
  [[nodiscard]] std::string raster_crs() const { return in_metres() ? crs : std::string(); }
  /// The direction of north in the strip's world, x and y; none where it is not known.
  [[nodiscard]] std::optional<std::array<double, 2>> north() const {
    return on_a_body() ? std::optional(std::array{-sin_azimuth, cos_azimuth}) : std::nullopt;
  }
  [[nodiscard]] Vec3 map_from_world(const Vec3& world) const;
  [[nodiscard]] double height_of(double z) const { return height + scale * (z - anchored[2]); }
};

/// Without anchors, or where they have no entry for the strip or name a keyframe whose pose has not come: local, and
/// the sentence says so. Throws std::runtime_error when an entry contradicts the strip: metres_per_unit is missing
/// where the strip is not in metres, or given where it is.
[[nodiscard]] Georeference georeference_of(const intake::Flight& flight, const intake::Strip& strip,
                                           const Anchors* anchors);

/// GDAL's six numbers: map coordinates from columns and rows, (0,0) the outer corner of the first cell.
[[nodiscard]] std::array<double, 6> geotransform(const Georeference& place, const map::MapGeometry& map);

/// Longitude and latitude in degrees of a point of the map; the longitude runs on through 180 degrees. Only on a body.
class GeographicFromMap {
 public:
  explicit GeographicFromMap(const Georeference& place);
  ~GeographicFromMap();
  GeographicFromMap(const GeographicFromMap&) = delete;
  GeographicFromMap& operator=(const GeographicFromMap&) = delete;
  /// Throws std::runtime_error when the point is not on the body.
  [[nodiscard]] std::array<double, 2> operator()(double east, double north) const;

 private:
  void* transformation_ = nullptr;
  double centre_deg_ = 0;
};

}  // namespace ilp::exports
