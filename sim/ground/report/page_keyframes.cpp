// Keyframes one by one: a table of numbers and a gallery of pictures.
#include <algorithm>
#include <cmath>

#include "sim/ground/report/page_sections.hpp"
#include "sim/host/picture.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

const KeyframeAccuracy* accuracy_of(const Report& report, const intake::Keyframe& k) {
  for (const StripResult& strip : report.strips) {
    if (strip.strip.id != k.strip_id || !strip.accuracy) continue;
    const auto found = strip.accuracy->keyframes.find(k.id);
    return found == strip.accuracy->keyframes.end() ? nullptr : &found->second;
  }
  return nullptr;
}

bool any_depth_truth(const Report& report) {
  return std::any_of(report.strips.begin(), report.strips.end(),
                     [](const StripResult& s) { return s.accuracy && s.accuracy->depth_percent; });
}

std::string bytes_cell(const std::optional<intake::ProductAccount>& product) {
  if (!product) return cell("–");
  std::string text = host::bytes_text(product->bytes);
  if (product->grant_bytes > 0) {
    text += " <span class=\"sub\">" +
            host::fixed(100.0 * static_cast<double>(product->bytes) / product->grant_bytes, 0) + " %</span>";
  }
  return cell(text, over_grant(*product) ? "bad" : "");
}

std::string pose_cells(const intake::Keyframe& k) {
  if (!k.pose) return cell("–") + cell("–") + cell("–") + cell("–") + cell("–");
  const PoseRecord& p = *k.pose;
  const double sigma = std::max({p.sigma[0], p.sigma[1], p.sigma[2]});
  // A pose read from a product's metadata has no statistics with it.
  const bool counted_matches = p.matches > 0 || p.inliers > 0;
  return cell(counted_matches ? std::to_string(p.matches) : "–") +
         cell(counted_matches ? std::to_string(p.inliers) : "–") +
         cell(counted_matches ? host::fixed(p.rms_px, 2) : "–") +
         cell(counted_matches ? host::fixed(p.parallax_px, 1) : "–") + cell(host::brief(sigma));
}

std::string table_row(const Report& report, const intake::Keyframe& k) {
  const std::string verdict = keyframe_verdict(k);
  const double megapixels = static_cast<double>(k.camera.width) * k.camera.height;
  const std::string fresh =
      k.depth && megapixels > 0 ? host::fixed(100.0 * k.depth->newly_seen / megapixels, 0) + " %" : "–";
  std::string html = "<tr>" + cell(std::to_string(k.id)) + cell(std::to_string(k.strip_id)) +
                     cell(host::escaped(k.name), "t") +
                     cell(k.record && k.record->index > 0 ? host::fixed(100 * k.record->overlap, 1) + " %" : "–") +
                     pose_cells(k) + cell(fresh) + cell(k.richness ? host::fixed(k.richness->richness, 3) : "–") +
                     bytes_cell(k.product(ProductKind::image)) + bytes_cell(k.product(ProductKind::depth));
  if (!report.image_quality.empty()) {
    const auto quality = report.image_quality.find(k.id);
    html += cell(quality == report.image_quality.end() ? "–" : host::fixed(quality->second.inside_db, 1));
  }
  if (report.has_reference) {
    const KeyframeAccuracy* a = accuracy_of(report, k);
    html += cell(a == nullptr ? "–" : host::brief(a->position));
    if (any_depth_truth(report)) {
      html += cell(a == nullptr || !a->depth ? "–" : host::brief(a->depth->median_abs_percent) + " %");
    }
  }
  return html + cell(host::escaped(verdict), verdict.starts_with("ok") ? "t good" : "t w warn") + "</tr>\n";
}

std::string thumbnail(const std::vector<std::uint8_t>& png, const std::string& what) {
  return "<img loading=\"lazy\" alt=\"" + what + "\" src=\"" + host::data_uri(png) + "\">";
}

std::string missing(const char* what) {
  return std::string("<div class=\"none\">no ") + what + "</div>";
}

std::string picture(const std::vector<std::uint8_t>& png, const char* what) {
  return png.empty() ? missing(what) : thumbnail(png, what);
}

std::string gallery_frame(const intake::Keyframe& k, const map::KeyframeLook& look) {
  return "<div class=\"frame\" style=\"--shape:" + std::to_string(std::max(1, k.camera.width)) + "/" +
         std::to_string(std::max(1, k.camera.height)) + "\"><b>" + std::to_string(k.id) + "</b> <span class=\"sub\">" +
         host::escaped(k.name) + "</span><div class=\"row\">" + picture(look.image, "image") +
         picture(look.depth, "depth") + picture(look.mask, "mask") + "</div></div>\n";
}

}  // namespace

std::string page_keyframe_table(const Report& report) {
  std::string html =
      "<h2>Keyframes</h2>\n<div class=\"scroll keyframes\"><table><tr><th>keyframe</th><th>strip</th><th "
      "class=\"t\">frame</th>"
      "<th>overlap</th><th>matches</th><th>inliers</th><th>rms<br>px</th><th>parallax<br>px</th>"
      "<th>position<br>1 σ</th><th>new<br>terrain</th><th>richness</th><th>image<br>of grant</th>"
      "<th>depth<br>of grant</th>";
  if (!report.image_quality.empty()) html += "<th>PSNR in<br>mask, dB</th>";
  if (report.has_reference) html += "<th>position<br>error</th>";
  if (any_depth_truth(report)) html += "<th>height<br>error</th>";
  html += "<th class=\"t\">verdict</th></tr>\n";
  for (const auto& [id, keyframe] : report.flight.keyframes) html += table_row(report, keyframe);
  return html +
         "</table></div>\n<p class=\"note\">Overlap and parallax are with the previous keyframe; rms is the "
         "reprojection error of the adjustment window; 1 σ is the largest axis, in strip units.</p>\n";
}

std::string page_gallery(const Report& report) {
  std::string html =
      "<h2>Keyframe pictures</h2>\n<p class=\"note\">As decoded from the downlink: image, depth (dark is near, "
      "each keyframe with its own colours), newly seen terrain.</p>\n<div class=\"frames\">\n";
  for (const auto& [id, keyframe] : report.flight.keyframes) {
    const auto look = report.looks.find(id);
    html += gallery_frame(keyframe, look == report.looks.end() ? map::KeyframeLook() : look->second);
  }
  return html + "</div>\n";
}

}  // namespace ilp::report
