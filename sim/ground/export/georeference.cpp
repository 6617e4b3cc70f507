#include "sim/ground/export/georeference.hpp"

#include <cpl_conv.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <string>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/host/files.hpp"
#include "sim/host/gdal_session.hpp"
#include "sim/host/longitude.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::exports {
using nlohmann::json;
namespace {

// The poles of Mars lie 20 km below the sphere that maps of Mars use.
constexpr std::array<Body, 5> all_bodies = {{
    {"mars", "Mars", "IAU_2015:49900", "the IAU 2015 sphere of 3 396 190 m", -25e3, 80e3},
    {"titan", "Titan", "IAU_2015:60600", "the IAU 2015 sphere of 2 575 000 m", -5e3, 200e3},
    {"venus", "Venus", "IAU_2015:29900", "the IAU 2015 sphere of 6 051 800 m", -5e3, 100e3},
    {"moon", "Moon", "IAU_2015:30100", "the IAU 2015 sphere of 1 737 400 m", -15e3, 200e3},
    {"earth", "Earth", "EPSG:4326", "the WGS 84 ellipsoid", -600, 60e3},
}};

[[noreturn]] void refuse(const std::string& what) {
  throw std::runtime_error(what);
}

std::string number_text(double value) {
  return json(value).dump();
}

// Every member of `object` is one of `names`.
template <std::size_t count>
void check_members(const json& object, const std::array<const char*, count>& names) {
  for (const auto& [key, value] : object.items()) {
    if (std::find(names.begin(), names.end(), key) != names.end()) continue;
    std::string known;
    for (const char* name : names) known += (known.empty() ? "" : ", ") + std::string(name);
    refuse("\"" + key + "\" is none of its members: " + known);
  }
}

double number(const json& object, const char* name, double least, double most, const char* unit) {
  const json& value = object.at(name);
  const double x = value.is_number() ? value.get<double>() : std::nan("");
  if (!(x >= least && x <= most)) {
    refuse(std::string(name) + " must be a number from " + number_text(least) + " to " + number_text(most) + " " +
           unit + (value.is_number() ? ", not " + number_text(x) : std::string()));
  }
  return x;
}

std::int64_t identifier(const json& object, const char* name) {
  const json& value = object.at(name);
  if (!value.is_number_integer() || value.get<std::int64_t>() < 1) {
    refuse(std::string(name) + " must be a whole number from 1");
  }
  return value.get<std::int64_t>();
}

void need(const json& object, const char* name) {
  if (!object.contains(name)) refuse(std::string(name) + " is missing");
}

StripAnchor strip_anchor(const json& entry, const Body& body) {
  if (!entry.is_object()) refuse("an entry of strips must be an object");
  check_members(entry,
                std::array{"strip", "keyframe", "longitude", "latitude", "height", "azimuth", "metres_per_unit"});
  for (const char* name : {"strip", "longitude", "latitude", "height"}) need(entry, name);
  StripAnchor anchor;
  anchor.strip = identifier(entry, "strip");
  if (entry.contains("keyframe")) anchor.keyframe = identifier(entry, "keyframe");
  anchor.longitude_deg = number(entry, "longitude", -180, 360, "degrees");
  anchor.latitude_deg = number(entry, "latitude", -90, 90, "degrees");
  const std::string above = "metres on " + std::string(body.name);
  anchor.height_m = number(entry, "height", body.lowest_m, body.highest_m, above.c_str());
  if (entry.contains("azimuth")) anchor.azimuth_deg = number(entry, "azimuth", -360, 360, "degrees");
  if (entry.contains("metres_per_unit")) anchor.metres_per_unit = number(entry, "metres_per_unit", 1e-6, 1e6, "metres");
  return anchor;
}

const Body& body_of(const json& file, const Body* flown) {
  need(file, "body");
  const json& name = file.at("body");
  const Body* body = name.is_string() ? find_body(name.get<std::string>()) : nullptr;
  if (!body) refuse("body must be one of " + body_names());
  if (flown && flown != body) {
    refuse("it anchors the flight on " + std::string(body->name) + ", but the flight was over " + flown->name);
  }
  return *body;
}

Anchors anchors_of(const json& file, const Body* flown) {
  if (!file.is_object()) refuse("it must be a JSON object");
  check_members(file, std::array{"body", "strips"});
  Anchors anchors;
  anchors.body = &body_of(file, flown);
  need(file, "strips");
  if (!file.at("strips").is_array() || file.at("strips").empty())
    refuse("strips must be a list with an entry per strip");
  for (const json& entry : file.at("strips")) {
    try {
      const StripAnchor anchor = strip_anchor(entry, *anchors.body);
      if (anchors.of(anchor.strip)) refuse("strip " + std::to_string(anchor.strip) + " has an entry before it");
      anchors.strips.push_back(anchor);
    } catch (const std::runtime_error& error) {
      refuse("entry " + std::to_string(anchors.strips.size() + 1) + " of strips: " + error.what());
    }
  }
  return anchors;
}

std::string wkt_of(const OGRSpatialReference& crs) {
  const char* const options[] = {"FORMAT=WKT2_2019", "MULTILINE=NO", nullptr};
  char* text = nullptr;
  if (crs.exportToWkt(&text, options) != OGRERR_NONE) throw host::gdal_error("a coordinate system cannot be written");
  const std::string wkt = text;
  CPLFree(text);
  return wkt;
}

OGRSpatialReference crs_of(const std::string& definition) {
  OGRSpatialReference crs;
  if (crs.SetFromUserInput(definition.c_str()) != OGRERR_NONE) {
    throw host::gdal_error("GDAL does not know the coordinate system " + definition);
  }
  crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return crs;
}

bool in_metres(const intake::Flight& flight, const intake::Strip& strip) {
  return std::strcmp(intake::unit_of(flight, strip), "m") == 0;
}

std::string local_crs(std::int64_t strip, bool metres) {
  const std::string name = "Strip " + std::to_string(strip) + ", local axes" +
                           (metres ? std::string() : ", in strip units of unknown length, not in metres");
  return "ENGCRS[\"" + name + "\",EDATUM[\"Origin of strip " + std::to_string(strip) +
         "\"],CS[Cartesian,2],AXIS[\"x\",unspecified,ORDER[1]],AXIS[\"y\",unspecified,ORDER[2]],LENGTHUNIT[\"" +
         (metres ? "metre" : "strip unit") + "\",1]]";
}

Georeference local(const intake::Flight& flight, const intake::Strip& strip, const std::string& why) {
  Georeference place;
  const bool metres = in_metres(flight, strip);
  place.unit = metres ? "metre" : "strip unit";
  place.crs = local_crs(strip.id, metres);
  place.height_name = "height, z of the strip's own axes";
  place.sentence = "strip " + std::to_string(strip.id) + " is in " +
                   (strip.control ? "the axes of its control points, in "
                    : strip.map   ? "the axes of its map, in "
                                  : "its own axes, in ") +
                   (metres ? "metres" : "units of its first baseline") + (why.empty() ? "" : ": " + why);
  return place;
}

double metres_per_unit(const StripAnchor& anchor, bool metres) {
  const std::string strip = "the anchor of strip " + std::to_string(anchor.strip);
  if (!metres && !anchor.metres_per_unit) {
    throw std::runtime_error(strip + " must say metres_per_unit: no altimeter has given the strip its scale");
  }
  if (metres && anchor.metres_per_unit.value_or(1) != 1) {
    throw std::runtime_error(
        strip + " says metres_per_unit, but the strip is in metres already, by its altimeter or its navigation");
  }
  return anchor.metres_per_unit.value_or(1);
}

std::string projected_crs(const Body& body, const StripAnchor& anchor, const OGRSpatialReference& geographic) {
  OGRSpatialReference crs;
  const std::string name =
      std::string(body.name) + ", transverse Mercator about the anchor of strip " + std::to_string(anchor.strip);
  crs.SetProjCS(name.c_str());
  if (crs.CopyGeogCSFrom(&geographic) != OGRERR_NONE ||
      crs.SetTM(anchor.latitude_deg, anchor.longitude_deg, 1, 0, 0) != OGRERR_NONE) {
    throw host::gdal_error("GDAL cannot make a projection about the anchor of strip " + std::to_string(anchor.strip));
  }
  return wkt_of(crs);
}

/// The origin of a strip that control points, a map or the vehicle have placed: its world is level and turned to north
/// already.
std::optional<StripAnchor> anchor_of(const intake::Strip& strip) {
  if (strip.control) {
    if (strip.control->body == ilp::Body::none) return std::nullopt;
    StripAnchor anchor;
    anchor.strip = strip.id;
    anchor.longitude_deg = strip.control->longitude_deg;
    anchor.latitude_deg = strip.control->latitude_deg;
    return anchor;
  }
  if (strip.map) {
    const bool on_body = strip.map->body != ilp::Body::none && std::fabs(strip.map->latitude_deg) <= 90 &&
                         std::fabs(strip.map->longitude_deg) <= 360;
    if (!on_body) return std::nullopt;
    StripAnchor anchor;
    anchor.strip = strip.id;
    anchor.longitude_deg = strip.map->longitude_deg;
    anchor.latitude_deg = strip.map->latitude_deg;
    return anchor;
  }
  if (!strip.frame || strip.frame->body == ilp::Body::none) return std::nullopt;
  const StripFrameRecord& frame = *strip.frame;
  const bool known = frame.horizontal_sigma_m > 0 && frame.heading_sigma_rad > 0 && frame.scale_sigma > 0 &&
                     std::fabs(frame.latitude_deg) <= 90 && std::fabs(frame.longitude_deg) <= 360 &&
                     std::fabs(frame.elevation_m) < 1e6;
  if (!known) return std::nullopt;
  StripAnchor anchor;
  anchor.strip = strip.id;
  anchor.longitude_deg = frame.longitude_deg;
  anchor.latitude_deg = frame.latitude_deg;
  anchor.height_m = frame.elevation_m;
  return anchor;
}

/// Who has placed the strip, and how well.
std::string placed_by(const intake::Strip& strip) {
  if (strip.control) return ", by control points";
  const auto sigma = [](double m) { return m > 0 ? host::brief(m) + " m" : std::string("unknown"); };
  if (strip.map) {
    return ", by its fixes on a map, one sigma " + sigma(strip.map->place_sigma_m) +
           ", and of the map's own place on the body " + sigma(strip.map->map_sigma_m) + ", common to all";
  }
  return ", by the vehicle's navigation, one sigma " + sigma(strip.frame->horizontal_sigma_m);
}

/// What states the strip's place states its error.
void add_errors(const intake::Strip& strip, Georeference& place) {
  const auto known = [](double sigma_m) { return sigma_m > 0 ? std::optional(sigma_m) : std::nullopt; };
  if (strip.control) return;
  place.by_map = strip.map.has_value();
  if (strip.map) place.map_sigma_m = known(strip.map->map_sigma_m);
  place.place_sigma_m = known(strip.map ? strip.map->place_sigma_m : strip.frame->horizontal_sigma_m);
}

ilp::Body body_of(const intake::Strip& strip) {
  return strip.control ? strip.control->body : strip.map ? strip.map->body : strip.frame->body;
}

std::string angle(double degrees, char positive, char negative) {
  return host::fixed(std::fabs(degrees), 5) + " " + (degrees < 0 ? negative : positive);
}

std::string anchored_sentence(const Body& body, const StripAnchor& anchor, const Georeference& place) {
  const std::string point =
      anchor.keyframe ? "the camera of keyframe " + std::to_string(*anchor.keyframe) : std::string("its origin");
  return "strip " + std::to_string(anchor.strip) + " is on " + body.name + " (" + body.figure + "): " + point + " at " +
         angle(anchor.longitude_deg, 'E', 'W') + ", " + angle(anchor.latitude_deg, 'N', 'S') + ", " +
         host::fixed(anchor.height_m, 1) + " m, +y at an azimuth of " + host::fixed(anchor.azimuth_deg, 2) +
         " degrees" + (place.scale == 1 ? "" : ", " + host::brief(place.scale) + " m per strip unit");
}

Georeference anchored(const Body& body, const StripAnchor& anchor, const Vec3& point, bool metres) {
  Georeference place;
  const OGRSpatialReference geographic = crs_of(body.crs);
  place.geographic = wkt_of(geographic);
  place.crs = projected_crs(body, anchor, geographic);
  place.unit = "metre";
  place.height_name = "height above " + std::string(body.figure);
  place.body = body.key;
  place.earth = place.body == "earth";
  place.longitude_deg = anchor.longitude_deg;
  place.scale = metres_per_unit(anchor, metres);
  const double azimuth = anchor.azimuth_deg * std::numbers::pi / 180;
  if (anchor.azimuth_deg != 0) {
    place.sin_azimuth = std::sin(azimuth);
    place.cos_azimuth = std::cos(azimuth);
  }
  place.anchored = {point.x(), point.y(), point.z()};
  place.height = anchor.height_m;
  place.sentence = anchored_sentence(body, anchor, place);
  return place;
}

}  // namespace

