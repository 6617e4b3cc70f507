// Pictures of a strip's map for the page, x to the right and y up.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/ground/report/plan_view.hpp"
#include "sim/ground/serve/live_items.hpp"
#include "sim/host/digest.hpp"
#include "sim/host/picture.hpp"

namespace ilp::serve {
namespace {

constexpr std::int32_t picture_side_px = 1200;

report::PlanView upright_view(const map::GroundGrid& grid) {
  const double width = grid.count.width * grid.cell, height = grid.count.height * grid.cell;
  report::PlanView view;
  view.unit_per_px = std::max(grid.cell, std::max(width, height) / picture_side_px);
  view.width = std::max(1, static_cast<std::int32_t>(std::ceil(width / view.unit_per_px)));
  view.height = std::max(1, static_cast<std::int32_t>(std::ceil(height / view.unit_per_px)));
  view.along_low = grid.x0;
  view.across_high = grid.y0;
  return view;
}

// The path carries the content's digest, so that a browser keeps a picture until it changes.
std::string keep(const std::string& name, const host::Raster<host::Rgba>& picture, Pictures& pictures) {
  auto png = std::make_shared<const std::vector<std::uint8_t>>(host::png_bytes(picture));
  const std::string_view bytes(reinterpret_cast<const char*>(png->data()), png->size());
  std::string path = "/map/" + name + "-" + host::digest_text(host::digest(bytes)) + ".png";
  pictures[path] = std::move(png);
  return path;
}

}  // namespace

nlohmann::ordered_json map_item(const report::StripResult& strip, Pictures& pictures) {
  const report::PlanView view = upright_view(*strip.grid);
  const report::ViewSurface surface = report::resample(*strip.grid, strip.plane, view);
  const host::ValueRange range = host::display_range(surface.relief);
  const std::string name = std::to_string(strip.strip.id);
  return {{"x", view.along_low - view.unit_per_px / 2},
          {"y", view.across_high + view.unit_per_px / 2},
          {"unit_per_px", view.unit_per_px},
          {"size", {view.width, view.height}},
          {"image", keep(name + "-image", report::ortho_picture(surface), pictures)},
          {"relief", keep(name + "-relief", report::relief_picture(surface, range), pictures)},
          {"range", {range.low, range.high}},
          {"laid", std::any_of(surface.laid.samples.begin(), surface.laid.samples.end(),
                               [](float z) { return std::isfinite(z); })}};
}

}  // namespace ilp::serve
