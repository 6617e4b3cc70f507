#include "sim/world/heightmap.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "sim/host/geo_raster.hpp"
#include "sim/world/lattice_noise.hpp"

namespace ilp::world {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void fail(const std::string& file, const std::string& what) {
  throw std::runtime_error(file + ": " + what);
}

bool begins_with(const fs::path& path, std::string_view magic) {
  std::ifstream in(path, std::ios::binary);
  std::string begin(magic.size(), '\0');
  in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return in && begin == magic;
}

host::GeoRaster read_file(const fs::path& path) {
  if (fs::is_directory(path)) fail(path, "a folder; a GeoTIFF, PFM or PNG expected");
  if (host::is_raster_file(path)) return host::read_raster(path);
  if (begins_with(path, "Pf")) return {host::read_pfm(path), std::nullopt};
  fail(path, "neither GeoTIFF nor one-channel PFM nor PNG");
}

host::GeoRaster read_map(const std::string& file, const WorldParams& world) {
  host::GeoRaster raster = read_file(file);
  if (world.map_georeferenced && !raster.place) {
    fail(file, "does not know its place; map_georeferenced = false expected");
  }
  if (raster.values.width < 2 || raster.values.height < 2) fail(file, "a map of less than 2x2 pixels");
  const auto holes = std::count_if(raster.values.samples.begin(), raster.values.samples.end(),
                                   [](float value) { return !std::isfinite(value); });
  if (holes > 0) {
    const std::string count =
        std::to_string(holes) + " of " + std::to_string(raster.values.samples.size()) + " pixels have no value";
    if (!world.fill_holes) fail(file, count + "; world.fill_holes = true gives them one from their neighbours");
    if (!fill_holes(raster.values)) fail(file, count);
  }
  if (world.map_spacing_m > 0) {
    if (!raster.place) raster.place.emplace();
    raster.place->spacing_x = raster.place->spacing_y = world.map_spacing_m;
  }
  return raster;
}

struct Corner {
  double x, y;
};

/// First pixel of a map whose centre lies at (x, y).
Corner corner_of(const host::Raster<float>& values, double spacing_x, double spacing_y, double x, double y) {
  return {x - 0.5 * (values.width - 1) * spacing_x, y + 0.5 * (values.height - 1) * spacing_y};
}

double mean_of(const host::Raster<float>& values) {
  double sum = 0;
  for (const float value : values.samples) sum += value;
  return sum / static_cast<double>(values.samples.size());
}

/// A coordinate in [0, last], mirrored at both ends.
double mirrored(double at, int last) {
  const double period = 2.0 * last;
  double folded = at - period * std::floor(at / period);
  if (folded > last) folded = period - folded;
  return std::clamp<double>(folded, 0, last);
}

}  // namespace

Heightmap::Heightmap(host::Raster<float> values, double spacing_x_m, double spacing_y_m, double first_x_m,
                     double first_y_m, const std::string& name)
    : values_(std::move(values)),
      spacing_x_(spacing_x_m),
      spacing_y_(spacing_y_m),
      first_x_(first_x_m),
      first_y_(first_y_m) {
  if (values_.width < 2 || values_.height < 2) throw std::invalid_argument(name + ": at least 2x2 values expected");
  if (!(spacing_x_ > 0 && spacing_y_ > 0)) throw std::invalid_argument(name + ": positive spacings expected");
  lowest_ = std::numeric_limits<double>::max();
  highest_ = -lowest_;
  for (const float value : values_.samples) {
    if (!std::isfinite(value)) throw std::invalid_argument(name + ": a value that is not a number");
    lowest_ = std::min<double>(lowest_, value);
    highest_ = std::max<double>(highest_, value);
  }
  mean_ = mean_of(values_);
}

double Heightmap::at(double x, double y) const {
  const double u = mirrored((x - first_x_) / spacing_x_, values_.width - 1);
  const double v = mirrored((first_y_ - y) / spacing_y_, values_.height - 1);
  const int i = std::min(static_cast<int>(u), values_.width - 2);
  const int j = std::min(static_cast<int>(v), values_.height - 2);
  const double a = values_.at(i, j);
  const double b = values_.at(i + 1, j);
  const double c = values_.at(i, j + 1);
  const double d = values_.at(i + 1, j + 1);
  const double near = a + (b - a) * (u - i);
  const double far = c + (d - c) * (u - i);
  return near + (far - near) * (v - j);
}