const Body* find_body(std::string_view key) {
  for (const Body& body : all_bodies) {
    if (key == body.key) return &body;
  }
  return nullptr;
}

std::string body_names() {
  std::string names;
  for (const Body& body : all_bodies) names += (names.empty() ? "" : ", ") + std::string(body.key);
  return names;
}

const Body* flown_body(std::string_view description) {
  constexpr std::string_view before = "scenario ";
  const std::size_t at = description.find(before);
  if (at == std::string_view::npos) return nullptr;
  const std::string_view scenario = description.substr(at + before.size());
  for (const Body& body : all_bodies) {
    if (scenario.starts_with(std::string(body.key) + "-")) return &body;
  }
  return nullptr;
}

const StripAnchor* Anchors::of(std::int64_t strip) const {
  const auto found =
      std::find_if(strips.begin(), strips.end(), [&](const StripAnchor& anchor) { return anchor.strip == strip; });
  return found == strips.end() ? nullptr : &*found;
}

Anchors read_anchors(const std::filesystem::path& path, const Body* flown) {
  const std::vector<std::uint8_t> text = host::read_file(path);
  try {
    return anchors_of(json::parse(text), flown);
  } catch (const json::exception& error) {
    refuse("anchor file " + path.string() + ": not JSON: " + error.what());
  } catch (const std::runtime_error& error) {
    refuse("anchor file " + path.string() + ": " + error.what());
  }
}

