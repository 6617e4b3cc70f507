// The pictures of a strip as figures of the page: PNG inside SVG with the track drawn over it.

#include <array>
#include <cmath>
#include <string>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/report/figures.hpp"
#include "sim/ground/report/map_figures.hpp"
#include "sim/ground/report/plan_view.hpp"
#include "sim/ground/report/report.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

std::string polyline(const std::vector<PicturePoint>& points, const char* style) {
  std::string svg = std::string("<polyline class=\"") + style + "\" points=\"";
  for (const auto& p : points) svg += px(p[0]) + "," + px(p[1]) + " ";
  return svg + "\"/>";
}

// The track with a dot per keyframe; a number only where it does not touch the previous number.
std::string draw_track(const std::vector<PicturePoint>& points, const std::vector<intake::TrackPoint>& track) {
  std::string svg = polyline(points, "track dark") + polyline(points, "track");
  PicturePoint numbered{-1e9, -1e9};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& [x, y] = points[i];
    svg += "<circle class=\"stop\" cx=\"" + px(x) + "\" cy=\"" + px(y) + "\" r=\"4.5\"/>";
    if (std::hypot(x - numbered[0], y - numbered[1]) < 26) continue;
    numbered = points[i];
    svg += label(x, y - 9, "middle", std::to_string(track[i].keyframe_id));
  }
  return svg;
}

/// North where the strip's place is known, else the world's y axis.
std::string orientation(const PlanView& view, const StripResult& strip) {
  const auto north = strip.georeference.north();
  return north ? direction_arrow(view, (*north)[0], (*north)[1], "N") : direction_arrow(view, 0, 1, "y");
}

std::vector<Vec3> centres_of(const std::vector<intake::TrackPoint>& track) {
  std::vector<Vec3> centres;
  for (const intake::TrackPoint& point : track) centres.push_back(point.centre);
  return centres;
}

std::string laid_words(const map::GroundGrid& grid) {
  const bool any = std::any_of(grid.laid.grey.samples.begin(), grid.laid.grey.samples.end(),
                               [](std::uint8_t grey) { return grey != 0; });
  return any ? " Hatched: no height was measured; the image is laid on interpolated ground." : "";
}

}  // namespace

std::vector<std::string> figures_of_strip(const intake::Flight& flight, const StripResult& strip) {
  std::vector<std::string> figures;
  if (!strip.grid) return figures;
  const char* unit = intake::unit_of(flight, strip.strip);
  const std::vector<intake::TrackPoint> track = intake::track_of(flight, strip.strip);
  const std::vector<Vec3> centres = centres_of(track);
  const PlanView view = make_plan_view(&*strip.grid, centres, 1400, 760);
  const ViewSurface surface = resample(*strip.grid, strip.plane, view);
  const host::ValueRange range = host::display_range(surface.relief);
  std::vector<PicturePoint> points;
  for (const Vec3& c : centres) points.push_back({view.px(c.x(), c.y()), view.py(c.x(), c.y())});
  const std::string frame = scale_bar(view, unit) + orientation(view, strip);
  const std::string marks = draw_track(points, track) + frame;

  figures.push_back(figure(open_svg(ortho_picture(surface), "orthoimage with the track") + marks,
                           "Orthoimage, turned so that the flight goes from left to right. The line is the track, the "
                           "numbers are keyframes. Contrast stretched over the central 98 % of the grey values." +
                               laid_words(*strip.grid) + " Blank: nothing was sent."));
  figures.push_back(figure(open_svg(relief_picture(surface, range), "heights") +
                               colour_legend("Height above the mean plane", range, unit, view.width) + frame,
                           "Heights above the mean plane, shaded from the upper left (slopes " +
                               host::brief(surface.exaggeration) + " times steeper than they are)."));

  const PlanView coarse = make_plan_view(&*strip.grid, centres, 800, 560);
  const ViewSurface coarse_surface = resample(*strip.grid, strip.plane, coarse);
  const ObliqueView oblique = draw_oblique(coarse_surface, coarse, strip.plane, centres, 1200);
  if (oblique.picture.empty()) return figures;
  std::string stems;
  for (std::size_t i = 0; i < oblique.track.size(); ++i) {
    stems +=
        segment(oblique.track[i], oblique.below[i], "stem dark") + segment(oblique.track[i], oblique.below[i], "stem");
  }
  figures.push_back(
      figure(open_svg(oblique.picture, "terrain and track at a slant") + stems + draw_track(oblique.track, track),
             "Terrain and track at a slant, from the right of the flight. Relief " + host::brief(oblique.exaggeration) +
                 " times higher than it is; the track to scale."));
  return figures;
}

}  // namespace ilp::report
