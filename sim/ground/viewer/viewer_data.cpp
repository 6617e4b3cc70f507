#include "sim/ground/viewer/viewer_data.hpp"

#include <nlohmann/json.hpp>

namespace ilp::viewer {

nlohmann::json viewer_data(const report::Report& report, const ViewerBudget& budget) {
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
          {"keyframes", viewer_keyframes(report)},
          {"timeline", viewer_timeline(report, budget)},
          {"remarks", report.flight.remarks},
          {"skipped", std::move(skipped)}};
}

}  // namespace ilp::viewer
