// Keyframes one by one: a table of numbers and a gallery of pictures.
#include <algorithm>
#include <cmath>
#include <functional>
#include <ostream>

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

struct Value {
  std::string html;
  const char* style = "";
};

/// A column of the table. A narrow window shows each row as a list, with the title before each value.
struct Column {
  const char* title;  ///< may hold line breaks (<br>)
  const char* style;  ///< of the title
  std::function<Value(const intake::Keyframe&)> value;
};

Value bytes_value(const std::optional<intake::ProductAccount>& product) {
  if (!product) return {"–"};
  std::string text = host::bytes_text(product->bytes);
  if (product->grant_bytes > 0) {
    text += " <span class=\"sub\">" +
            host::fixed(100.0 * static_cast<double>(product->bytes) / product->grant_bytes, 0) + " %</span>";
  }
  return {text, over_grant(*product) ? "bad" : ""};
}

/// A value of the pose. A pose read from a product's metadata has no statistics with it.
Column of_matches(const char* title, std::string (*text)(const PoseRecord&)) {
  return {title, "", [text](const intake::Keyframe& k) -> Value {
            const bool counted = k.pose && (k.pose->matches > 0 || k.pose->inliers > 0);
            return {counted ? text(*k.pose) : "–"};
          }};
}

Value sigma_value(const intake::Keyframe& k) {
  if (!k.pose) return {"–"};
  return {host::brief(std::max({k.pose->sigma[0], k.pose->sigma[1], k.pose->sigma[2]}))};
}

Value fresh_value(const intake::Keyframe& k) {
  const double pixels = static_cast<double>(k.camera.width) * k.camera.height;
  return {k.mask_record && pixels > 0 ? host::fixed(100.0 * k.mask_record->newly_seen / pixels, 0) + " %" : "–"};
}

Value verdict_value(const intake::Keyframe& k) {
  const std::string verdict = keyframe_verdict(k);
  return {host::escaped(verdict), verdict.starts_with("ok") ? "t good" : "t w warn"};
}

void add_quality(const Report& report, std::vector<Column>& columns) {
  if (report.image_quality.empty()) return;
  columns.push_back({"PSNR in<br>mask, dB", "", [&report](const intake::Keyframe& k) -> Value {
                       const auto quality = report.image_quality.find(k.id);
                       return {quality == report.image_quality.end() ? "–" : host::fixed(quality->second.inside_db, 1)};
                     }});
}

void add_errors(const Report& report, std::vector<Column>& columns) {
  if (!report.has_reference) return;
  columns.push_back({"position<br>error", "", [&report](const intake::Keyframe& k) -> Value {
                       const KeyframeAccuracy* a = accuracy_of(report, k);
                       return {a == nullptr ? "–" : host::brief(a->position)};
                     }});
  if (!any_depth_truth(report)) return;
  columns.push_back({"height<br>error", "", [&report](const intake::Keyframe& k) -> Value {
                       const KeyframeAccuracy* a = accuracy_of(report, k);
                       return {a == nullptr || !a->depth ? "–" : host::brief(a->depth->median_abs_percent) + " %"};
                     }});
}

std::vector<Column> columns_of(const Report& report) {
  using K = const intake::Keyframe&;
  std::vector<Column> columns = {
      {"keyframe", "", [](K k) -> Value { return {std::to_string(k.id)}; }},
      {"strip", "", [](K k) -> Value { return {std::to_string(k.strip_id)}; }},
      {"frame", "t",
       [](K k) -> Value {
         return {host::escaped(k.name), "t"};
       }},
      {"overlap", "",
       [](K k) -> Value {
         return {k.record && k.record->index > 0 ? host::fixed(100 * k.record->overlap, 1) + " %" : "–"};
       }},
      of_matches("matches", [](const PoseRecord& p) { return std::to_string(p.matches); }),
      of_matches("inliers", [](const PoseRecord& p) { return std::to_string(p.inliers); }),
      of_matches("rms<br>px", [](const PoseRecord& p) { return host::fixed(p.rms_px, 2); }),
      of_matches("parallax<br>px", [](const PoseRecord& p) { return host::fixed(p.parallax_px, 1); }),
      {"position<br>1 σ", "", sigma_value},
      {"new<br>terrain", "", fresh_value},
      {"richness", "", [](K k) -> Value { return {k.richness ? host::fixed(k.richness->richness, 3) : "–"}; }},
      {"image<br>of grant", "", [](K k) { return bytes_value(k.product(ProductKind::image)); }},
      {"depth<br>of grant", "", [](K k) { return bytes_value(k.product(ProductKind::depth)); }}};
  add_quality(report, columns);
  add_errors(report, columns);
  columns.push_back({"verdict", "t", verdict_value});
  return columns;
}

std::string plain_title(const Column& column) {
  std::string title = column.title;
  if (const std::size_t at = title.find("<br>"); at != std::string::npos) title.replace(at, 4, " ");
  return title;
}

std::string table_row(const std::vector<Column>& columns, const intake::Keyframe& k) {
  std::string html = "<tr>";
  for (const Column& column : columns) {
    const Value value = column.value(k);
    html += "<td data-title=\"" + plain_title(column) + "\"";
    if (*value.style != '\0') html += std::string(" class=\"") + value.style + "\"";
    html += ">" + value.html + "</td>";
  }
  return html + "</tr>\n";
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

std::string gallery_frame(const intake::Keyframe& k, const map::KeyframeQuickLook& quick_look) {
  return "<div class=\"frame\" style=\"--shape:" + std::to_string(std::max(1, k.camera.width)) + "/" +
         std::to_string(std::max(1, k.camera.height)) + "\"><b>" + std::to_string(k.id) + "</b> <span class=\"sub\">" +
         host::escaped(k.name) + "</span><div class=\"row\">" + picture(quick_look.image, "image") +
         picture(quick_look.depth, "depth") + picture(quick_look.mask, "mask") + "</div></div>\n";
}

}  // namespace

void page_keyframe_table(const Report& report, std::ostream& out) {
  const std::vector<Column> columns = columns_of(report);
  out << "<h2>Keyframes</h2>\n<div class=\"scroll keyframes\"><table><tr>";
  for (const Column& column : columns) {
    out << (*column.style == '\0' ? "<th>" : std::string("<th class=\"") + column.style + "\">") << column.title
        << "</th>";
  }
  out << "</tr>\n";
  for (const auto& [id, keyframe] : report.flight.keyframes) out << table_row(columns, keyframe);
  out << "</table></div>\n<p class=\"note\">Overlap and parallax are with the previous keyframe; rms is the "
         "reprojection error of the adjustment window; 1 σ is the largest axis, in strip units.</p>\n";
}

void page_gallery(const Report& report, std::ostream& out) {
  out << "<h2>Keyframe pictures</h2>\n<p class=\"note\">As decoded from the downlink: image, depth (dark is near, "
         "each keyframe with its own colours), newly seen terrain.</p>\n<div class=\"frames\">\n";
  for (const auto& [id, keyframe] : report.flight.keyframes) out << gallery_frame(keyframe, look_of(report, id));
  out << "</div>\n";
}

}  // namespace ilp::report
