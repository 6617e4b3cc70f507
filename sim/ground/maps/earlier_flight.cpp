#include "sim/ground/maps/earlier_flight.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>

#include "sim/host/files.hpp"

namespace ilp::maps {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* report_name = "report.json";

fs::path results_of(const fs::path& folder) {
  const fs::path whole = fs::absolute(folder).lexically_normal();
  const fs::path named = whole.has_filename() ? whole : whole.parent_path();
  const fs::path flight = named.filename() == "outbox" ? named.parent_path() : folder;
  std::error_code ignored;
  for (const fs::path& results : {folder, flight / "ground"}) {
    if (fs::exists(results / report_name, ignored)) return results;
  }
  throw std::runtime_error("--from " + folder.string() + ": no results of ilp-ground (" + report_name +
                           ") lie there: ilp-ground " + (flight / "outbox").string() + " --out " +
                           (flight / "ground").string() + " makes them");
}

/// The strips of report.json that have a number.
json strips_of(const fs::path& report) {
  const json all = json::parse(host::read_file(report), nullptr, false);
  json strips = json::array();
  const auto listed = all.is_object() ? all.find("strips") : all.end();
  if (!all.is_object() || listed == all.end() || !listed->is_array())
    throw std::runtime_error(report.string() + ": is no report of ilp-ground");
  for (const json& strip : *listed) {
    const bool named = strip.is_object() && strip.contains("id") && strip["id"].is_number_integer();
    if (named) strips.push_back(strip);
  }
  return strips;
}

bool has_heights(const json& strip) {
  return strip.contains("grid") && strip["grid"].is_object();
}

void add_place(const json& strip, EarlierModel& model) {
  const auto place = strip.find("place");
  if (place == strip.end() || !place->is_object()) {
    model.place = place == strip.end() ? "its report does not say it: run ilp-ground again" : "it lies on no body";
    return;
  }
  const auto text = place->find("text");
  if (text != place->end() && text->is_string()) model.place = text->get<std::string>();
  const auto sigma = place->find("whole_sigma_m");
  if (sigma == place->end() || !sigma->is_number()) return;
  const auto sigma_m = sigma->get<double>();
  if (std::isfinite(sigma_m) && sigma_m > 0) model.place_sigma_m = sigma_m;
}

}  // namespace

EarlierModel earlier_model(const fs::path& folder, std::int64_t strip) {
  const fs::path results = results_of(folder);
  const json strips = strips_of(results / report_name);
  std::string there;
  for (std::size_t i = 0; i < strips.size(); ++i) {
    const json& one = strips[i];
    if (!has_heights(one)) continue;
    const auto id = one["id"].get<std::int64_t>();
    there += (there.empty() ? "strip " : ", strip ") + std::to_string(id);
    if (strip != 0 && id != strip) continue;
    // The first strip's files have no number.
    const std::string suffix = i == 0 ? "" : "-strip-" + std::to_string(id);
    EarlierModel model{results / ("ortho" + suffix + ".tif"), results / ("height" + suffix + ".tif"), {}, {}};
    add_place(one, model);
    return model;
  }
  throw std::runtime_error(results.string() + ": " +
                           (there.empty() ? std::string("no strip has heights")
                                          : "--strip " + std::to_string(strip) + " has no heights; there is " + there));
}

}  // namespace ilp::maps
