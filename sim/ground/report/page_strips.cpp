// Strips with their pictures, and their errors against the reference.
#include <cmath>

#include "sim/ground/intake/strip_track.hpp"
#include "sim/ground/report/page_sections.hpp"
#include "sim/ground/report/strip_pictures.hpp"
#include "sim/host/status_words.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

std::string file_list(const std::vector<std::string>& files) {
  std::string html = "For other tools:";
  for (const std::string& name : files) html += " <a href=\"" + name + "\">" + name + "</a>";
  return html + ".";
}

std::string strip_facts(const Report& report, const StripResult& s) {
  const std::string unit = intake::unit_of(report.flight, s.strip);
  std::string html =
      "<p>" + std::to_string(s.posed) + " of " + host::counted(s.strip.keyframes.size(), "keyframe") + " posed";
  if (s.track_length > 0) html += ", " + host::brief(s.track_length) + " " + unit + " flown";
  if (s.flying_height > 0) html += " at " + host::brief(s.flying_height) + " " + unit + " above the ground";
  if (s.grid) {
    html += "; " + host::brief(s.map.covered_area) + " square " + unit + " mapped in cells of " +
            host::brief(s.geometry.cell) + " " + unit;
    if (s.map.seam_cells > 0) {
      html += ", heights at the seams of its pieces " + host::brief(s.map.seam_step_median) + " " + unit +
              " apart (median; 95 % below " + host::brief(s.map.seam_step_p95) + ")";
    }
  }
  if (std::isfinite(s.mask_share) && s.mask_share > 0) {
    html += "; " + host::fixed(100 * s.mask_share, 0) + " % of the keyframes' pixels sent as new terrain";
  }
  if (s.strip.record) html += ". The strip ended: " + std::string(words_of(s.strip.record->end));
  html += ".</p>\n<p class=\"note\">";
  if (s.vertices > 0) {
    html += "Surface <code>model" + s.suffix + ".ply</code>: " + std::to_string(s.vertices) + " vertices, " +
            std::to_string(s.faces) + " faces, every " +
            (s.stride == 1 ? std::string("cell") : std::to_string(s.stride) + ". cell") + ". ";
  }
  if (s.colmap.images > 0) {
    html += "COLMAP model <code>colmap" + s.suffix + "</code>: " + std::to_string(s.colmap.images) + " images, " +
            std::to_string(s.colmap.points) + " points. ";
  }
  if (!s.place.empty()) html += "Place: " + host::escaped(s.place) + ". ";
  if (!s.files.empty()) html += file_list(s.files) + " ";
  if (unit == "units") html += "The scale is the strip's own: its first baseline is 1.";
  return html + "</p>\n";
}

std::string error_row(const std::string& name, const StripAccuracy& a, const host::ErrorSummary& e) {
  const auto percent = [](double value) { return host::brief(value) + " %"; };
  return "<tr>" + cell(name, "t") + cell(host::brief(e.mean)) + cell(host::brief(e.rms)) + cell(host::brief(e.max)) +
         cell(percent(a.percent_of_length(e.mean))) + cell(percent(a.percent_of_length(e.rms))) +
         cell(percent(a.percent_of_length(e.max))) + cell(percent(a.percent_of_extent(e.mean))) +
         cell(percent(a.percent_of_extent(e.max))) + "</tr>\n";
}

std::string strip_accuracy(const StripResult& s) {
  const StripAccuracy& a = *s.accuracy;
  constexpr double degree = 180 / 3.14159265358979323846;
  std::string html = "<h3>Strip " + std::to_string(s.strip.id) + "</h3><p>" + host::counted(a.poses, "pose") +
                     " over " + host::brief(a.length) + " reference units of flight (extent " + host::brief(a.extent) +
                     "); one strip unit is " + host::brief(a.reference_from_strip.scale) + " reference units.";
  if (a.poses < 4) html += " <span class=\"warn\">With so few poses the alignment absorbs most of the error.</span>";
  html +=
      "</p><div class=\"scroll\"><table><tr><th class=\"t\">Camera positions</th><th>mean</th><th>rms</th><th>max</th>"
      "<th>mean,<br>of length</th><th>rms,<br>of length</th><th>max,<br>of length</th><th>mean,<br>of extent</th>"
      "<th>max,<br>of extent</th></tr>\n";
  html += error_row("aligned by positions", a, a.position);
  html += error_row("turned by attitudes", a, a.position_with_attitude);
  html += "</table></div><p>Attitude error: mean " + host::brief(a.rotation_rad.mean * degree) + "°, max " +
          host::brief(a.rotation_rad.max * degree) + "°.";
  if (a.depth_percent) {
    html += " Median absolute height error per keyframe, in per cent of the flying height: mean " +
            host::brief(a.depth_percent->mean) + ", worst " + host::brief(a.depth_percent->max) + ".";
  }
  return html + "</p>\n";
}

}  // namespace

std::string page_strips(const Report& report) {
  std::string html, without_pose;
  for (const StripResult& strip : report.strips) {
    if (strip.posed == 0) {
      without_pose += (without_pose.empty() ? "" : ", ") + std::to_string(strip.strip.id);
      continue;
    }
    html += "<h2>Strip " + std::to_string(strip.strip.id) + "</h2>\n" + strip_facts(report, strip);
    const StripFigures figures = strip_figures(report.flight, strip);
    html += figures.ortho + figures.relief + figures.oblique;
    if (figures.ortho.empty())
      html += "<p class=\"note\">No depth came down for this strip: there is no terrain to show.</p>\n";
  }
  if (without_pose.empty()) return html;
  return html + "<h2>Strips without a pose</h2>\n<p>" + without_pose +
         ": no two of their keyframes could be related, so nothing is mapped. See the keyframes for the reasons.</p>\n";
}

std::string page_accuracy(const Report& report) {
  if (!report.has_reference) return "";
  std::string html =
      "<h2>Errors against the reference</h2>\n<p class=\"note\">Positions after a similarity alignment (Umeyama). "
      "The second line takes the rotation from the attitudes instead, so that a track turned about itself is "
      "not forgiven. Length is the path over the reference positions, extent their largest distance.</p>\n";
  bool any = false;
  for (const StripResult& strip : report.strips) {
    if (!strip.accuracy) continue;
    any = true;
    html += strip_accuracy(strip);
  }
  return any ? html : html + "<p class=\"warn\">No strip has two poses whose images are named in the reference.</p>\n";
}

}  // namespace ilp::report
