#include "sim/ground/maps/tile_maker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "fsw/vision/codec/background_fill.hpp"
#include "fsw/vision/place/place_scratch.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::maps {
namespace {

constexpr std::int32_t piece_side = map_tile_side + 2 * tile_margin;
constexpr float light_of_ground = 128;      // grey of level ground of mean brightness
constexpr std::int32_t clear_of_holes = 8;  // cells between a feature and ground of which nothing is known

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
  void find(const Greys& greys, std::size_t wanted, MapFeatures& features);
};

void TileMaker::Memory::find(const Greys& greys, std::size_t wanted, MapFeatures& kept) {
  kept.clear();
  if (wanted == 0) return;
  // The border of unknown ground must not look like texture.
  samples.assign(greys.samples.begin(), greys.samples.end());
  fill_background({samples.data(), greys.width, greys.height}, greys.view(), scratch.data());
  Greys filled(greys.width, greys.height);
  std::transform(samples.begin(), samples.end(), filled.samples.begin(),
                 [](std::int32_t grey) { return static_cast<std::uint8_t>(grey); });
  const std::size_t in_piece = wanted * piece_side * piece_side / map_tile_pixels;
  host::require(
      find_place_features(filled.view(), std::min(in_piece, limits::max_place_features), harris, finder, found),
      "features of a tile");
  for (PlaceFeature feature : found) {
    if (!is_clear(greys, feature.x, feature.y)) continue;
    feature.x -= tile_margin;
    feature.y -= tile_margin;
    constexpr float first = -0.5F, last = map_tile_side - 0.5F;
    if (feature.x < first || feature.y < first || feature.x >= last || feature.y >= last) continue;
    if (kept.size() == wanted || !kept.push_back(feature)) break;
  }
}

PieceArea area_of_tile(std::int32_t row, std::int32_t column) {
  return {column * map_tile_side - tile_margin, row * map_tile_side - tile_margin, piece_side, piece_side};
}

TileMaker::TileMaker(const TileParams& params) : params_(params), memory_(std::make_unique<Memory>()) {}
TileMaker::~TileMaker() = default;

TileMaker::Made TileMaker::make(const MapLayer& layer, const MapTilePlace& place, MapPiece piece) {
  MapTile& tile = memory_->tile;
  tile.layer = place.layer;
  tile.row = place.row;
  tile.column = place.column;
  const host::Raster<float> heights = heights_of_cells(piece.posts, piece_side, piece_side);
  if (params_.flat) flatten(piece.light, shading_of(heights, layer.pixel_m, params_.sun));
  const Greys greys = greys_of(piece.light);
  for (std::int32_t y = 0; y < map_tile_side; ++y) {
    std::copy_n(&greys.at(tile_margin, y + tile_margin), map_tile_side, &tile.image[index_in_tile(y)]);
  }
  set_posts(piece.posts, params_.height_step_px * layer.pixel_m, tile);
  Made made;
  made.known_cells = map_tile_pixels - count_of(tile.image, std::uint8_t{0});
  made.known_posts = map_tile_post_count - count_of(tile.posts, unknown_post);
  if (made.known_cells == 0 && made.known_posts == 0) return made;
  memory_->find(greys, params_.features, memory_->features.image);
  const host::Raster<float> shape = shading_of(heights, layer.pixel_m, params_.flight_sun.value_or(params_.sun));
  memory_->find(greys_of(shape), params_.features, memory_->features.shape);
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
