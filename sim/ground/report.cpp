#include "sim/ground/report.hpp"

#include "sim/ground/status_words.hpp"

namespace ilp::ground {

bool over_grant(const ProductAccount& product) {
  return product.grant_bytes > 0 && product.bytes > product.grant_bytes;
}

ReportTotals totals(const Report& report) {
  ReportTotals t;
  for (const auto& [id, keyframe] : report.flight.keyframes) {
    ++t.keyframes;
    t.posed += keyframe.posed() ? 1U : 0U;
    t.with_depth += has_surface(keyframe) ? 1U : 0U;
    t.product_pixels += static_cast<double>(keyframe.image.samples.size());
    for (const auto& product : keyframe.products) {
      if (!product) continue;
      ++t.products;
      t.product_bytes += product->bytes;
      t.over_grant += over_grant(*product) ? 1U : 0U;
    }
  }
  for (const ReceivedFile& file : report.outbox.files) {
    (file.fault.empty() ? t.files_used : t.files_skipped) += 1;
    if (file.fault.empty()) t.received_bytes += file.bytes;
  }
  for (const EventRecord& event : report.flight.events) {
    if (event.severity == static_cast<std::uint8_t>(Severity::medium)) ++t.events_medium;
    if (event.severity >= static_cast<std::uint8_t>(Severity::high)) ++t.events_high;
  }
  return t;
}

std::string keyframe_verdict(const Keyframe& keyframe) {
  std::string verdict;
  const auto add = [&verdict](const std::string& part) { verdict += (verdict.empty() ? "" : "; ") + part; };
  if (!keyframe.pose) {
    add("no pose received");
  } else if (keyframe.pose->state == PoseState::failed) {
    add(std::string("pose failed: ") + pose_verdict_words(keyframe.pose->verdict));
  } else if (keyframe.pose->state != PoseState::final) {
    add("pose still provisional");
  }
  if (keyframe.depth && keyframe.depth->verdict != DepthVerdict::ok) {
    add(std::string("no depth: ") + depth_verdict_words(keyframe.depth->verdict));
  } else if (keyframe.posed() && keyframe.inverse_depth.empty()) {
    add("no depth product received");
  }
  if (keyframe.image.empty()) add("no image received");
  for (const auto& product : keyframe.products) {
    if (product && over_grant(*product)) add(product->file + " exceeds its grant");
  }
  return verdict.empty() ? "ok" : verdict;
}

}  // namespace ilp::ground
