#include "sim/ground/viewer/viewer_data.hpp"

#include <map>
#include <nlohmann/json.hpp>

#include "sim/ground/fixes/fix_summary.hpp"
#include "sim/ground/report/camera_lines.hpp"

namespace ilp::viewer {
namespace {

/// By keyframe and place, the links that the model has points of.
std::map<std::pair<std::int64_t, std::int64_t>, const model::ClosedLink*> closed_links(
    const model::JoinedFlight& joined) {
  std::map<std::pair<std::int64_t, std::int64_t>, const model::ClosedLink*> closed;
  for (const model::JoinedModel& one : joined.models) {
    for (const model::ClosedLink& link : one.links) closed[{link.keyframe_id, link.place_id}] = &link;
  }
  return closed;
}

/// Of strips that stand on a map, whose coordinates are those of the fixes.
nlohmann::json viewer_fixes(const report::Report& report) {
  nlohmann::json out = nlohmann::json::array();
  for (const model::JoinedModel& one : report.joined.models) {
    const auto strip = report.flight.strips.find(one.strip_id);
    if (!one.on_map || strip == report.flight.strips.end() || !strip->second.map) continue;
    for (const model::OnMap::Fix& fix : one.on_map->fixes) {
      const auto& record = report.flight.keyframes.at(fix.keyframe_id).fix;
      if (!record) continue;
      const fixes::ErrorEllipse ellipse = fixes::ellipse_of(*record);
      out.push_back({{"keyframe", fix.keyframe_id},
                     {"ground", record->ground_m},
                     {"radii", {ellipse.major_m, ellipse.minor_m}},
                     {"direction_rad", ellipse.direction_rad},
                     {"used", fix.used}});
    }
  }
  return out;
}

}  // namespace

nlohmann::json viewer_links(const report::Report& report) {
  const auto closed = closed_links(report.joined);
  nlohmann::json out = nlohmann::json::array();
  for (const LinkRecord& link : report.flight.links) {
    nlohmann::json facts = {
        {"keyframe", link.keyframe_id}, {"place", link.place_id}, {"verdict", name_of(link.verdict)}};
    const auto in_model = closed.find({link.keyframe_id, link.place_id});
    if (in_model != closed.end() && in_model->second->points > 0) {
      facts["points"] = in_model->second->points;
      facts["error_px"] = in_model->second->after_px;
    }
    out.push_back(std::move(facts));
  }
  return out;
}

nlohmann::json viewer_data_but_keyframes(const report::Report& report, const ViewerBudget& budget) {
  using nlohmann::json;
  const report::ReportTotals sums = report::totals(report);
  json strips = json::array();
  for (const report::StripResult& strip : report.strips) strips.push_back(viewer_strip(report, strip, budget));
  json skipped = json::array();
  for (const intake::ReceivedFile& file : report.outbox.files) {
    if (!file.fault.empty()) skipped.push_back({{"name", file.name}, {"why", file.fault}});
  }
  return {{"title", report.title},
          {"target_overlap", report.target_overlap},
          {"totals",
           {{"keyframes", sums.keyframes},
            {"posed", sums.posed},
            {"with_depth", sums.with_depth},
            {"product_bytes", sums.product_bytes},
            {"received_bytes", sums.received_bytes},
            {"files", sums.files_used}}},
          {"strips", std::move(strips)},
          {"links", viewer_links(report)},
          {"fixes", viewer_fixes(report)},
          {"timeline", viewer_timeline(report, budget)},
          {"warnings", report::camera_lines(report.flight)},
          {"remarks", report.flight.remarks},
          {"skipped", std::move(skipped)}};
}

nlohmann::json viewer_data(const report::Report& report, const ViewerBudget& budget) {
  nlohmann::json data = viewer_data_but_keyframes(report, budget);
  nlohmann::json& keyframes = data["keyframes"] = nlohmann::json::array();
  for (const auto& [id, keyframe] : report.flight.keyframes) keyframes.push_back(viewer_keyframe(report, keyframe));
  return data;
}

}  // namespace ilp::viewer
