#include "sim/ground/serve/live_items.hpp"

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sim/ground/report/map_pictures.hpp"
#include "sim/host/digest.hpp"

namespace ilp::serve {
namespace {

using Json = nlohmann::ordered_json;

/// Numbers with nine digits.
Json parsed(const std::string& text) {
  return Json::parse(text, [](int, Json::parse_event_t, Json& value) {
    char digits[32];
    if (!value.is_number_float()) return true;
    std::snprintf(digits, sizeof(digits), "%.9g", value.get<double>());
    value = std::strtod(digits, nullptr);
    return true;
  });
}

Json report_json(const report::Report& report) {
  std::stringstream text;
  report::write_report_json(report, text, report::JsonStyle::compact);
  return parsed(text.str());
}

void put(const std::string& name, const Json& value, Items& items) {
  const bool objects = value.is_array() && !value.empty() && value.front().is_object();
  items[name] = objects ? Json::array() : value;
  if (!objects) return;
  for (std::size_t i = 0; i < value.size(); ++i) {
    items[name + "/" + (value[i].contains("id") ? value[i]["id"].dump() : std::to_string(i))] = value[i];
  }
}

// The pictures of keyframes have names that follow from their numbers, and would be most of the list.
Json listed_files(const std::set<std::string>& files) {
  Json list = Json::array();
  for (const std::string& file : files) {
    if (!file.starts_with("keyframes/")) list.push_back(file);
  }
  return list;
}

// The path carries the content's digest, so that a browser keeps a picture until it changes.
std::string keep(const std::string& name, const std::vector<std::uint8_t>& png, Pictures& pictures) {
  const std::string_view bytes(reinterpret_cast<const char*>(png.data()), png.size());
  std::string path = "/map/" + name + "-" + host::digest_text(host::digest(bytes)) + ".png";
  pictures[path] = std::make_shared<const std::vector<std::uint8_t>>(png);
  return path;
}

}  // namespace

Items live_items(const report::Report& report, const std::set<std::string>& files, Pictures& pictures) {
  Json all = report_json(report);
  Json faulty = Json::array();
  for (const Json& file : all["files"]) {
    if (!file["fault"].is_null()) faulty.push_back(file);
  }
  all["files"] = faulty;
  Items items;
  for (const auto& [key, value] : all.items()) put(key, value, items);
  if (all["captures"].is_object()) {
    put("captures/list", all["captures"]["list"], items);
    items["captures"]["list"] = Json::array();
    items.erase("captures/list");
  }
  report::map_figures(
      report, [&](const std::string& name, const auto& png) { return keep(name, png, pictures); },
      [&](const std::string& name, const Json& figure) { items["figures/" + name] = parsed(figure.dump()); });
  items["results"] = listed_files(files);
  return items;
}

}  // namespace ilp::serve
