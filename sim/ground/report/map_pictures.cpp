#include "sim/ground/report/map_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/ground/fixes/fix_text.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::report {
namespace {

using Json = nlohmann::ordered_json;

Json strip_figure(const StripResult& strip, const PlanView& view, const ViewSurface& surface, const KeepPicture& keep) {
  const std::string name = "strip-" + std::to_string(strip.strip.id);
  const host::ValueRange range = host::display_range(surface.relief);
  Json figure = picture_json(view, keep(name + "-image", host::png_bytes(ortho_picture(surface))));
  figure["laid"] =
      std::any_of(surface.laid.samples.begin(), surface.laid.samples.end(), [](float z) { return std::isfinite(z); });
  const auto north = strip.georeference.north();
  figure["north"] = north ? Json(*north) : Json(nullptr);
  figure["heights"] = coloured_picture_json(
      view, keep(name + "-heights", host::png_bytes(relief_picture(surface, range))), range, host::viridis);
  figure["heights"]["exaggeration"] = surface.exaggeration;
  return figure;
}

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

Json landing_figure(const StripResult& strip, const PlanView& view, const ViewSurface& surface,
                    const KeepPicture& keep) {
  const landing::LandingMap& map = *strip.landing->map;
  const std::string address =
      keep("landing-" + std::to_string(strip.strip.id), host::png_bytes(safety_picture(map, view, surface)));
  Json figure = coloured_picture_json(view, address, {0, 1}, host::viridis);
  figure["footprint_px"] = map.limits.footprint_m / (map.metres_per_unit * view.unit_per_px);
  return figure;
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

/// Tracks and ground points on the plane of the map, with a margin.
PlanView view_of_fixes(const fixes::StripFixes& strip) {
  double low[2] = {1e300, 1e300}, high[2] = {-1e300, -1e300};
  const auto take = [&](double x, double y) {
    low[0] = std::min(low[0], x), high[0] = std::max(high[0], x);
    low[1] = std::min(low[1], y), high[1] = std::max(high[1], y);
  };
  for (const std::vector<Vec3>* track : {&strip.track_by_all, &strip.track_by_first, &strip.track_by_vehicle}) {
    for (const Vec3& centre : *track) take(centre.x(), centre.y());
  }
  for (const fixes::KeyframeFix& one : strip.keyframes) {
    if (one.fix.verdict == MapVerdict::fixed) take(one.fix.ground_m[0], one.fix.ground_m[1]);
  }
  constexpr double share = 0.88;
  PlanView view;
  view.width = 1200;
  view.height = 420;
  view.unit_per_px =
      std::max({(high[0] - low[0]) / view.width, (high[1] - low[1]) / view.height, 1e-6 / view.width}) / share;
  view.along_low = 0.5 * (low[0] + high[0] - view.width * view.unit_per_px);
  view.across_high = 0.5 * (low[1] + high[1] + view.height * view.unit_per_px);
  return view;
}

Json fixes_figure(const Report& report, const fixes::StripFixes& strip, const KeepPicture& keep) {
  const PlanView view = view_of_fixes(strip);
  Json figure = picture_json(view, "");
  figure["href"] = nullptr;
  figure["other_map"] = nullptr;
  if (!report.map) return figure;
  if (report.map->id() != strip.map_id) {
    figure["other_map"] = fixes::map_name(report.map->id());
    return figure;
  }
  host::Raster<std::uint8_t> picture =
      report.map->picture(view.along_low, view.across_high, view.unit_per_px, view.width, view.height);
  stretch(picture);
  figure["href"] = keep("fixes-" + std::to_string(strip.strip_id), host::png_bytes_where_seen(picture));
  return figure;
}

/// The map of height errors, cut to what was compared, as means of blocks no wider than a page; null without one.
Json height_error_figure(const host::Raster<float>& map, const KeepPicture& keep) {
  std::int32_t left = map.width, top = map.height, right = -1, bottom = -1;
  for (std::int32_t y = 0; y < map.height; ++y) {
    for (std::int32_t x = 0; x < map.width; ++x) {
      if (!std::isfinite(map.at(x, y))) continue;
      left = std::min(left, x), right = std::max(right, x);
      top = std::min(top, y), bottom = std::max(bottom, y);
    }
  }
  if (right < left) return nullptr;
  const std::int32_t wide = right - left + 1, high = bottom - top + 1;
  const std::int32_t block = std::max(1, (std::max(wide, 2 * high) + 1119) / 1120);
  PlanView view;
  view.width = (wide + block - 1) / block;
  view.height = (high + block - 1) / block;
  host::Raster<float> small(view.width, view.height, std::nanf(""));
  for (std::int32_t y = 0; y < small.height; ++y) {
    for (std::int32_t x = 0; x < small.width; ++x) {
      double sum = 0;
      int cells = 0;
      for (std::int32_t k = 0; k < block * block; ++k) {
        const std::int32_t u = left + x * block + k % block, v = top + y * block + k / block;
        if (!map.contains(u, v) || !std::isfinite(map.at(u, v))) continue;
        sum += map.at(u, v);
        ++cells;
      }
      if (cells > 0) small.at(x, y) = static_cast<float>(sum / cells);
    }
  }
  // Zero lies in the middle, so that colour distinguishes too high from too low.
  const host::ValueRange shown = host::display_range(small);
  const double side = std::max(std::fabs(shown.low), std::fabs(shown.high));
  const host::ValueRange range{-side, side};
  const std::string address =
      keep("height-errors", host::png_bytes(host::colour_mapped(small, range, host::diverging)));
  return coloured_picture_json(view, address, range, host::diverging);
}

}  // namespace

Json picture_json(const PlanView& view, const std::string& address) {
  return {{"view",
           {{"width", view.width},
            {"height", view.height},
            {"cosine", view.cosine},
            {"sine", view.sine},
            {"along_low", view.along_low},
            {"across_high", view.across_high},
            {"unit_per_px", view.unit_per_px}}},
          {"href", address}};
}

Json coloured_picture_json(const PlanView& view, const std::string& address, const host::ValueRange& range,
                           host::ColourMap colours) {
  Json picture = picture_json(view, address);
  picture["range"] = {range.low, range.high};
  picture["colours"] = Json::array();
  for (int i = 0; i <= 10; ++i) {
    const host::Rgb c = colours(i / 10.0);
    picture["colours"].push_back("rgb(" + std::to_string(c.r) + "," + std::to_string(c.g) + "," + std::to_string(c.b) +
                                 ")");
  }
  return picture;
}

void map_figures(const Report& report, const KeepPicture& keep, const TakeFigure& take) {
  for (const StripResult& strip : report.strips) {
    if (!strip.grid) continue;
    const std::string id = std::to_string(strip.strip.id);
    std::vector<Vec3> centres;
    for (const intake::TrackPoint& point : intake::track_of(report.flight, strip.strip))
      centres.push_back(point.centre);
    const PlanView view = make_plan_view(&*strip.grid, centres, 1400, 760);
    const ViewSurface surface = resample(*strip.grid, strip.plane, view);
    take("strip " + id, strip_figure(strip, view, surface, keep));
    if (strip.landing && strip.landing->map) take("landing " + id, landing_figure(strip, view, surface, keep));
  }
  for (const fixes::StripFixes& strip : report.fixes.strips) {
    if (strip.track_by_all.empty()) continue;
    take("fixes " + std::to_string(strip.strip_id), fixes_figure(report, strip, keep));
  }
  if (!report.score) return;
  if (const Json figure = height_error_figure(report.score->height_error, keep); !figure.is_null())
    take("height errors", figure);
}

}  // namespace ilp::report
