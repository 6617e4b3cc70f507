#include "sim/ground/serve/live_items.hpp"

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

namespace ilp::serve {
namespace {

using Json = nlohmann::ordered_json;

Json nine_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.9g", value);
  return std::strtod(text, nullptr);
}

Json report_json(const report::Report& report) {
  std::stringstream text;
  report::write_report_json(report, text, report::JsonStyle::compact);
  return Json::parse(text, [](int, Json::parse_event_t, Json& value) {
    if (value.is_number_float()) value = nine_digits(value.get<double>());
    return true;
  });
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
  for (const report::StripResult& strip : report.strips) {
    Json map = strip.grid ? map_item(strip, pictures) : Json::object();
    if (const auto north = strip.georeference.north()) map["north"] = *north;
    map["strip"] = strip.strip.id;
    items["map/" + std::to_string(strip.strip.id)] = map;
  }
  items["results"] = listed_files(files);
  return items;
}

}  // namespace ilp::serve
