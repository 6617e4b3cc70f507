#include "sim/ground/report/strip_pictures.hpp"

#include <array>
#include <cmath>

#include "sim/ground/intake/strip_track.hpp"
#include "sim/ground/report/oblique_view.hpp"
#include "sim/ground/report/plan_view.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

using PicturePoint = std::array<double, 2>;

std::string px(double value) {
  return host::fixed(value, 1);
}

std::string open_svg(const host::Raster<host::Rgba>& picture, const std::string& label) {
  const std::string w = std::to_string(picture.width), h = std::to_string(picture.height);
  return "<svg viewBox=\"0 0 " + w + " " + h + "\" role=\"img\" aria-label=\"" + label + "\"><image width=\"" + w +
         "\" height=\"" + h + "\" href=\"" + host::data_uri(host::png_bytes(picture)) + "\"/>";
}

std::string polyline(const std::vector<PicturePoint>& points, const char* style) {
  std::string svg = std::string("<polyline class=\"") + style + "\" points=\"";
  for (const auto& p : points) svg += px(p[0]) + "," + px(p[1]) + " ";
  return svg + "\"/>";
}

std::string segment(const PicturePoint& a, const PicturePoint& b, const char* style) {
  return std::string("<line class=\"") + style + "\" x1=\"" + px(a[0]) + "\" y1=\"" + px(a[1]) + "\" x2=\"" + px(b[0]) +
         "\" y2=\"" + px(b[1]) + "\"/>";
}

std::string label(double x, double y, const char* anchor, const std::string& text) {
  return "<text class=\"number\" x=\"" + px(x) + "\" y=\"" + px(y) + "\" text-anchor=\"" + anchor + "\">" + text +
         "</text>";
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

std::string scale_bar(const PlanView& view, const char* unit) {
  const double wanted = 0.18 * view.width * view.unit_per_px;
  double length = std::pow(10.0, std::floor(std::log10(wanted)));
  if (wanted >= 5 * length) {
    length *= 5;
  } else if (wanted >= 2 * length) {
    length *= 2;
  }
  const double x0 = 16, y = view.height - 16.0, x1 = x0 + length / view.unit_per_px;
  return segment({x0, y}, {x1, y}, "track dark") + segment({x0, y}, {x1, y}, "track") +
         label(0.5 * (x0 + x1), y - 7, "middle", host::brief(length) + " " + unit);
}

std::string world_arrow(const PlanView& view) {
  // The world's +x axis in the picture: the view is turned by the flight direction.
  const double x = view.width - 60.0, y = view.height - 60.0, length = 24;
  const double dx = view.cosine * length, dy = view.sine * length;
  return segment({x, y}, {x + dx, y + dy}, "track dark") + segment({x, y}, {x + dx, y + dy}, "track") +
         label(x + 1.6 * dx, y + 1.6 * dy + 4, "middle", "x");
}

std::string relief_legend(const host::ValueRange& range, const char* unit, std::int32_t width) {
  std::string svg = "<defs><linearGradient id=\"heights\">";
  for (int i = 0; i <= 10; ++i) {
    const host::Rgb c = host::viridis(i / 10.0);
    svg += "<stop offset=\"" + std::to_string(10 * i) + "%\" stop-color=\"rgb(" + std::to_string(c.r) + "," +
           std::to_string(c.g) + "," + std::to_string(c.b) + ")\"/>";
  }
  const double x = width - 216.0;
  return svg + "</linearGradient></defs><rect x=\"" + px(x) +
         "\" y=\"12\" width=\"200\" height=\"11\" fill=\"url(#heights)\"/>" +
         label(x, 40, "start", host::brief(range.low)) +
         label(x + 200, 40, "end", host::brief(range.high) + " " + unit);
}

std::string figure(const std::string& svg, const std::string& caption) {
  return "<figure>" + svg + "</svg><figcaption>" + caption + "</figcaption></figure>\n";
}

std::vector<Vec3> centres_of(const std::vector<intake::TrackPoint>& track) {
  std::vector<Vec3> centres;
  for (const intake::TrackPoint& point : track) centres.push_back(point.centre);
  return centres;
}

}  // namespace

StripFigures strip_figures(const intake::Flight& flight, const StripResult& strip) {
  StripFigures figures;
  if (!strip.grid) return figures;
  const char* unit = intake::unit_of(flight, strip.strip);
  const std::vector<intake::TrackPoint> track = intake::track_of(flight, strip.strip);
  const std::vector<Vec3> centres = centres_of(track);
  const PlanView view = make_plan_view(&*strip.grid, centres, 1400, 760);
  const ViewSurface surface = resample(*strip.grid, strip.plane, view);
  const host::ValueRange range = host::display_range(surface.relief);
  std::vector<PicturePoint> points;
  for (const Vec3& c : centres) points.push_back({view.px(c.x(), c.y()), view.py(c.x(), c.y())});
  const std::string marks = draw_track(points, track) + scale_bar(view, unit) + world_arrow(view);

  figures.ortho = figure(open_svg(ortho_picture(surface), "orthoimage with the track") + marks,
                         "Orthoimage, turned so that the flight goes from left to right. The line is the track, the "
                         "numbers are keyframes. Blank: no depth was sent there.");
  figures.relief = figure(open_svg(relief_picture(surface, range), "heights") + relief_legend(range, unit, view.width),
                          "Heights above the mean plane, shaded from the upper left (slopes " +
                              host::brief(surface.exaggeration) + " times steeper than they are).");

  const PlanView coarse = make_plan_view(&*strip.grid, centres, 800, 560);
  const ViewSurface coarse_surface = resample(*strip.grid, strip.plane, coarse);
  const ObliqueView oblique = draw_oblique(coarse_surface, coarse, strip.plane, centres, 1200);
  if (oblique.picture.empty()) return figures;
  std::string stems;
  for (std::size_t i = 0; i < oblique.track.size(); ++i) {
    stems +=
        segment(oblique.track[i], oblique.below[i], "stem dark") + segment(oblique.track[i], oblique.below[i], "stem");
  }
  figures.oblique =
      figure(open_svg(oblique.picture, "terrain and track at a slant") + stems + draw_track(oblique.track, track),
             "Terrain and track at a slant, from the right of the flight. Relief " + host::brief(oblique.exaggeration) +
                 " times higher than it is; the track to scale.");
  return figures;
}

}  // namespace ilp::report
