#include "sim/ground/report/page_sections.hpp"
#include "sim/ground/report/report_style.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {

std::string report_html(const Report& report) {
  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>" +
      host::escaped(report.title) + "</title><style>" + report_style + "</style></head>\n<body><main>\n";
  html += page_summary(report);
  html += page_strips(report);
  html += page_problems(report);
  html += page_score(report);
  html += page_accuracy(report);
  html += page_keyframe_table(report);
  html += page_captures(report);
  html += page_plots(report);
  html += page_cost(report);
  html += page_gallery(report);
  html += page_files(report);
  html +=
      "<footer class=\"note\"><p>Beside this page: <code>report.json</code> (all numbers), <code>model.ply</code> "
      "(surface; "
      "MeshLab, CloudCompare, Blender), <code>colmap/</code> (poses and points; COLMAP: File, Import model), "
      "<code>height.pfm</code> and <code>ortho.png</code> (regular grid in the strip's world, <code>ortho.pgw</code> "
      "places "
      "it), <code>keyframes/</code> (decoded images, depths, masks). Further strips carry <code>-strip-N</code> in "
      "their "
      "names.</p></footer>\n</main></body></html>\n";
  return html;
}

}  // namespace ilp::report
