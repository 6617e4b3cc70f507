#include "sim/ground/export/anchor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "sim/host/files.hpp"

namespace ilp::exports {
namespace {

using nlohmann::json;

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

}  // namespace

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

}  // namespace ilp::exports
