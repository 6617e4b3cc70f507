// Strips with their pictures, and their errors against the reference.

#include <array>
#include <cmath>
#include <string>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/report/figures.hpp"
#include "sim/ground/report/page_sections.hpp"
#include "sim/ground/report/plan_view.hpp"
#include "sim/ground/report/report.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

// The pictures of a strip as figures of the page: PNG inside SVG with the track drawn over it.

struct StripFigures {
  std::string ortho, relief, oblique;  ///< <figure> elements; empty without a grid
};

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
  const std::string frame = scale_bar(view, unit) + orientation(view, strip);
  const std::string marks = draw_track(points, track) + frame;

  figures.ortho = figure(open_svg(ortho_picture(surface), "orthoimage with the track") + marks,
                         "Orthoimage, turned so that the flight goes from left to right. The line is the track, the "
                         "numbers are keyframes. Contrast stretched over the central 98 % of the grey values." +
                             laid_words(*strip.grid) + " Blank: nothing was sent.");
  figures.relief = figure(open_svg(relief_picture(surface, range), "heights") +
                              colour_legend("Height above the mean plane", range, unit, view.width) + frame,
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

std::string file_list(const std::vector<std::string>& files) {
  std::string html = "For other tools:";
  for (const std::string& name : files) html += " <a href=\"" + name + "\">" + name + "</a>";
  return html + ".";
}

/// How well the vehicle has measured where the strip is.
std::string navigation_facts(const StripFrameRecord& frame) {
  constexpr double degree = 180 / 3.14159265358979323846;
  std::string html = "By the vehicle's navigation (" + std::string(words_of(frame.verdict)) + ", one sigma): ";
  html += frame.scale_sigma > 0 ? "scale " + host::brief(100 * frame.scale_sigma) + " %" : "scale not known";
  html += frame.tilt_sigma_rad > 0 ? ", tilt " + host::brief(degree * frame.tilt_sigma_rad) + "°" : ", tilt not known";
  html += frame.heading_sigma_rad > 0 ? ", heading " + host::brief(degree * frame.heading_sigma_rad) + "°"
                                      : ", heading not known";
  html +=
      frame.horizontal_sigma_m > 0 ? ", place " + host::brief(frame.horizontal_sigma_m) + " m" : ", place not known";
  const std::uint32_t refused =
      frame.heights_refused + frame.attitudes_refused + frame.positions_refused + frame.velocities_refused;
  if (refused > 0) html += "; " + host::counted(refused, "measurement") + " left out";
  return html + ". ";
}

std::string strip_facts(const Report& report, const StripResult& s) {
  const LengthUnit length = length_unit(report, s);
  const double metres = length.factor;
  const std::string& unit = length.name;
  std::string html =
      "<p>" + std::to_string(s.posed) + " of " + host::counted(s.strip.keyframes.size(), "keyframe") + " posed";
  if (s.track_length > 0) html += ", " + host::brief(metres * s.track_length) + " " + unit + " flown";
  if (s.flying_height > 0) html += " at " + host::brief(metres * s.flying_height) + " " + unit + " above the ground";
  if (s.grid) {
    html += "; " + host::brief(metres * metres * s.map.covered_area) + " square " + unit + " mapped in cells of " +
            host::brief(metres * s.geometry.cell) + " " + unit;
    if (s.map.seam_cells > 0) {
      html += ", heights at the seams of its patches " + host::brief(metres * s.map.seam_step_median) + " " + unit +
              " apart (median; 95 % below " + host::brief(metres * s.map.seam_step_p95) + ")";
    }
  }
  if (std::isfinite(s.mask_share) && s.mask_share > 0) {
    html += "; " + host::fixed(100 * s.mask_share, 0) + " % of the keyframes' pixels sent as new terrain";
  }
  if (const std::string end = strip_end(report, s.strip); !end.empty()) html += ". The strip ended: " + end;
  html += ".</p>\n<p class=\"note\">";
  if (s.vertices > 0) {
    html += "Surface <code>model" + s.suffix + (report.with_copies ? ".ply" : ".glb") +
            "</code>: " + std::to_string(s.vertices) + " vertices, " + std::to_string(s.faces) + " faces, " +
            (s.stride == 1 ? std::string("all cells") : "one cell in " + std::to_string(s.stride) + " each way") + ". ";
  }
  if (s.colmap.images > 0) {
    html += "COLMAP model <code>colmap" + s.suffix + "</code>: " + std::to_string(s.colmap.images) + " images, " +
            std::to_string(s.colmap.points) + " points. ";
  }
  if (!s.place.empty()) html += "Place: " + host::escaped(s.place) + ". ";
  if (!s.files.empty()) html += file_list(s.files) + " ";
  if (unit == "units") html += "The scale is the strip's own: its first baseline is 1.";
  if (s.strip.frame && !s.strip.map) html += navigation_facts(*s.strip.frame);
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
  if (a.poses < fewest_poses)
    html += " <span class=\"warn\">With so few poses the alignment absorbs most of the error.</span>";
  html +=
      "</p><div class=\"scroll\"><table><tr><th class=\"t\">Camera positions</th><th>mean</th><th>rms</th><th>max</th>"
      "<th>mean,<br>of length</th><th>rms,<br>of length</th><th>max,<br>of length</th><th>mean,<br>of extent</th>"
      "<th>max,<br>of extent</th></tr>\n";
  html += error_row("aligned by positions", a, a.position);
  html += error_row("turned by attitudes", a, a.position_with_attitude);
  html += "</table></div><p>Attitude error: mean " + host::brief(a.rotation_rad.mean * degree) + "°, max " +
          host::brief(a.rotation_rad.max * degree) + "°.";
  if (a.on_map) {
    html += " On the map, without any alignment, cameras are off by " + host::brief(a.on_map->position.median) +
            " m in the median and " + host::brief(a.on_map->position.max) + " m at most.";
  }
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
  const bool without_camera = report.flight.camera_record && !report.flight.camera_record->frozen;
  return html + "<h2>Strips without a pose</h2>\n<p>" + without_pose +
         (without_camera
              ? ": the camera was not found, so nothing is mapped.</p>\n"
              : ": no two of their keyframes could be related, so nothing is mapped. See the keyframes for the "
                "reasons.</p>\n");
}

std::string page_accuracy(const Report& report) {
  if (!report.has_reference) return "";
  std::string html =
      "<h2>Errors against the reference</h2>\n<p class=\"note\">Positions after a similarity alignment (Umeyama). "
      "The second line takes the rotation from the attitudes instead, so that a track turned about itself is "
      "not forgiven. Length is the path over the reference positions, extent their largest distance.";
  if (report.joined.models.empty()) {
    html += "</p>\n";
  } else {
    html += " The poses are those of the ground's model; the scores are of the poses as the flight sent them.</p>\n";
  }
  bool any = false;
  for (const StripResult& strip : report.strips) {
    if (!strip.accuracy) continue;
    any = true;
    html += strip_accuracy(strip);
  }
  return any ? html : html + "<p class=\"warn\">No strip has two poses whose images are named in the reference.</p>\n";
}

}  // namespace ilp::report
