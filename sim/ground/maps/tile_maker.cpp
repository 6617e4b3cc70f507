#include "sim/ground/maps/tile_maker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "fsw/vision/codec/background_fill.hpp"
#include "fsw/vision/place/place_scratch.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::maps {
namespace {

constexpr std::int32_t patch_side = map_tile_side + 2 * tile_margin;
constexpr float light_of_ground = 128;      // grey of level ground of mean brightness
constexpr std::int32_t clear_of_holes = 8;  // cells between a feature and ground of which nothing is known
// Beyond it the bright side of what stands out is its other side, and the image is no help (map_sun_limit_rad).
constexpr double farthest_sun_rad = 1.05;

using Greys = host::Raster<std::uint8_t>;

Greys greys_of(const host::Raster<float>& light) {
  Greys greys(light.width, light.height);
  for (std::size_t i = 0; i < greys.samples.size(); ++i) {
    const float grey = std::round(light_of_ground * light.samples[i]);
    greys.samples[i] =
        std::isfinite(grey) ? static_cast<std::uint8_t>(std::clamp(grey, 1.0F, 255.0F)) : std::uint8_t{0};
  }
  return greys;
}

/// Whether everything near a cell is known.
bool is_clear(const Greys& greys, float x, float y) {
  const auto column = static_cast<std::int32_t>(std::lround(x)), row = static_cast<std::int32_t>(std::lround(y));
  for (std::int32_t dy = -clear_of_holes; dy <= clear_of_holes; ++dy) {
    for (std::int32_t dx = -clear_of_holes; dx <= clear_of_holes; ++dx) {
      if (greys.contains(column + dx, row + dy) && greys.at(column + dx, row + dy) == 0) return false;
    }
  }
  return true;
}

/// By map_feature_zoom, bilinear.
Greys enlarged(const std::vector<std::int32_t>& greys, std::int32_t width, std::int32_t height) {
  Greys larger(width * map_feature_zoom, height * map_feature_zoom);
  for (std::int32_t y = 0; y < larger.height; ++y) {
    const double v = std::clamp((y + 0.5) / map_feature_zoom - 0.5, 0.0, height - 1.0);
    const auto j = std::min(static_cast<std::int32_t>(v), height - 2);
    for (std::int32_t x = 0; x < larger.width; ++x) {
      const double u = std::clamp((x + 0.5) / map_feature_zoom - 0.5, 0.0, width - 1.0);
      const auto i = std::min(static_cast<std::int32_t>(u), width - 2);
      const auto at = [&](std::int32_t column, std::int32_t row) {
        return static_cast<double>(
            greys[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)]);
      };
      const double above = at(i, j) + (u - i) * (at(i + 1, j) - at(i, j));
      const double below = at(i, j + 1) + (u - i) * (at(i + 1, j + 1) - at(i, j + 1));
      larger.at(x, y) = static_cast<std::uint8_t>(std::lround(above + (v - j) * (below - above)));
    }
  }
  return larger;
}

/// The light under another sun, where the shading under both is known.
host::Raster<float> relit(host::Raster<float> light, const host::Raster<float>& from, const host::Raster<float>& to) {
  for (std::size_t i = 0; i < light.samples.size(); ++i) {
    const float change = std::max(to.samples[i], least_shading) / std::max(from.samples[i], least_shading);
    if (std::isfinite(from.samples[i] + to.samples[i])) light.samples[i] *= change;
  }
  return light;
}

std::size_t index_in_tile(std::int32_t row) {
  return static_cast<std::size_t>(row) * map_tile_side;
}

template <typename Values, typename Value>
std::size_t count_of(const Values& values, Value value) {
  return static_cast<std::size_t>(std::count(values.begin(), values.end(), value));
}

/// Posts in steps about their middle height, which is a multiple of the step: tiles beside each other have the same
/// posts on their common border.
void set_posts(const host::Raster<float>& posts, double step_m, MapTile& tile) {
  double lowest = std::numeric_limits<double>::max(), highest = -lowest;
  const auto at = [&](std::int32_t i, std::int32_t j) {
    constexpr std::int32_t margin = tile_margin / map_post_spacing;
    return double{posts.at(i + margin, j + margin)};
  };
  for (std::int32_t j = 0; j < map_tile_posts; ++j) {
    for (std::int32_t i = 0; i < map_tile_posts; ++i) {
      if (!std::isfinite(at(i, j))) continue;
      lowest = std::min(lowest, at(i, j));
      highest = std::max(highest, at(i, j));
    }
  }
  const bool any = lowest <= highest;
  tile.height_step_m = step_m;
  tile.height_offset_m = any ? std::round((lowest + highest) / 2 / step_m) * step_m : 0;
  if (any && (highest - lowest) / step_m > 65000) {
    throw std::runtime_error("heights from " + host::fixed(lowest, 1) + " to " + host::fixed(highest, 1) +
                             " m in one tile: check the missing values of the heights, or choose larger steps");
  }
  for (std::int32_t j = 0; j < map_tile_posts; ++j) {
    for (std::int32_t i = 0; i < map_tile_posts; ++i) {
      const double steps = std::round((at(i, j) - tile.height_offset_m) / step_m);
      tile.posts[static_cast<std::size_t>(j) * map_tile_posts + static_cast<std::size_t>(i)] =
          std::isfinite(steps) ? static_cast<std::int16_t>(steps) : unknown_post;
    }
  }
}

}  // namespace

