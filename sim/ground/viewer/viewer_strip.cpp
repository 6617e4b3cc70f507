// Makes the viewer's surface of a strip from every n-th cell, with values for cells with a height only.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/map/grid_surface.hpp"
#include "sim/ground/report/plan_view.hpp"
#include "sim/ground/viewer/viewer_data.hpp"
#include "sim/host/picture.hpp"

namespace ilp::viewer {
namespace {

using json = nlohmann::ordered_json;

struct CoveredCells {
  std::vector<std::uint8_t> cover;  ///< bit k of byte n: cell 8 n + k has a height
  std::vector<float> height, sigma;
  std::vector<std::uint8_t> count;
  std::vector<std::uint16_t> source;
};

CoveredCells covered_cells(const map::GroundGrid& grid, std::int32_t stride, std::int32_t width, std::int32_t height) {
  const host::Raster<float>& sigma = grid.estimated_sigma();
  CoveredCells cells;
  cells.cover.resize((static_cast<std::size_t>(width) * static_cast<std::size_t>(height) + 7) / 8);
  std::size_t cell = 0;
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x, ++cell) {
      const std::size_t i = grid.height.index(x * stride, y * stride);
      if (!std::isfinite(grid.height.samples[i])) continue;
      cells.cover[cell / 8] = static_cast<std::uint8_t>(cells.cover[cell / 8] | (1U << (cell % 8)));
      cells.height.push_back(grid.height.samples[i]);
      cells.sigma.push_back(sigma.empty() ? std::numeric_limits<float>::quiet_NaN() : sigma.samples[i]);
      cells.count.push_back(static_cast<std::uint8_t>(std::min<int>(grid.count.samples[i], 255)));
      cells.source.push_back(grid.source.samples[i]);
    }
  }
  return cells;
}

/// Which cells have laid ground (bits as in CoveredCells), and its heights.
struct LaidCells {
  std::vector<std::uint8_t> cover;
  std::vector<float> height;
};

LaidCells laid_cells(const map::GroundGrid& grid, std::int32_t stride, std::int32_t width, std::int32_t height) {
  LaidCells cells;
  cells.cover.resize((static_cast<std::size_t>(width) * static_cast<std::size_t>(height) + 7) / 8);
  if (grid.laid.grey.empty()) return cells;
  std::size_t cell = 0;
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x, ++cell) {
      const std::size_t i = grid.height.index(x * stride, y * stride);
      if (std::isfinite(grid.height.samples[i]) || grid.laid.grey.samples[i] == 0) continue;
      cells.cover[cell / 8] = static_cast<std::uint8_t>(cells.cover[cell / 8] | (1U << (cell % 8)));
      cells.height.push_back(grid.laid.height.samples[i]);
    }
  }
  return cells;
}

/// The orthoimage with laid ground in it.
host::Raster<std::uint8_t> whole_ortho(const map::GroundGrid& grid) {
  host::Raster<std::uint8_t> ortho = grid.ortho;
  for (std::size_t i = 0; i < grid.laid.grey.samples.size(); ++i) {
    if (grid.source.samples[i] == 0) ortho.samples[i] = grid.laid.grey.samples[i];
  }
  return ortho;
}

/// Of the probability of a safe landing at each covered cell, per cent; 255 where it is not known.
std::vector<std::uint8_t> safe_cells(const map::GroundGrid& grid, const landing::LandingMap& landing,
                                     std::int32_t stride) {
  std::vector<std::uint8_t> safe;
  for (std::int32_t y = 0; y < grid.height.height; y += stride) {
    for (std::int32_t x = 0; x < grid.height.width; x += stride) {
      if (!std::isfinite(grid.height.at(x, y))) continue;
      const float share = landing.safe.at(x / landing.hazards.stride, y / landing.hazards.stride);
      safe.push_back(std::isfinite(share) ? static_cast<std::uint8_t>(std::lround(100 * share)) : 255);
    }
  }
  return safe;
}

json landing_of(const map::GroundGrid& grid, const landing::LandingMap& landing, std::int32_t stride) {
  return {{"footprint", landing.limits.footprint_m / landing.metres_per_unit},
          {"safe", host::base64(safe_cells(grid, landing, stride))}};
}

