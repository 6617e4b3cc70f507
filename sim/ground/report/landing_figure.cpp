// Landing sites of a strip: a picture of the probability with the best.

#include <cmath>
#include <string>

#include "sim/ground/report/figures.hpp"
#include "sim/ground/report/map_figures.hpp"
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

}  // namespace

std::string figure_of_landing(const intake::Flight& flight, const StripResult& strip) {
  const landing::LandingMap& map = *strip.landing->map;
  std::vector<Vec3> centres;
  for (const intake::TrackPoint& point : intake::track_of(flight, strip.strip)) centres.push_back(point.centre);
  const PlanView view = make_plan_view(&*strip.grid, centres, 1400, 760);
  const ViewSurface surface = resample(*strip.grid, strip.plane, view);
  return figure(open_svg(safety_picture(map, view, surface), "probability of a safe landing") + site_marks(map, view) +
                    scale_bar(view, intake::unit_of(flight, strip.strip)) +
                    colour_legend("Probability of a safe landing", {0, 1}, "0 to 1", view.width),
                "Probability that a lander is safe with its footprint there. Grey: the footprint is not covered by "
                "heights. Circles: the best sites, by rank.");
}

}  // namespace ilp::report
