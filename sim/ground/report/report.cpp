#include "sim/ground/report/report.hpp"

#include "sim/host/status_words.hpp"

namespace ilp::report {

bool over_grant(const intake::ProductAccount& product) {
  return product.grant_bytes > 0 && product.bytes > product.grant_bytes;
}

ReportTotals totals(const Report& report) {
  ReportTotals t;
  for (const auto& [id, keyframe] : report.flight.keyframes) {
    ++t.keyframes;
    t.posed += keyframe.posed() ? 1U : 0U;
    t.with_depth += map::has_surface(keyframe) ? 1U : 0U;
    if (keyframe.has_image()) t.product_pixels += static_cast<double>(keyframe.camera.width) * keyframe.camera.height;
    for (const auto& product : keyframe.products) {
      if (!product) continue;
      ++t.products;
      t.product_bytes += product->bytes;
      t.over_grant += over_grant(*product) ? 1U : 0U;
    }
  }
  for (const intake::ReceivedFile& file : report.outbox.files) {
    (file.fault.empty() ? t.files_used : t.files_skipped) += 1;
    if (file.fault.empty()) t.received_bytes += file.bytes;
  }
  for (const EventRecord& event : report.flight.events) {
    if (event.severity == static_cast<std::uint8_t>(Severity::medium)) ++t.events_medium;
    if (event.severity >= static_cast<std::uint8_t>(Severity::high)) ++t.events_high;
  }
  return t;
}

namespace {

std::string pose_remark(const intake::Keyframe& keyframe) {
  if (!keyframe.pose) return "no pose received";
  if (keyframe.pose->state == PoseState::failed) {
    return std::string("no pose: ") + words_of(keyframe.pose->verdict);
  }
  return keyframe.pose->state == PoseState::final ? "" : "pose still provisional";
}

// Depth comes from a keyframe and the next one: the last of a strip has none, and that is no fault.
std::string depth_remark(const intake::Keyframe& keyframe) {
  if (!keyframe.posed() || keyframe.has_depth()) return "";
  if (!keyframe.depth || keyframe.depth->verdict == DepthVerdict::ok) return "no depth product received";
  if (keyframe.depth->verdict == DepthVerdict::no_partner) return "";
  return std::string("no depth: ") + words_of(keyframe.depth->verdict);
}

}  // namespace

std::string keyframe_verdict(const intake::Keyframe& keyframe) {
  std::vector<std::string> remarks{pose_remark(keyframe), depth_remark(keyframe)};
  if (!keyframe.has_image()) remarks.emplace_back("no image received");
  for (const auto& product : keyframe.products) {
    if (product && over_grant(*product)) remarks.push_back(product->file + " exceeds its grant");
  }
  std::string verdict;
  for (const std::string& remark : remarks) {
    if (!remark.empty()) verdict += (verdict.empty() ? "" : "; ") + remark;
  }
  if (!verdict.empty()) return verdict;
  return !keyframe.has_depth() ? "ok, last of its strip" : "ok";
}

}  // namespace ilp::report
