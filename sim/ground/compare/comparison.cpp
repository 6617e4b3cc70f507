#include "sim/ground/compare/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "sim/ground/compare/comparison_files.hpp"
#include "sim/host/files.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::compare {
namespace {
namespace fs = std::filesystem;

using host::brief;
using host::fixed;

/// The raster of this name beside the heights of a map; null without one.
std::unique_ptr<HeightModel> raster_beside(const HeightModel& map, const std::string& raster) {
  const std::string name = map.path().filename().string();
  const std::string heights = "height";
  if (!name.starts_with(heights)) return nullptr;
  const fs::path path = map.path().parent_path() / (raster + name.substr(heights.size()));
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return nullptr;
  auto sigma = std::make_unique<HeightModel>(path);
  const bool fits = sigma->columns() == map.columns() && sigma->rows() == map.rows();
  return fits ? std::move(sigma) : nullptr;
}

/// Where the corners of the map lie, in pixels of the other model.
std::string place_of_map(const HeightModel& map, const HeightModel& other, const ModelFrames& frames) {
  std::vector<double> x, y;
  for (const std::int32_t column : {0, map.columns() - 1}) {
    for (const std::int32_t row : {0, map.rows() - 1}) {
      const Vec3 corner = frames.common_from_map() * map_point(map, column, row, 0);
      x.push_back(corner.x());
      y.push_back(corner.y());
    }
  }
  frames.to_pixels(x, y);
  const auto [x0, x1] = std::minmax_element(x.begin(), x.end());
  const auto [y0, y1] = std::minmax_element(y.begin(), y.end());
  return "the map lies at its columns " + fixed(*x0, 0) + " to " + fixed(*x1, 0) + " and rows " + fixed(*y0, 0) +
         " to " + fixed(*y1, 0) + ", and it has " + host::size_text(other.columns(), other.rows()) + " pixels";
}

[[noreturn]] void refuse_nothing_common(const Comparison& c, const HeightModel& map, const HeightModel& other,
                                        const ModelFrames& frames) {
  if (c.counts.outside + c.counts.without_other + c.counts.steep == 0) {
    throw std::runtime_error(c.map.string() + ": no cell of the map has a height");
  }
  if (c.counts.steep > 0) {
    throw std::runtime_error(c.other.string() + ": all common ground is steeper than " +
                             fixed(c.max_slope_rad * 180 / std::numbers::pi, 0) + " degrees (--max-slope)");
  }
  if (c.counts.without_other > 0) {
    throw std::runtime_error(c.other.string() + ": the model has no heights where the map has them (no data)");
  }
  throw std::runtime_error(c.other.string() + ": the models do not overlap: " + place_of_map(map, other, frames));
}

std::string share_text(std::uint64_t part, std::uint64_t all) {
  return all == 0 ? "-" : fixed(100 * static_cast<double>(part) / static_cast<double>(all), 1) + " %";
}

std::string vector_text(const Vec3& v) {
  return brief(v.x()) + ", " + brief(v.y()) + ", " + brief(v.z()) + " m";
}

std::string shift_text(const HeightAlignment& a, Fit fit) {
  if (!a.aligned) return "not aligned";
  std::string text = "the map was moved by " + vector_text(a.shift) + " (x, y, up)";
  if (fit == Fit::similarity) {
    text += ", scaled by " + fixed(a.moved.scale, 6) + " and turned by " +
            fixed(a.turn_rad.norm() * 180 / std::numbers::pi, 3) + " degrees";
  }
  return text + "; two halves of the ground differ by " + vector_text(a.residual);
}

}  // namespace

fs::path find_map(const fs::path& path, int strip) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) return path;
  const std::string name = strip > 1 ? "height-strip-" + std::to_string(strip) + ".tif" : "height.tif";
  for (const fs::path& folder : {path, path / "ground"}) {
    if (fs::exists(folder / name, ignored)) return folder / name;
  }
  throw std::runtime_error(path.string() + ": the folder has neither " + name + " nor ground/" + name +
                           "; ilp-ground writes it where depths have come down");
}

Comparison compare_heights(const ComparisonOptions& options) {
  Comparison c;
  c.map = find_map(options.map, options.strip);
  c.other = options.other;
  c.out = options.out.empty() ? c.map.parent_path() / "comparison" : options.out;
  c.max_slope_rad = options.alignment.max_slope_rad;
  c.fit = options.alignment.fit;
  HeightModel map(c.map), other(c.other);
  const ModelFrames frames(map, other, options.frame);
  const std::unique_ptr<HeightModel> sigma = raster_beside(map, "sigma"),
                                     matching = raster_beside(map, "sigma-matching");
  c.has_sigma = sigma != nullptr;
  c.alignment = align_heights(map, other, frames, options.alignment);
  host::make_output_folder(c.out);
  DifferenceResult result = write_difference(map, {sigma.get(), matching.get()}, other, frames, c.alignment.moved,
                                             c.max_slope_rad, c.out / "difference.tif");
  c.counts = result.counts;
  if (c.counts.compared == 0) {
    fs::remove(c.out / "difference.tif");
    refuse_nothing_common(c, map, other, frames);
  }
  c.overview = std::move(result.overview);
  c.cell = side_of_pixel(map) * frames.common_from_map().scale * c.alignment.moved.scale;
  c.other_cell = result.other_cell;
  c.difference = statistics_of(c.out / "difference.tif");
  c.remarks = frames.remarks();
  c.remarks.insert(c.remarks.end(), c.alignment.remarks.begin(), c.alignment.remarks.end());
  write_comparison_files(c);
  return c;
}

std::vector<std::string> summary_of(const Comparison& c) {
  const DifferenceStatistics& d = c.difference;
  const CellCounts& n = c.counts;
  const std::uint64_t mapped = n.outside + n.without_other + n.steep + n.compared;
  std::vector<std::string> lines{
      "shift      " + shift_text(c.alignment, c.fit),
      "before     median " + brief(c.alignment.before.median) + " m, RMSE " + brief(c.alignment.before.rmse) +
          " m, NMAD " + brief(c.alignment.before.nmad) + " m, of " + std::to_string(c.alignment.before.cells) +
          " samples",
      "difference mean " + brief(d.mean) + " m, median " + brief(d.median) + " m, RMSE " + brief(d.rmse) + " m, NMAD " +
          brief(d.nmad) + " m",
      "absolute   68.3 % below " + brief(d.abs_68) + " m, 95 % below " + brief(d.abs_95) + " m",
      "compared   " + std::to_string(n.compared) + " of " + std::to_string(mapped) +
          " cells with a height; left out: " + std::to_string(n.outside) + " outside the other model, " +
          std::to_string(n.without_other) + " where it has no data, " + std::to_string(n.steep) + " steeper than " +
          fixed(c.max_slope_rad * 180 / std::numbers::pi, 0) + " degrees"};
  if (n.sigma.stated > 0) {
    lines.push_back("sigma      " + share_text(n.sigma.one, n.sigma.stated) + " within one estimated sigma, " +
                    share_text(n.sigma.two, n.sigma.stated) + " within two");
  }
  if (n.matching.stated > 0) {
    lines.push_back("matching   " + share_text(n.matching.one, n.matching.stated) + " within one sigma of matching, " +
                    share_text(n.matching.two, n.matching.stated) + " within two");
  }
  for (const std::string& remark : c.remarks) lines.push_back("remark     " + remark);
  lines.push_back("page       " + (c.out / "comparison.html").string());
  return lines;
}

}  // namespace ilp::compare
