#include "sim/ground/fixes/fix_text.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "sim/host/text_format.hpp"

namespace ilp::fixes {
namespace {

using Json = nlohmann::ordered_json;

template <typename Word>
Json counts_json(const std::map<Word, std::size_t>& counts) {
  Json json = Json::object();
  for (const auto& [word, count] : counts) json[name_of(word)] = count;
  return json;
}

Json number(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json plan_json(const std::vector<Vec3>& track) {
  Json json = Json::array();
  for (const Vec3& centre : track) json.push_back({centre.x(), centre.y()});
  return json;
}

Json distances_json(const host::ErrorSummary& distances) {
  if (distances.count == 0) return nullptr;
  return {{"count", distances.count}, {"median", distances.median}, {"largest", distances.max}};
}

Json keyframe_json(const KeyframeFix& one) {
  const FixRecord& fix = one.fix;
  Json json = {{"keyframe", fix.id},
               {"verdict", name_of(fix.verdict)},
               {"state", name_of(fix.state)},
               {"prior", name_of(fix.prior)},
               {"map", fix.map_id == 0 ? Json(nullptr) : Json(map_name(fix.map_id))}};
  if (was_registered(fix)) {
    json.update({{"sense", name_of(fix.sense)},
                 {"pixel_m", fix.pixel_m},
                 {"search_px", fix.search_px},
                 {"evidence", fix.evidence},
                 {"patches", fix.patches},
                 {"votes", fix.votes},
                 {"shift_px", fix.shift_px},
                 {"shift_sigmas", fix.shift_sigmas},
                 {"residual_px", fix.residual_px}});
  }
  if (fix.verdict == MapVerdict::fixed) {
    const ErrorEllipse ellipse = ellipse_of(fix);
    json.update({{"ground_m", fix.ground_m},
                 {"longitude_deg", fix.body == Body::none ? Json(nullptr) : Json(fix.longitude_deg)},
                 {"latitude_deg", fix.body == Body::none ? Json(nullptr) : Json(fix.latitude_deg)},
                 {"ground_covariance_m2", fix.ground_covariance},
                 {"sigma_major_m", ellipse.major_m},
                 {"sigma_minor_m", ellipse.minor_m},
                 {"centre_m", fix.centre_m},
                 {"q_cam_from_map", fix.q_cam_from_map},
                 {"off_by_vehicle_m", number(one.off_by_vehicle_m)},
                 {"off_by_first_fixes_m", number(one.off_by_first_m)},
                 {"off_by_first_fixes_sigma_m", one.off_by_first_sigma_m},
                 {"off_by_all_fixes_m", number(one.off_by_all_m)}});
  }
  if (fix.place_sigma_m > 0) json.update({{"place_m", fix.place_m}, {"place_sigma_m", fix.place_sigma_m}});
  return json;
}

std::string residuals(const char* of_what, const host::ErrorSummary& distances) {
  return std::string("residuals of ") + of_what + ": median " + host::brief(distances.median) + " m, largest " +
         host::brief(distances.max) + " m";
}

/// "3 no_agreement (too few patches of the keyframe agree on one place)"
std::string reasons(const FixSummary& summary) {
  std::string text;
  for (const auto& [verdict, count] : summary.verdicts) {
    if (verdict == MapVerdict::fixed) continue;
    text +=
        (text.empty() ? "" : "; ") + std::to_string(count) + " " + name_of(verdict) + " (" + words_of(verdict) + ")";
  }
  return text;
}

std::string maps_of(const FixSummary& summary) {
  std::set<std::int64_t> ids;
  for (const StripFixes& strip : summary.strips) {
    for (const KeyframeFix& one : strip.keyframes) ids.insert(one.fix.map_id);
  }
  std::string text;
  for (const std::int64_t id : ids) {
    if (id != 0) text += (text.empty() ? "map " : ", map ") + map_name(id);
  }
  return text;
}

}  // namespace

std::string map_name(std::int64_t map_id) {
  std::ostringstream text;
  text << std::hex << static_cast<std::uint64_t>(map_id);
  return text.str();
}

std::vector<std::string> lines_of(const FixSummary& summary) {
  std::vector<std::string> lines;
  if (summary.empty()) return lines;
  const std::string maps = maps_of(summary);
  std::string first = std::to_string(summary.fixed) + " of " + host::counted(summary.keyframes, "keyframe") +
                      " fixed on " + (maps.empty() ? "a map" : maps) + ", " + std::to_string(summary.accepted) +
                      " of them accepted";
  for (const auto& [sense, count] : summary.senses) first += ", " + std::to_string(count) + " by " + name_of(sense);
  lines.push_back(first);
  if (maps.empty())
    lines.emplace_back("No map could be used in the flight: see the events map_refused, map_other_body");
  if (const std::string why = reasons(summary); !why.empty()) lines.push_back("Without a fix: " + why);
  for (const StripFixes& strip : summary.strips) {
    const std::string name = "Strip " + std::to_string(strip.strip_id) + ": ";
    if (strip.off_by_vehicle.count > 0)
      lines.push_back(name + residuals("the fixes, placed by the vehicle alone", strip.off_by_vehicle));
    if (strip.off_by_first.count > 0)
      lines.push_back(name + residuals("later fixes, placed by the first fixes and the images", strip.off_by_first));
    if (strip.off_by_all.count > 0)
      lines.push_back(name + residuals("the fixes, placed by all of them", strip.off_by_all));
  }
  return lines;
}

std::vector<std::string> lines_of(const model::JoinedFlight& joined) {
  std::vector<std::string> lines;
  for (const model::JoinedModel& one : joined.models) {
    if (!one.on_map) continue;
    const model::OnMap& on_map = *one.on_map;
    std::string wrong;
    for (const model::OnMap::Fix& fix : on_map.fixes) {
      if (!fix.used)
        wrong +=
            (wrong.empty() ? "" : ", ") + std::to_string(fix.keyframe_id) + " (" + host::brief(fix.sigmas) + " sigmas)";
    }
    lines.push_back("One model of " + host::counted(one.strips.size(), "strip") + " is placed on map " +
                    map_name(on_map.map.map_id) + ": " + std::to_string(on_map.used) + " of " +
                    std::to_string(on_map.fixes.size()) + " fixes agree" +
                    (wrong.empty() ? "" : "; the fixes of these keyframes contradict them and are not used: " + wrong));
    lines.push_back("Adjusted to each fix, the cameras moved by a median of " + host::brief(on_map.removed_m.median) +
                    " m, at most " + host::brief(on_map.removed_m.max) +
                    " m, from the placement of each strip as a rigid body");
    if (on_map.map.place_sigma_m > 0) {
      lines.push_back("Position error of its cameras on the map: " + host::brief(on_map.map.place_sigma_m) +
                      " m (one sigma per axis)" +
                      (on_map.map.map_sigma_m > 0
                           ? "; of the map on the body: " + host::brief(on_map.map.map_sigma_m) + " m, common to all"
                           : ""));
    }
    if (on_map.error_factor > 1.5)
      lines.push_back("The errors of its fixes are " + host::brief(on_map.error_factor) +
                      " times their estimated errors, and their weights are reduced accordingly");
    if (on_map.image_factor > 1.5)
      lines.push_back("The images bend the model " + host::brief(on_map.image_factor) +
                      " times as much as estimated; the fixes have corrected this");
  }
  return lines;
}

Json json_of(const FixSummary& summary) {
  Json strips = Json::array();
  for (const StripFixes& strip : summary.strips) {
    Json keyframes = Json::array();
    for (const KeyframeFix& one : strip.keyframes) keyframes.push_back(keyframe_json(one));
    strips.push_back({{"strip", strip.strip_id},
                      {"map", strip.map_id == 0 ? Json(nullptr) : Json(map_name(strip.map_id))},
                      {"map_sigma_m", strip.map_sigma_m},
                      {"registered", strip.registered},
                      {"fixed", strip.fixed},
                      {"accepted", strip.accepted},
                      {"off_by_vehicle_m", distances_json(strip.off_by_vehicle)},
                      {"off_by_first_fixes_m", distances_json(strip.off_by_first)},
                      {"off_by_all_fixes_m", distances_json(strip.off_by_all)},
                      {"tracks_m",
                       {{"by_vehicle", plan_json(strip.track_by_vehicle)},
                        {"by_first_fixes", plan_json(strip.track_by_first)},
                        {"by_all_fixes", plan_json(strip.track_by_all)}}},
                      {"keyframes", keyframes}});
  }
  return {{"keyframes", summary.keyframes},
          {"registered", summary.registered},
          {"fixed", summary.fixed},
          {"accepted", summary.accepted},
          {"verdicts", counts_json(summary.verdicts)},
          {"senses", counts_json(summary.senses)},
          {"strips", strips}};
}

}  // namespace ilp::fixes
