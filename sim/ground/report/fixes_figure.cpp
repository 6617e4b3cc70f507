// Fixes of keyframes on the map of an orbiter: the track on the map.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <string>

#include "sim/ground/fixes/fix_text.hpp"
#include "sim/ground/report/figures.hpp"
#include "sim/ground/report/map_figures.hpp"
#include "sim/host/statistics.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

using fixes::KeyframeFix;
using fixes::StripFixes;

constexpr double width = 1200, height = 420;
constexpr double degrees = 180 / std::numbers::pi;

bool has_place(const KeyframeFix& one) {
  return one.fix.verdict == MapVerdict::fixed;
}

/// The plane of the map in the picture: east is to the right, north up.
class MapFrame {
 public:
  void take(double x, double y) {
    low_[0] = std::min(low_[0], x);
    low_[1] = std::min(low_[1], y);
    high_[0] = std::max(high_[0], x);
    high_[1] = std::max(high_[1], y);
  }
  [[nodiscard]] double scale() const {
    constexpr double share = 0.88;
    return share * std::min(width / std::max(high_[0] - low_[0], 1e-6), height / std::max(high_[1] - low_[1], 1e-6));
  }
  [[nodiscard]] PicturePoint at(double x, double y) const {
    return {0.5 * width + (x - 0.5 * (low_[0] + high_[0])) * scale(),
            0.5 * height - (y - 0.5 * (low_[1] + high_[1])) * scale()};
  }
  /// The place of the picture's north-western corner.
  [[nodiscard]] std::array<double, 2> corner() const {
    return {0.5 * (low_[0] + high_[0] - width / scale()), 0.5 * (low_[1] + high_[1] + height / scale())};
  }

 private:
  double low_[2] = {1e300, 1e300}, high_[2] = {-1e300, -1e300};
};

std::string polyline(const MapFrame& frame, const std::vector<Vec3>& track, const char* style) {
  std::string svg = std::string("<polyline class=\"") + style + "\" points=\"";
  for (const Vec3& centre : track) {
    const PicturePoint p = frame.at(centre.x(), centre.y());
    svg += px(p[0]) + "," + px(p[1]) + " ";
  }
  return svg + "\"/>";
}

/// Such that ellipses are seen: 1, 2, 5, 10, ...
double magnification(const StripFixes& strip, const MapFrame& frame) {
  constexpr double seen_px = 14;
  std::vector<double> sizes;
  for (const KeyframeFix& one : strip.keyframes) {
    if (has_place(one)) sizes.push_back(fixes::ellipse_of(one.fix).major_m);
  }
  const double wanted = seen_px / std::max(host::median(std::move(sizes)) * frame.scale(), 1e-9);
  double factor = 1;
  for (int i = 0; i < 30 && factor < wanted; ++i) factor *= i % 3 == 1 ? 2.5 : 2;
  return factor;
}

/// The ground point, with its error.
std::string cross(const KeyframeFix& one, bool contradicts, const MapFrame& frame, double factor) {
  const PicturePoint p = frame.at(one.fix.ground_m[0], one.fix.ground_m[1]);
  const fixes::ErrorEllipse e = fixes::ellipse_of(one.fix);
  const double unit = factor * frame.scale();
  const bool counts = one.fix.state == FixState::accepted;
  const std::string colour = contradicts ? "#d33a2c" : counts ? "#58b06a" : "#e08a3c";
  constexpr double arm = 7;
  return "<g stroke=\"" + colour + "\" stroke-width=\"1.6\"><title>keyframe " + std::to_string(one.fix.id) +
         "</title><ellipse cx=\"" + px(p[0]) + "\" cy=\"" + px(p[1]) + "\" rx=\"" + px(e.major_m * unit) + "\" ry=\"" +
         px(e.minor_m * unit) + "\" transform=\"rotate(" + host::fixed(-degrees * e.direction_rad, 1) + " " + px(p[0]) +
         " " + px(p[1]) + ")\" fill=\"" + colour + "\" fill-opacity=\"0.2\"/><path d=\"M" + px(p[0] - arm) + " " +
         px(p[1]) + "h14M" + px(p[0]) + " " + px(p[1] - arm) + "v14\"/></g>";
}

/// Keyframes whose fixes the final adjustment leaves out.
std::set<std::int64_t> contradicting(const Report& report) {
  std::set<std::int64_t> ids;
  for (const model::JoinedModel& one : report.joined.models) {
    if (!one.on_map) continue;
    for (const model::OnMap::Fix& fix : one.on_map->fixes) {
      if (!fix.used) ids.insert(fix.keyframe_id);
    }
  }
  return ids;
}

