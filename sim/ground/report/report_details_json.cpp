#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/ground/report/accuracy_summary.hpp"
#include "sim/ground/report/json_parts.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::report {
namespace {

using Json = nlohmann::ordered_json;

double seconds(std::int64_t time_ns) {
  return 1e-9 * static_cast<double>(time_ns);
}

}  // namespace

Json estimated_errors_json(const Report& report) {
  std::vector<double> positions, heights;
  std::string parts;
  for (const StripResult& strip : report.strips) {
    if (!(strip.flying_height > 0)) continue;
    for (const std::int64_t id : strip.strip.keyframes) {
      const intake::Keyframe& keyframe = report.flight.keyframes.at(id);
      if (!keyframe.posed()) continue;
      const double sigma = *std::max_element(std::begin(keyframe.pose->sigma), std::end(keyframe.pose->sigma));
      if (std::isfinite(sigma)) positions.push_back(100 * sigma / strip.flying_height);
    }
    if (!strip.grid) continue;
    for (const float sigma : strip.grid->estimated_sigma().samples) {
      if (std::isfinite(sigma)) heights.push_back(100 * sigma / strip.flying_height);
    }
    if (parts.empty()) parts = parts_text(strip.usual_errors, 100 / strip.flying_height);
  }
  Json json = {{"position_percent", nullptr}, {"height_percent", nullptr}};
  if (!positions.empty()) {
    json["position_percent"] = {{"median", host::percentile(positions, 0.5)}, {"max", host::percentile(positions, 1)}};
  }
  if (!heights.empty()) {
    json["height_percent"] = {
        {"median", host::percentile(heights, 0.5)}, {"p95", host::percentile(heights, 0.95)}, {"parts", parts}};
  }
  return json;
}

Json housekeeping_json(const intake::Flight& flight) {
  Json all = Json::array();
  for (const intake::HousekeepingReport& report : flight.housekeeping) {
    const StorageRecord& s = report.storage;
    all.push_back({{"frame_bytes", s.frame_bytes},
                   {"depth_bytes", s.depth_bytes},
                   {"product_bytes", s.product_bytes},
                   {"database_bytes", s.database_bytes},
                   {"database_free_bytes", s.database_free_bytes},
                   {"busy_s", seconds(report.busy_ns)}});
  }
  return all;
}

Json storage_json(const intake::Flight& flight) {
  if (!flight.storage) return nullptr;
  const StorageRecord& s = *flight.storage;
  return {{"frame_bytes", s.frame_bytes},           {"depth_bytes", s.depth_bytes},
          {"structure_bytes", s.structure_bytes},   {"product_bytes", s.product_bytes},
          {"database_bytes", s.database_bytes},     {"budget_bytes", s.budget_bytes},
          {"products_held", s.products_held},       {"products_acknowledged", s.products_acknowledged},
          {"products_dropped", s.products_dropped}, {"layers_cut", s.layers_cut},
          {"frames_skipped", s.frames_skipped},     {"times_full", s.times_full}};
}

Json timing_json(const intake::Flight& flight) {
  if (!flight.timing) return nullptr;
  const TimingRecord& t = *flight.timing;
  return {{"frames", t.frames},
          {"overruns", t.overruns},
          {"longest_s", seconds(t.longest_ns)},
          {"latest_s", seconds(t.latest_ns)},
          {"degraded_changes", t.degraded_changes},
          {"late", t.late},
          {"length", t.used}};
}

}  // namespace ilp::report
