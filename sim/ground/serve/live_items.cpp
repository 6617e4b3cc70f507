#include "sim/ground/serve/live_items.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "sim/ground/report/json_parts.hpp"

namespace ilp::serve {
namespace {

using nlohmann::json;

json six(double value) {
  if (!std::isfinite(value)) return nullptr;
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", value);
  return std::strtod(text, nullptr);
}

json seconds_of(TimeNs time) {
  return six(static_cast<double>(time) / 1e9);
}

json product_item(const intake::Keyframe& keyframe, ProductKind kind) {
  const std::optional<intake::ProductAccount>& account = keyframe.product(kind);
  const std::optional<ProductRecord>& record = keyframe.product_records[static_cast<std::size_t>(kind)];
  if (!account && !record) return nullptr;
  return {account ? account->bytes : 0, account ? account->layers : 0, record ? json(record->layers) : json()};
}

json keyframe_item(const intake::Keyframe& k) {
  json out = {{"s", k.strip_id},
              {"n", k.name},
              {"v", report::keyframe_verdict(k)},
              {"i", product_item(k, ProductKind::image)},
              {"d", product_item(k, ProductKind::depth)}};
  if (k.record) out["t"] = seconds_of(k.record->time_ns);
  if (k.record && k.record->index > 0) out["o"] = six(k.record->overlap);
  if (k.richness) out["r"] = six(k.richness->richness);
  if (k.posed()) {
    out["c"] = {six(k.pose->centre[0]), six(k.pose->centre[1]), six(k.pose->centre[2])};
    out["e"] = six(k.pose->rms_px);
  }
  return out;
}

json strip_item(const report::Report& report, const report::StripResult& strip, const PageBudget& budget,
                Pictures& pictures) {
  json out = {{"unit", intake::unit_of(report.flight, strip.strip)},
              {"keyframes", strip.strip.keyframes.size()},
              {"posed", strip.posed},
              {"length", six(strip.track_length)},
              {"height", six(strip.flying_height)},
              {"place", strip.place}};
  if (const auto north = strip.georeference.north()) out["north"] = *north;
  if (strip.grid) out["map"] = map_item(strip, budget.picture_side_px, pictures);
  return out;
}

json summary_item(const report::Report& report) {
  const report::ReportTotals sums = report::totals(report);
  return {{"title", report.title},
          {"keyframes", sums.keyframes},
          {"posed", sums.posed},
          {"with_depth", sums.with_depth},
          {"strips", report.strips.size()},
          {"products", sums.products},
          {"product_bytes", sums.product_bytes},
          {"received_bytes", sums.received_bytes},
          {"files_used", sums.files_used},
          {"files_skipped", sums.files_skipped},
          {"events", report.flight.events.size()},
          {"medium", sums.events_medium},
          {"high", sums.events_high},
          {"missing", report.missing.size()},
          {"target_overlap", six(report.target_overlap)},
          {"viewer", report.has_viewer}};
}

// The newest, when there are too many.
void add_events(const std::vector<EventRecord>& events, std::size_t most, Items& items) {
  for (std::size_t i = events.size() > most ? events.size() - most : 0; i < events.size(); ++i) {
    items["e/" + std::to_string(events[i].id)] = report::event_json(events[i]);
  }
}

void add_telemetry(const intake::Flight& flight, Items& items) {
  if (flight.storage) items["storage"] = report::storage_json(flight);
  if (flight.timing) items["timing"] = report::timing_json(flight);
  for (const ComponentRecord& c : flight.components) items["c/" + std::to_string(c.id)] = report::component_json(c);
}

json missing_item(const std::vector<intake::Missing>& missing, std::size_t most) {
  json list = json::array();
  for (std::size_t i = 0; i < std::min(missing.size(), most); ++i) {
    list.push_back({missing[i].keyframe_id, missing[i].what});
  }
  return {{"all", missing.size()}, {"list", list}};
}

// The pictures of keyframes have names that follow from their numbers, and would be most of the list.
json listed_files(const std::set<std::string>& files) {
  json list = json::array();
  for (const std::string& file : files) {
    if (!file.starts_with("keyframes/")) list.push_back(file);
  }
  return list;
}

}  // namespace

Items live_items(const report::Report& report, const std::set<std::string>& files, Pictures& pictures,
                 const PageBudget& budget) {
  Items items;
  items["summary"] = summary_item(report);
  for (const auto& [id, keyframe] : report.flight.keyframes) {
    items["k/" + std::to_string(id)] = keyframe_item(keyframe);
  }
  for (const report::StripResult& strip : report.strips) {
    items["strip/" + std::to_string(strip.strip.id)] = strip_item(report, strip, budget, pictures);
  }
  add_events(report.flight.events, budget.events, items);
  add_telemetry(report.flight, items);
  items["missing"] = missing_item(report.missing, budget.missing);
  items["files"] = listed_files(files);
  return items;
}

}  // namespace ilp::serve