std::optional<double> Georeference::whole_sigma_m() const {
  if (!by_map || !place_sigma_m || !map_sigma_m) return by_map ? std::nullopt : place_sigma_m;
  return std::hypot(*place_sigma_m, *map_sigma_m);
}

Vec3 Georeference::map_from_world(const Vec3& world) const {
  const double x = scale * (world.x() - anchored[0]), y = scale * (world.y() - anchored[1]);
  return {cos_azimuth * x + sin_azimuth * y, cos_azimuth * y - sin_azimuth * x, height_of(world.z())};
}

Georeference georeference_of(const intake::Flight& flight, const intake::Strip& strip, const Anchors* anchors) {
  const host::GdalSession gdal;
  const StripAnchor* anchor = anchors ? anchors->of(strip.id) : nullptr;
  if (!anchor) {
    const std::optional<StripAnchor> measured = anchor_of(strip);
    if (!measured) return local(flight, strip, anchors ? "the anchor file has no entry for it" : "");
    const Body* const body = find_body(name_of(body_of(strip)));
    if (!body) return local(flight, strip, "its body is unknown");
    Georeference place = anchored(*body, *measured, Vec3(Vec3::Zero()), in_metres(flight, strip));
    place.sentence += placed_by(strip);
    add_errors(strip, place);
    return place;
  }
  Vec3 point = Vec3::Zero();
  if (anchor->keyframe) {
    const auto keyframe = flight.keyframes.find(*anchor->keyframe);
    const std::string name = "keyframe " + std::to_string(*anchor->keyframe) + ", which its anchor names, ";
    if (keyframe == flight.keyframes.end() || !keyframe->second.posed()) {
      return local(flight, strip, name + "has no pose");
    }
    if (keyframe->second.strip_id != strip.id) return local(flight, strip, name + "is of another strip");
    const PoseRecord& pose = *keyframe->second.pose;
    point = Vec3(pose.centre[0], pose.centre[1], pose.centre[2]);
  }
  return anchored(*anchors->body, *anchor, point, in_metres(flight, strip));
}