/// The central 96 % of the grey values fill the scale; 0 stays unknown.
void stretch(host::Raster<std::uint8_t>& picture) {
  std::vector<double> greys;
  for (std::size_t i = 0; i < picture.samples.size(); i += 7) {
    if (picture.samples[i] != 0) greys.push_back(picture.samples[i]);
  }
  if (greys.empty()) return;
  const double low = host::percentile(greys, 0.02), high = std::max(host::percentile(greys, 0.98), low + 8);
  for (std::uint8_t& grey : picture.samples) {
    if (grey != 0) grey = static_cast<std::uint8_t>(std::clamp(30 + 170 * (grey - low) / (high - low), 1.0, 220.0));
  }
}

/// The map's image under the frame; empty where the map is not at hand, or is another one.
std::string image_of(const Report& report, const StripFixes& strip, const MapFrame& frame) {
  if (!report.map || report.map->id() != strip.map_id) return "";
  const std::array<double, 2> corner = frame.corner();
  host::Raster<std::uint8_t> picture = report.map->picture(
      corner[0], corner[1], 1 / frame.scale(), static_cast<std::int32_t>(width), static_cast<std::int32_t>(height));
  stretch(picture);
  return "<image width=\"1200\" height=\"420\" href=\"" + host::data_uri(host::png_bytes_where_seen(picture)) + "\"/>";
}

/// 1, 2 or 5 times a power of ten, about a fifth of the picture.
double bar_length(double scale) {
  const double wanted = 0.2 * width / scale;
  const double power = std::pow(10, std::floor(std::log10(wanted)));
  return wanted >= 5 * power ? 5 * power : wanted >= 2 * power ? 2 * power : power;
}

std::string line(const MapFrame& frame, const std::vector<Vec3>& track, const char* style) {
  return polyline(frame, track, "track dark") + polyline(frame, track, style);
}

std::string caption_of(const Report& report, const StripFixes& strip, const std::string& image, double factor) {
  std::string text = "Strip " + std::to_string(strip.strip_id) + " on the map, north up. ";
  if (!image.empty())
    text += "Grey is the map's image, and what is dark lies beside it. ";
  else if (report.map)
    text += "The map of --map is another one (" + fixes::map_name(report.map->id()) + "), so its image is not shown. ";
  text += "The line is the track where all fixes put it";
  if (strip.accepted > fixes::first_fixes)
    text += "; dashed is where the first " + std::to_string(fixes::first_fixes) + " of them and the images alone lead";
  if (!strip.track_by_vehicle.empty()) text += "; dotted is where the vehicle's measurements alone put it";
  return text + ". Crosses are the ground points of the fixes, each with the ellipse of its error, one sigma, " +
         host::brief(factor) +
         " times larger than it is: green counts, orange was not confirmed in flight, red "
         "contradicts the others and counts as nothing.";
}

}  // namespace

std::string figure_of_fixes(const Report& report, const StripFixes& strip) {
  if (strip.track_by_all.empty()) return "";
  const bool drifts = strip.accepted > fixes::first_fixes;
  const std::vector<Vec3> by_first = drifts ? strip.track_by_first : std::vector<Vec3>{};
  MapFrame frame;
  for (const std::vector<Vec3>* track : {&strip.track_by_all, &by_first, &strip.track_by_vehicle}) {
    for (const Vec3& centre : *track) frame.take(centre.x(), centre.y());
  }
  for (const KeyframeFix& one : strip.keyframes) {
    if (has_place(one)) frame.take(one.fix.ground_m[0], one.fix.ground_m[1]);
  }
  const double factor = magnification(strip, frame);
  const std::string image = image_of(report, strip, frame);
  std::string svg =
      "<svg viewBox=\"0 0 1200 420\" role=\"img\" aria-label=\"track and fixes on the map\">"
      "<rect width=\"1200\" height=\"420\" fill=\"#20262e\"/>" +
      image;
  svg += line(frame, strip.track_by_vehicle, "track dotted") + line(frame, by_first, "track dashed") +
         line(frame, strip.track_by_all, "track");
  const std::set<std::int64_t> wrong = contradicting(report);
  for (const KeyframeFix& one : strip.keyframes) {
    if (has_place(one)) svg += cross(one, wrong.contains(one.fix.id), frame, factor);
  }
  const double bar = bar_length(frame.scale());
  svg += segment({16, height - 14}, {16 + bar * frame.scale(), height - 14}, "track") +
         label(16 + 0.5 * bar * frame.scale(), height - 21, "middle", host::brief(bar) + " m");
  return figure(svg, caption_of(report, strip, image, factor));
}

}  // namespace ilp::report