json surface(const map::GroundGrid& grid, const ViewerBudget& budget, std::size_t strips) {
  const std::int32_t stride = map::stride_for(grid, budget.vertices / std::max<std::size_t>(strips, 1));
  const std::int32_t width = (grid.height.width + stride - 1) / stride;
  const std::int32_t height = (grid.height.height + stride - 1) / stride;
  const CoveredCells cells = covered_cells(grid, stride, width, height);
  const std::int32_t side = std::max(grid.ortho.width, grid.ortho.height);
  const std::int32_t shrunk = (side + budget.texture_side_px - 1) / budget.texture_side_px;
  const host::Raster<std::uint8_t> texture =
      host::shrink(whole_ortho(grid), grid.ortho.width / shrunk, host::mean_grey);
  const LaidCells laid = laid_cells(grid, stride, width, height);
  return {{"width", width},
          {"height", height},
          {"stride", stride},
          {"x0", grid.x0},
          {"y0", grid.y0},
          {"cell", grid.cell * stride},
          {"full_cell", grid.cell},
          {"full_width", grid.height.width},
          {"full_height", grid.height.height},
          {"texture_stride", std::max(1, grid.ortho.width / std::max(1, grid.ortho.width / shrunk))},
          {"texture", host::data_uri(host::png_bytes(texture))},
          {"cover", host::base64(cells.cover)},
          {"heights", host::base64_of<float>(cells.height)},
          {"laid_cover", host::base64(laid.cover)},
          {"laid_heights", host::base64_of<float>(laid.height)},
          {"sigma", host::base64_of<float>(cells.sigma)},
          {"count", host::base64(cells.count)},
          {"source", host::base64_of<std::uint16_t>(cells.source)}};
}

std::string plan_picture(const report::Report& report, const report::StripResult& strip) {
  std::vector<Vec3> centres;
  for (const intake::TrackPoint& point : intake::track_of(report.flight, strip.strip)) centres.push_back(point.centre);
  const report::PlanView view = report::make_plan_view(&*strip.grid, centres, 1000, 600);
  return host::data_uri(host::png_bytes(report::ortho_picture(report::resample(*strip.grid, strip.plane, view))));
}

/// What the page makes the parts of a height's error of, beside that of matching (map/height_error.hpp).
json errors_of(const map::HeightErrors& errors) {
  json keyframes = json::array();
  for (const map::HeightErrors::OfKeyframe& k : errors.keyframes)
    keyframes.push_back({k.centre_z, k.centre_sigma_z, k.depth_share});
  return {{"keyframes", keyframes},
          {"middle", {errors.middle.x(), errors.middle.y(), errors.middle.z()}},
          {"scale", errors.scale_sigma},
          {"tilt", errors.tilt_sigma_rad},
          {"place", errors.place_sigma}};
}

/// Where the strip is on its body: longitude and latitude of the corners of the grid, which is small enough to lie
/// between them evenly, and heights as the rasters have them; null where it is not known.
json place_of(const report::StripResult& strip) {
  const exports::Georeference& place = strip.georeference;
  if (!place.on_a_body() || !strip.grid) return nullptr;
  const map::GroundGrid& grid = *strip.grid;
  const exports::GeographicFromMap degrees(place);
  json corners = json::array();
  for (const std::int32_t row : {0, grid.height.height - 1}) {
    for (const std::int32_t column : {0, grid.height.width - 1}) {
      const Vec3 at = place.map_from_world({grid.x0 + column * grid.cell, grid.y0 - row * grid.cell, 0});
      corners.push_back(degrees(at.x(), at.y()));
    }
  }
  return {{"body", place.body},
          {"above", place.height_name},
          {"scale", place.scale},
          {"height_of_0", place.height_of(0)},
          {"north", *place.north()},
          {"width", (grid.height.width - 1) * grid.cell},
          {"height", (grid.height.height - 1) * grid.cell},
          {"corners", corners}};
}

}  // namespace

json viewer_strip(const report::Report& report, const report::StripResult& strip, const ViewerBudget& budget) {
  json out = {{"keyframes", strip.strip.keyframes},
              {"errors", errors_of(strip.errors)},
              {"plane", {strip.plane.a, strip.plane.b, strip.plane.c}},
              {"place", place_of(strip)},
              {"grid", nullptr}};
  if (!strip.grid) return out;
  const auto with_grid = static_cast<std::size_t>(std::count_if(
      report.strips.begin(), report.strips.end(), [](const report::StripResult& s) { return s.grid.has_value(); }));
  out["grid"] = surface(*strip.grid, budget, with_grid);
  out["plan"] = plan_picture(report, strip);
  if (strip.landing && strip.landing->map)
    out["landing"] = landing_of(*strip.grid, *strip.landing->map, out["grid"]["stride"].get<std::int32_t>());
  return out;
}

}  // namespace ilp::viewer