std::array<double, 6> geotransform(const Georeference& place, const map::MapGeometry& map) {
  const Vec3 corner = place.map_from_world({map.x0 - map.cell / 2, map.y0 + map.cell / 2, 0});
  const double along = place.scale * map.cell * place.cos_azimuth, across = -place.scale * map.cell * place.sin_azimuth;
  return {corner.x(), along, across, corner.y(), across, -along};
}

GeographicFromMap::GeographicFromMap(const Georeference& place) : centre_deg_(place.longitude_deg) {
  const host::GdalSession gdal;
  const OGRSpatialReference map = crs_of(place.crs), geographic = crs_of(place.geographic);
  transformation_ = OGRCreateCoordinateTransformation(&map, &geographic);
  if (!transformation_)
    throw host::gdal_error("the coordinate system of the map cannot be transformed to longitude and latitude");
}

GeographicFromMap::~GeographicFromMap() {
  OGRCoordinateTransformation::DestroyCT(static_cast<OGRCoordinateTransformation*>(transformation_));
}

std::array<double, 2> GeographicFromMap::operator()(double east, double north) const {
  const host::GdalSession gdal;
  if (!static_cast<OGRCoordinateTransformation*>(transformation_)->Transform(1, &east, &north)) {
    throw host::gdal_error("a point of the map is not on the body");
  }
  return {host::longitude_near(east, centre_deg_), north};
}

}  // namespace ilp::exports
