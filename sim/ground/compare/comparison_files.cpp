#include "sim/ground/compare/comparison_files.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "sim/ground/report/json_writer.hpp"
#include "sim/ground/report/map_pictures.hpp"
#include "sim/ground/report/page.hpp"
#include "sim/host/files.hpp"
#include "sim/host/picture.hpp"

namespace ilp::compare {
namespace {

using nlohmann::json;

json number(double value) {
  return std::isfinite(value) ? json(value) : json();
}

json reported(const Vec3& v) {
  return {number(v.x()), number(v.y()), number(v.z())};
}

json reported(const SpreadOfHeights& s) {
  return {{"samples", s.cells},
          {"mean_m", number(s.mean)},
          {"median_m", number(s.median)},
          {"rmse_m", number(s.rmse)},
          {"nmad_m", number(s.nmad)}};
}

json share(std::uint64_t part, std::uint64_t all) {
  return all == 0 ? json() : json(static_cast<double>(part) / static_cast<double>(all));
}

json within(const CellCounts::Within& counts) {
  return {{"cells", counts.stated},
          {"within_1", share(counts.one, counts.stated)},
          {"within_2", share(counts.two, counts.stated)}};
}

json histogram_json(const HeightHistogram& h) {
  return {{"low_m", h.low}, {"bin_m", h.width}, {"counts", h.counts}, {"outside", h.outside}};
}

json alignment_json(const Comparison& c) {
  const HeightAlignment& a = c.alignment;
  return {{"fit", c.fit == Fit::none ? "none" : (c.fit == Fit::shift ? "shift" : "similarity")},
          {"aligned", a.aligned},
          {"horizontal_determined", a.horizontal},
          {"shift_m", reported(a.shift)},
          {"scale", a.moved.scale},
          {"turn_rad", reported(a.turn_rad)},
          {"residual_shift_of_halves_m", reported(a.residual)},
          {"before", reported(a.before)},
          {"after", reported(a.after)}};
}

json comparison_json(const Comparison& c) {
  const DifferenceStatistics& d = c.difference;
  const CellCounts& n = c.counts;
  return {{"map", c.map.string()},
          {"other", c.other.string()},
          {"alignment", alignment_json(c)},
          {"cell_m", c.cell},
          {"other_cell_m", c.other_cell},
          {"difference",
           {{"count", d.count},
            {"mean_m", d.mean},
            {"median_m", d.median},
            {"deviation_m", d.deviation},
            {"rmse_m", d.rmse},
            {"nmad_m", d.nmad},
            {"abs_68_m", d.abs_68},
            {"abs_95_m", d.abs_95},
            {"least_m", d.least},
            {"most_m", d.most}}},
          {"histogram", histogram_json(d.histogram)},
          {"cells",
           {{"compared", n.compared},
            {"without_height", n.without_height},
            {"outside_other", n.outside},
            {"without_other", n.without_other},
            {"steep", n.steep},
            {"max_slope_deg", c.max_slope_rad * 180 / std::numbers::pi}}},
          {"sigma", within(n.sigma)},
          {"matching", within(n.matching)},
          {"remarks", c.remarks}};
}

/// A grid of the report's pictures, with rows from the north.
map::GroundGrid grid_of(const host::Raster<float>& values, double cell) {
  map::GroundGrid grid(0, 0, cell, values.width, values.height);
  grid.height = values;
  for (std::size_t i = 0; i < values.samples.size(); ++i) {
    grid.count.samples[i] = std::isfinite(values.samples[i]) ? 1 : 0;
  }
  return grid;
}

struct Picture {
  host::Raster<host::Rgba> pixels;
  report::PlanView view;
  host::ValueRange range;
  double exaggeration = 1;
};

/// The shape of the ground by its shade, the difference by its colour.
Picture draw(const Comparison& c) {
  const map::GroundGrid heights = grid_of(c.overview.height, c.overview.cell);
  const map::GroundGrid differences = grid_of(c.overview.difference, c.overview.cell);
  Picture picture;
  picture.view = report::make_plan_view(&heights, {}, 1400, 1000);
  report::ViewSurface surface = report::resample(heights, map::mean_plane(heights), picture.view);
  picture.exaggeration = surface.exaggeration;
  surface.relief = report::resample(differences, map::Plane{}, picture.view).relief;
  const double side = std::max(c.difference.abs_95, 1e-6);
  picture.range = {-side, side};
  picture.pixels = report::relief_picture(surface, picture.range, host::diverging);
  return picture;
}

void write_page(const Comparison& c, const Picture& picture, std::ostream& out) {
  const std::string title = "Heights of " + c.map.filename().string() + " against " + c.other.filename().string();
  const auto write_data = [&](std::ostream& to) {
    report::JsonWriter page(to, report::JsonStyle::compact);
    page.put("title", title);
    page.put("lines", summary_of(c));
    page.put("histogram", histogram_json(c.difference.histogram));
    page.put("picture", report::coloured_picture_json(picture.view, host::data_uri(host::png_bytes(picture.pixels)),
                                                      picture.range, host::diverging));
    page.put("exaggeration", picture.exaggeration);
    page.end();
  };
  report::write_page(title, "<code>comparison.json</code> and <code>difference.png</code> beside it have the figures.",
                     {{"comparison", write_data}}, out);
}

}  // namespace

void write_comparison_files(const Comparison& c) {
  const Picture picture = draw(c);
  host::update_file(c.out / "difference.png", host::png_bytes(picture.pixels));
  host::update_file(c.out / "comparison.json", comparison_json(c).dump(1) + "\n");
  host::update_file(c.out / "comparison.html", [&](std::ostream& out) { write_page(c, picture, out); });
}

}  // namespace ilp::compare
