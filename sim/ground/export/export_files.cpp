#include "sim/ground/export/export_files.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "sim/host/colour_map.hpp"
#include "sim/host/files.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/safe_name.hpp"

namespace ilp::exports {
namespace {

constexpr float nothing = std::numeric_limits<float>::infinity();

host::Raster<float> depth_of(const host::Raster<float>& inverse) {
  host::Raster<float> depth(inverse.width, inverse.height, nothing);
  for (std::size_t i = 0; i < inverse.samples.size(); ++i) {
    if (inverse.samples[i] > 0) depth.samples[i] = 1 / inverse.samples[i];
  }
  return depth;
}

// North-up: cell centres, rows downwards.
std::string world_file(const map::GroundGrid& grid) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "%.12g\n0\n0\n%.12g\n%.12g\n%.12g\n", grid.cell, -grid.cell, grid.x0,
                grid.y0);
  return text.data();
}

void write_map(host::Raster<float> map, const std::filesystem::path& path) {
  for (float& value : map.samples) {
    if (!std::isfinite(value)) value = nothing;
  }
  host::write_pfm(path, map.view());
}

}  // namespace

void export_keyframe(std::int64_t id, const intake::KeyframeRasters& rasters, const std::filesystem::path& folder) {
  const std::string base = host::six_digits(id);
  if (!rasters.image.empty()) host::write_file(folder / (base + "-image.png"), host::png_bytes(rasters.image));
  if (!rasters.mask.empty()) host::write_file(folder / (base + "-mask.png"), host::png_bytes(rasters.mask));
  if (rasters.inverse_depth.empty()) return;
  const host::Raster<float> depth = depth_of(rasters.inverse_depth);
  host::write_file(folder / (base + "-depth.png"),
                   host::png_bytes(host::colour_mapped(depth, host::display_range(depth))));
  host::write_pfm(folder / (base + "-depth.pfm"), depth.view());
}

bool keyframe_is_exported(const intake::Keyframe& keyframe, const std::filesystem::path& folder) {
  const std::string base = host::six_digits(keyframe.id);
  const auto there = [&](const char* suffix) {
    std::error_code error;
    return std::filesystem::exists(folder / (base + suffix), error);
  };
  if (keyframe.has_image() && !there("-image.png")) return false;
  if (keyframe.has_mask() && !there("-mask.png")) return false;
  return !keyframe.has_depth() || (there("-depth.png") && there("-depth.pfm"));
}

void export_grid(const map::GroundGrid& grid, const std::string& suffix, const std::filesystem::path& folder) {
  write_map(grid.height, folder / ("height" + suffix + ".pfm"));
  write_map(grid.sigma, folder / ("sigma" + suffix + ".pfm"));
  host::write_file(folder / ("ortho" + suffix + ".png"), host::png_bytes(grid.ortho));
  host::write_file(folder / ("ortho" + suffix + ".pgw"), world_file(grid));
  host::Raster<std::uint8_t> count(grid.count.width, grid.count.height);
  for (std::size_t i = 0; i < count.samples.size(); ++i) {
    count.samples[i] = static_cast<std::uint8_t>(std::min<int>(grid.count.samples[i], 255));
  }
  host::write_file(folder / ("count" + suffix + ".png"), host::png_bytes(count));
}

}  // namespace ilp::exports