struct TileMaker::Memory {
  MapTile tile;
  MapTileFeatures features;
  MapTileWorkspace workspace;
  HarrisWorkspace harris;
  PlaceFeatureWorkspace finder;
  PlaceFeatures found;
  std::vector<std::int32_t> samples, scratch = std::vector<std::int32_t>(limits::max_image_pixels);

  /// Features of a piece that are inside the tile.
  void find(const host::Raster<float>& light, std::size_t wanted, MapFeatures& features);
};

void TileMaker::Memory::find(const host::Raster<float>& light, std::size_t wanted, MapFeatures& kept) {
  kept.clear();
  if (wanted == 0) return;
  const Greys greys = greys_of(light);
  // The border of unknown ground must not look like texture.
  samples.assign(greys.samples.begin(), greys.samples.end());
  fill_background({samples.data(), greys.width, greys.height}, greys.view(), scratch.data());
  const Greys picture = enlarged(samples, greys.width, greys.height);
  const std::size_t in_patch = wanted * patch_side * patch_side / map_tile_pixels;
  host::require(
      find_place_features(picture.view(), std::min(in_patch, limits::max_place_features), harris, finder, found),
      "features of a tile");
  for (PlaceFeature feature : found) {
    feature.x = (feature.x + 0.5F) / map_feature_zoom - 0.5F;
    feature.y = (feature.y + 0.5F) / map_feature_zoom - 0.5F;
    if (!is_clear(greys, feature.x, feature.y)) continue;
    feature.x -= tile_margin;
    feature.y -= tile_margin;
    constexpr float first = -0.5F, last = map_tile_side - 0.5F;
    if (feature.x < first || feature.y < first || feature.x >= last || feature.y >= last) continue;
    if (kept.size() == wanted || !kept.push_back(feature)) break;
  }
}

PatchArea area_of_tile(std::int32_t row, std::int32_t column) {
  return {column * map_tile_side - tile_margin, row * map_tile_side - tile_margin, patch_side, patch_side};
}

TileMaker::TileMaker(const TileParams& params) : params_(params), memory_(std::make_unique<Memory>()) {}
TileMaker::~TileMaker() = default;

TileMaker::Made TileMaker::make(const MapLayer& layer, const MapTilePlace& place, MapPatch patch) {
  MapTile& tile = memory_->tile;
  tile.layer = place.layer;
  tile.row = place.row;
  tile.column = place.column;
  const host::Raster<float> heights = heights_of_cells(patch.posts, patch_side, patch_side);
  Made made;
  const host::Raster<float> shading = shading_of(heights, layer.pixel_m, params_.sun);
  const Sun flight_sun = params_.flight_sun.value_or(params_.sun);
  const host::Raster<float> shape = shading_of(heights, layer.pixel_m, flight_sun);
  const host::Raster<float> light = relit(patch.light, shading, shape);
  made.rough_as_imaged = made.rough_flat = roughness_of(patch.light, shading);
  if (params_.flat) {
    flatten(patch.light, shading);
    made.rough_flat = roughness_of(patch.light, shading);
  }
  const Greys greys = greys_of(patch.light);
  for (std::int32_t y = 0; y < map_tile_side; ++y) {
    std::copy_n(&greys.at(tile_margin, y + tile_margin), map_tile_side, &tile.image[index_in_tile(y)]);
  }
  set_posts(patch.posts, params_.height_step_px * layer.pixel_m, tile);
  made.known_cells = map_tile_pixels - count_of(tile.image, std::uint8_t{0});
  made.known_posts = map_tile_post_count - count_of(tile.posts, unknown_post);
  if (made.known_cells == 0 && made.known_posts == 0) return made;
  const double turn = std::remainder(flight_sun.azimuth_rad - params_.sun.azimuth_rad, 2 * std::numbers::pi);
  const bool near = std::fabs(turn) < farthest_sun_rad;
  memory_->find(light, near ? params_.features : 0, memory_->features.image);
  memory_->find(shape, near ? 0 : params_.features, memory_->features.shape);
  MapTileCoding coding;
  coding.image_bytes = static_cast<std::size_t>(params_.image_bits * map_tile_pixels / 8);
  made.file.resize(limits::max_map_tile_bytes);
  std::size_t size = 0;
  host::require(encode_map_tile(tile, memory_->features, 0, coding, memory_->workspace, made.file, size),
                "tile " + std::to_string(place.row) + ", " + std::to_string(place.column));
  made.file.resize(size);
  return made;
}

}  // namespace ilp::maps
