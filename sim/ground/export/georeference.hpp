// Where the world of a strip is: on a body, or only in its own axes.
#pragma once

#include <array>
#include <string>

#include "fsw/vision/geometry/types.hpp"
#include "sim/ground/export/anchor.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/map/mosaic.hpp"

namespace ilp::exports {

/// Map coordinates are east, north and height. With an anchor they are metres in a transverse Mercator projection with
/// its centre and true scale at the anchor, heights counting from where the anchor's height does; without one, the
/// strip's own x, y, z in its own unit.
struct Georeference {
  std::string crs;          ///< of east and north, WKT 2: projected on the body, or a local engineering system
  std::string geographic;   ///< of longitude and latitude in degrees, WKT 2; empty without an anchor
  std::string unit;         ///< of all three: "metre" or "strip unit"
  std::string height_name;  ///< what heights count from
  std::string sentence;     ///< for the report
  bool earth = false;
  double longitude_deg = 0;                    ///< of the map's centre
  double scale = 1;                            ///< map units per strip unit
  double sin_azimuth = 0, cos_azimuth = 1;     ///< of the world's +y, clockwise from north
  std::array<double, 3> anchored = {0, 0, 0};  ///< the point of the strip's world at the map's centre
  double height = 0;                           ///< of that point

  [[nodiscard]] bool on_a_body() const { return !geographic.empty(); }
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
