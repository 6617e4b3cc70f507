#include "sim/ground/export/track_export.hpp"

#include "sim/ground/export/flight_tables.hpp"
#include "sim/ground/intake/flight_model.hpp"

namespace ilp::exports {
namespace {

std::string title_of(const char* what, const intake::Strip& strip) {
  return what + (" of strip " + std::to_string(strip.id));
}

}  // namespace

bool write_track(const intake::Flight& flight, const intake::Strip& strip, const Georeference& place,
                 const std::string& suffix, const std::filesystem::path& folder) {
  const std::vector<intake::TrackPoint> track = intake::track_of(flight, strip);
  if (track.empty()) return false;
  Table table{keyframe_columns(), {}};
  std::vector<Shape> shapes;
  if (track.size() > 1) {
    Shape& way = shapes.emplace_back(Shape{ShapeKind::line, {}});
    for (const intake::TrackPoint& point : track) way.points.push_back(point.centre);
    table.rows.emplace_back(table.columns.size())[1] = strip.id;
  }
  for (const intake::TrackPoint& point : track) {
    table.rows.push_back(keyframe_row(flight.keyframes.at(point.keyframe_id), place.scale));
    shapes.push_back({ShapeKind::point, {point.centre}});
  }
  write_geojson(table, shapes, place, title_of("Track", strip), folder / ("track" + suffix + ".geojson"));
  return true;
}

bool write_footprints(const intake::Flight& flight, const intake::Strip& strip,
                      const std::map<std::int64_t, std::vector<Vec3>>& outlines, const Georeference& place,
                      const std::string& suffix, const std::filesystem::path& folder) {
  Table table{keyframe_columns(), {}};
  std::vector<Shape> shapes;
  for (const std::int64_t id : strip.keyframes) {
    const auto outline = outlines.find(id);
    if (outline == outlines.end() || outline->second.size() < 3) continue;
    table.rows.push_back(keyframe_row(flight.keyframes.at(id), place.scale));
    shapes.push_back({ShapeKind::polygon, outline->second});
  }
  if (shapes.empty()) return false;
  write_geojson(table, shapes, place, title_of("Footprints of the images", strip),
                folder / ("footprints" + suffix + ".geojson"));
  return true;
}

}  // namespace ilp::exports
