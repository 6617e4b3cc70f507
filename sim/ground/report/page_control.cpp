// Control points of the strips with their residuals.

#include <string>

#include "sim/ground/report/page_sections.hpp"
#include "sim/ground/report/report.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

std::string role_of(const control::PointResult& point) {
  if (point.used) return "used";
  return point.check && point.fault.empty() ? "check point" : "<span class=\"warn\">not used</span>";
}

std::string row_of(const control::PointResult& point) {
  std::string row = "<tr>" + cell(host::escaped(point.name), "t") + cell(role_of(point), "t") +
                    cell(std::to_string(point.marks)) + cell(host::fixed(point.rms_px, 2));
  for (int axis = 0; axis < 3; ++axis) row += cell(point.residual ? host::fixed((*point.residual)[axis], 3) : "-");
  return row + cell(point.residual ? host::brief(point.residual->norm()) : "-") + cell(host::brief(point.expected_m)) +
         cell(host::escaped(point.fault), "w t") + "</tr>\n";
}

}  // namespace

std::string page_control(const Report& report) {
  if (report.control.empty()) return "";
  std::string html =
      "<h2>Control points</h2>\n<p class=\"note\">The map was placed, scaled and levelled by the points that are used; "
      "they take precedence over the vehicle's navigation. Check points are only measured. Residuals are the place on "
      "the map minus the surveyed one. Expected: one sigma that the survey and marks of one pixel explain.</p>\n";
  for (const std::string& line : control::lines_of(report.control)) html += "<p>" + host::escaped(line) + ".</p>\n";
  for (const control::StripControl& strip : report.control) {
    html += "<h3>Strip " + std::to_string(strip.strip) +
            "</h3><div class=\"scroll\"><table><tr><th class=\"t\">Point</th><th class=\"t\">Role</th><th>marks</th>"
            "<th>rms, px</th><th>x or east, m</th><th>y or north, m</th><th>up, m</th><th>all, m</th>"
            "<th>expected, m</th><th class=\"t\"></th></tr>\n";
    for (const control::PointResult& point : strip.points) html += row_of(point);
    html += "</table></div>\n";
  }
  return html;
}

}  // namespace ilp::report
