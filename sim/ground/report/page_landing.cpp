// Landing sites of the strips: a picture of the probability, and a table of the best.

#include <cmath>
#include <string>

#include "sim/ground/report/figures.hpp"
#include "sim/ground/report/page_sections.hpp"
#include "sim/ground/report/plan_view.hpp"
#include "sim/ground/report/report.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

/// The probability in colours over the shaded ground; grey where it is not known.
host::Raster<host::Rgba> safety_picture(const landing::LandingMap& map, const PlanView& view,
                                        const ViewSurface& surface) {
  host::Raster<host::Rgba> picture = ortho_picture(surface);
  const map::MapGeometry& geometry = map.hazards.geometry;
  for (std::int32_t py = 0; py < picture.height; ++py) {
    for (std::int32_t px = 0; px < picture.width; ++px) {
      const auto [x, y] = view.world(px, py);
      const double column = std::floor((x - geometry.x0) / geometry.cell + 0.5);
      const double row = std::floor((geometry.y0 - y) / geometry.cell + 0.5);
      host::Rgba& pixel = picture.at(px, py);
      if (pixel.a == 0 || !(column >= 0) || !(row >= 0) || column >= geometry.columns || row >= geometry.rows) continue;
      const float safe = map.safe.at(static_cast<std::int32_t>(column), static_cast<std::int32_t>(row));
      if (!std::isfinite(safe)) continue;
      const host::Rgb colour = host::viridis(safe);
      const double light = 0.55 + 0.45 * surface.shade.at(px, py);
      pixel = {static_cast<std::uint8_t>(light * colour.r), static_cast<std::uint8_t>(light * colour.g),
               static_cast<std::uint8_t>(light * colour.b), 255};
    }
  }
  return picture;
}

std::string site_marks(const landing::LandingMap& map, const PlanView& view) {
  std::string svg;
  const double radius = std::max(5.0, map.limits.footprint_m / (2 * map.metres_per_unit * view.unit_per_px));
  for (std::size_t i = 0; i < map.sites.size(); ++i) {
    const double x = view.px(map.sites[i].x, map.sites[i].y), y = view.py(map.sites[i].x, map.sites[i].y);
    for (const char* style : {"track dark", "track"}) {
      svg += std::string("<circle class=\"") + style + "\" cx=\"" + px(x) + "\" cy=\"" + px(y) + "\" r=\"" +
             px(radius) + "\"/>";
    }
    svg += label(x, y - radius - 4, "middle", std::to_string(i + 1));
  }
  return svg;
}

std::string picture_of(const Report& report, const StripResult& strip, const landing::LandingMap& map) {
  std::vector<Vec3> centres;
  for (const intake::TrackPoint& point : intake::track_of(report.flight, strip.strip)) centres.push_back(point.centre);
  const PlanView view = make_plan_view(&*strip.grid, centres, 1400, 760);
  const ViewSurface surface = resample(*strip.grid, strip.plane, view);
  return figure(open_svg(safety_picture(map, view, surface), "probability of a safe landing") + site_marks(map, view) +
                    scale_bar(view, intake::unit_of(report.flight, strip.strip)) +
                    colour_legend("Probability of a safe landing", {0, 1}, "0 to 1", view.width),
                "Probability that a lander is safe with its footprint there. Grey: the footprint is not covered by "
                "heights. Circles: the best sites, by rank.");
}

std::string row_of(std::size_t rank, const landing::LandingSite& site) {
  return "<tr>" + cell(std::to_string(rank)) + cell(host::fixed(100 * site.safe, 2)) +
         cell(host::fixed(site.slope_rad / landing::degree, 1)) + cell(host::brief(site.roughness_m)) +
         cell(host::brief(site.step_m)) + cell(host::fixed(site.x, 1)) + cell(host::fixed(site.y, 1)) +
         cell(host::fixed(site.z, 1)) + "</tr>\n";
}

std::string table_of(const landing::LandingMap& map) {
  std::string html =
      "<div class=\"scroll\"><table><tr><th>Rank</th><th>safe, %</th><th>slope, °</th><th>roughness, m</th>"
      "<th>step, m</th><th>x</th><th>y</th><th>z</th></tr>\n";
  for (std::size_t i = 0; i < map.sites.size(); ++i) html += row_of(i + 1, map.sites[i]);
  return html +
         "</table></div>\n<p class=\"note\">Rank by the probability; x, y, z in the strip's own axes. Measured "
         "on the map: the true slope and step differ within their errors, which the probability has in it. "
         "<code>landing-sites.geojson</code> has the places for other tools.</p>\n";
}

}  // namespace

std::string page_landing(const Report& report) {
  std::string html;
  for (const StripResult& strip : report.strips) {
    if (!strip.landing) continue;
    html += "<h3>Strip " + std::to_string(strip.strip.id) + "</h3>\n";
    if (!strip.landing->map) {
      html += "<p class=\"warn\">No sites can be found: " + host::escaped(strip.landing->fault) + ".</p>\n";
      continue;
    }
    const landing::LandingMap& map = *strip.landing->map;
    html += "<p>A footprint of " + host::brief(map.limits.footprint_m) + " m is safe where its plane is at most " +
            host::brief(map.limits.slope_rad / landing::degree) +
            "° steep and the ground within it rises and falls by at most " + host::brief(map.limits.step_m) +
            " m about that plane.";
    if (map.sites.empty()) {
      html += " No place is safe with a probability of " + host::fixed(100 * landing::least_safe, 1) + " %.";
    }
    html += "</p>\n" + picture_of(report, strip, map);
    if (!map.sites.empty()) html += table_of(map);
  }
  return html.empty() ? html : "<h2>Landing sites</h2>\n" + html;
}

}  // namespace ilp::report