bool fill_holes(host::Raster<float>& values) {
  const auto neighbours = [&](std::size_t k, auto visit) {
    const int x = static_cast<int>(k % static_cast<std::size_t>(values.width));
    const int y = static_cast<int>(k / static_cast<std::size_t>(values.width));
    for (int j = std::max(0, y - 1); j <= std::min(values.height - 1, y + 1); ++j) {
      for (int i = std::max(0, x - 1); i <= std::min(values.width - 1, x + 1); ++i) {
        if (i != x || j != y) visit(&values.at(i, j) - values.samples.data());
      }
    }
  };
  std::vector<std::size_t> rim;
  for (std::size_t k = 0; k < values.samples.size(); ++k) {
    if (!std::isfinite(values.samples[k])) rim.push_back(k);
  }
  if (rim.size() == values.samples.size()) return false;
  // From the second round on only neighbours of what was filled can have values around them.
  std::vector<std::pair<std::size_t, float>> filled;
  while (!rim.empty()) {
    filled.clear();
    for (const std::size_t k : rim) {
      double sum = 0;
      int count = 0;
      neighbours(k, [&](std::ptrdiff_t n) {
        const float value = values.samples[static_cast<std::size_t>(n)];
        if (!std::isfinite(value)) return;
        sum += value;
        ++count;
      });
      if (count > 0) filled.emplace_back(k, static_cast<float>(sum / count));
    }
    for (const auto& [k, value] : filled) values.samples[k] = value;
    rim.clear();
    for (const auto& [k, value] : filled) {
      neighbours(k, [&](std::ptrdiff_t n) {
        const auto at = static_cast<std::size_t>(n);
        if (!std::isfinite(values.samples[at])) rim.push_back(at);
      });
    }
    std::sort(rim.begin(), rim.end());
    rim.erase(std::unique(rim.begin(), rim.end()), rim.end());
  }
  return true;
}

ImportedGround load_ground(const WorldParams& world) {
  ImportedGround ground;
  std::optional<host::RasterPlace> heights_place;  // as the file says
  if (!world.heightmap.empty()) {
    host::GeoRaster raster = read_map(world.heightmap, world);
    if (!raster.place) fail(world.heightmap, "does not say its spacing; map_spacing_m expected");
    const host::RasterPlace& place = *raster.place;
    heights_place = place;
    const auto unit = static_cast<float>(world.map_height_unit_m);
    for (float& value : raster.values.samples) value *= unit;
    Corner corner{place.x, place.y};
    if (!world.map_georeferenced) {
      corner = corner_of(raster.values, place.spacing_x, place.spacing_y, world.map_x_m, world.map_y_m);
      const auto level = static_cast<float>(mean_of(raster.values));
      for (float& value : raster.values.samples) value -= level;
    }
    ground.heights.emplace(std::move(raster.values), place.spacing_x, place.spacing_y, corner.x, corner.y,
                           world.heightmap);
  }
  if (world.albedo_map.empty()) return ground;

  host::GeoRaster raster = read_map(world.albedo_map, world);
  const double mean = mean_of(raster.values);
  const float least = *std::min_element(raster.values.samples.begin(), raster.values.samples.end());
  if (least < 0 || !(mean > 0)) fail(world.albedo_map, "brightness below zero, or zero everywhere");
  for (float& value : raster.values.samples) value = static_cast<float>(value / mean);
  const bool with_heights = ground.heights.has_value();
  if (!raster.place || (with_heights && world.map_spacing_m > 0)) {
    if (!with_heights) fail(world.albedo_map, "does not say its spacing; map_spacing_m expected");
    const Heightmap& heights = *ground.heights;
    const double spacing_x = heights.width_m() / (raster.values.width - 1);
    const double spacing_y = heights.height_m() / (raster.values.height - 1);
    ground.brightness.emplace(std::move(raster.values), spacing_x, spacing_y, heights.first_x(), heights.first_y(),
                              world.albedo_map);
    return ground;
  }
  const host::RasterPlace& place = *raster.place;
  Corner corner{place.x, place.y};
  if (with_heights) {
    corner.x += ground.heights->first_x() - heights_place->x;
    corner.y += ground.heights->first_y() - heights_place->y;
  } else if (!world.map_georeferenced) {
    corner = corner_of(raster.values, place.spacing_x, place.spacing_y, world.map_x_m, world.map_y_m);
  }
  ground.brightness.emplace(std::move(raster.values), place.spacing_x, place.spacing_y, corner.x, corner.y,
                            world.albedo_map);
  return ground;
}

}  // namespace ilp::world
