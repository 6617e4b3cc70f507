#include "sim/ground/report/report.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <system_error>

#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::report {
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

map::KeyframeQuickLook look_of(const Report& report, std::int64_t keyframe_id) {
  const auto quick_look = report.quick_looks.find(keyframe_id);
  if (quick_look == report.quick_looks.end()) return {};
  return report.whole_quick_look ? report.whole_quick_look(keyframe_id) : quick_look->second;
}

LengthUnit length_unit(const Report& report, const StripResult& strip) {
  const exports::Georeference& place = strip.georeference;
  if (place.on_a_body()) return {place.scale, "m"};
  return {1, intake::unit_of(report.flight, strip.strip)};
}

std::string strip_end(const Report& report, const intake::Strip& strip) {
  for (const model::JoinedModel& joined : report.joined.models) {
    if (joined.strip_id != strip.id || joined.strips.size() < 2) continue;
    std::string text = "joined from strips ";
    for (const std::int64_t id : joined.strips) text += (id == joined.strips.front() ? "" : ", ") + std::to_string(id);
    return text;
  }
  return strip.record ? words_of(strip.record->end) : "";
}

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

double psnr_db(ImageView<const std::uint8_t> decoded, ImageView<const std::uint8_t> original,
               const host::Raster<std::uint8_t>& mask, bool inside) {
  const bool masked = mask.same_size(decoded.width, decoded.height);
  double squares = 0, pixels = 0;
  for (std::int32_t y = 0; y < decoded.height; ++y) {
    for (std::int32_t x = 0; x < decoded.width; ++x) {
      if ((!masked || mask.at(x, y) != 0) != inside) continue;
      const double difference = static_cast<double>(decoded.at(x, y)) - original.at(x, y);
      squares += difference * difference;
      ++pixels;
    }
  }
  if (pixels == 0) return std::numeric_limits<double>::quiet_NaN();
  return 10 * std::log10(255.0 * 255.0 * pixels / squares);
}

void measure_image_quality(const std::filesystem::path& folder, Report& report) {
  for (const auto& [id, keyframe] : report.flight.keyframes) {
    if (!keyframe.has_image()) continue;
    const std::filesystem::path path = folder / keyframe.name;
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) continue;
    try {
      const host::Raster<std::uint8_t> original = host::read_gray(path);
      const intake::KeyframeRasters rasters = intake::decode_products(keyframe).rasters;
      if (!rasters.image.same_size(original.width, original.height)) continue;
      report.image_quality[id] = {psnr_db(rasters.image.view(), original.view(), rasters.mask, true),
                                  psnr_db(rasters.image.view(), original.view(), rasters.mask, false)};
    } catch (const std::exception& fault) {
      report.flight.remarks.emplace_back(fault.what());
    }
  }
}

}  // namespace ilp::report
