#include "sim/world/orbital_map.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/host/parallel.hpp"
#include "sim/world/lattice_noise.hpp"

namespace ilp::world {
namespace {

constexpr std::int32_t block_side = 64;  // pixels that are rendered at once
constexpr double margin_px = 3;          // around a block: point spread, and the squares of posts
constexpr std::int32_t posts_of_block = block_side / map_posts_apart;

/// The part of the normal distribution below x.
double normal_below(double x) {
  return 0.5 * std::erfc(-x / std::numbers::sqrt2);
}

/// A random number of mean 0 and variance 1 at a lattice point (Box and Muller, 1958).
double normal_at(std::int32_t i, std::int32_t j, std::uint32_t seed) {
  const double u = (lattice_hash(i, j, seed) + 0.5) / 4294967296.0;
  const double v = (lattice_hash(i, j, seed ^ 0x5F356495U) + 0.5) / 4294967296.0;
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

/// Normal numbers on a lattice, smoothed by a Gaussian of one post, of variance 1.
double smooth_error(std::int32_t i, std::int32_t j, std::uint32_t seed) {
  constexpr std::int32_t radius = 3;
  double sum = 0, squares = 0;
  for (std::int32_t dj = -radius; dj <= radius; ++dj) {
    for (std::int32_t di = -radius; di <= radius; ++di) {
      const double weight = std::exp(-0.5 * (di * di + dj * dj));
      sum += weight * normal_at(i + di, j + dj, seed);
      squares += weight * weight;
    }
  }
  return sum / std::sqrt(squares);
}

/// The weights of the world's posts in a mean about a place, along one axis.
struct Weights {
  std::int32_t first = 0;  ///< post
  std::vector<double> of;
};

/// About `centre`: a box of `box` smoothed by a Gaussian of `spread`, all in posts.
Weights weights_about(double centre, double box, double spread) {
  const double reach = box / 2 + 3 * spread;
  Weights weights;
  weights.first = static_cast<std::int32_t>(std::ceil(centre - reach));
  double sum = 0;
  for (std::int32_t post = weights.first; post <= centre + reach; ++post) {
    const double d = post - centre;
    weights.of.push_back(normal_below((d + box / 2) / spread) - normal_below((d - box / 2) / spread));
    sum += weights.of.back();
  }
  for (double& weight : weights.of) weight /= sum;
  return weights;
}

/// Weighted means of a patch's values: first along its rows, then along its columns.
host::Raster<float> means_of(const std::vector<float>& values, const SurfacePatch& patch,
                             const std::vector<Weights>& along_x, const std::vector<Weights>& along_y) {
  const auto columns = static_cast<std::int32_t>(along_x.size()), rows = static_cast<std::int32_t>(along_y.size());
  host::Raster<double> half(columns, patch.rows);
  for (std::int32_t j = 0; j < patch.rows; ++j) {
    for (std::int32_t c = 0; c < columns; ++c) {
      const Weights& weights = along_x[static_cast<std::size_t>(c)];
      const std::size_t at = patch.index(weights.first - patch.first_i, j);
      double sum = 0;
      for (std::size_t k = 0; k < weights.of.size(); ++k) sum += weights.of[k] * double{values[at + k]};
      half.at(c, j) = sum;
    }
  }
  host::Raster<float> means(columns, rows);
  for (std::int32_t r = 0; r < rows; ++r) {
    const Weights& weights = along_y[static_cast<std::size_t>(r)];
    for (std::int32_t c = 0; c < columns; ++c) {
      double sum = 0;
      for (std::size_t k = 0; k < weights.of.size(); ++k) {
        sum += weights.of[k] * half.at(c, weights.first - patch.first_j + static_cast<std::int32_t>(k));
      }
      means.at(c, r) = static_cast<float>(sum);
    }
  }
  return means;
}

class MapRenderer {
 public:
  MapRenderer(const Terrain& terrain, double west_m, double north_m, const OrbitalMapParams& params)
      : terrain_(terrain),
        west_m_(west_m),
        north_m_(north_m),
        params_(params),
        post_m_(terrain.params().post_spacing_m),
        pixel_(params.pixel_m / post_m_) {}

  void render(std::int32_t column, std::int32_t row, OrbitalMap& map) const {
    const double pixel = params_.pixel_m, reach = (margin_px + 2) * pixel + 2 * post_m_;
    SurfacePatch patch =
        terrain_.patch({west_m_ + column * pixel - reach, north_m_ - (row + block_side) * pixel - reach,
                        west_m_ + (column + block_side) * pixel + reach, north_m_ - row * pixel + reach});
    add_detail(patch);
    put_light(patch, column, row, map.light);
    put_heights(patch, column, row, map.heights);
  }

 private:
  void add_detail(SurfacePatch& patch) const {
    const double footprint_m = std::max(post_m_, params_.pixel_m / 8);
    for (std::int32_t j = 0; j < patch.rows; ++j) {
      for (std::int32_t i = 0; i < patch.columns; ++i) {
        const std::size_t at = patch.index(i, j);
        patch.radiance[at] *= static_cast<float>(terrain_.detail(
            (patch.first_i + i) * post_m_, (patch.first_j + j) * post_m_, double{patch.height_m[at]}, footprint_m));
      }
    }
  }
  void put_light(const SurfacePatch& patch, std::int32_t column, std::int32_t row, host::Raster<float>& light) const {
    // A pixel that is finer than the posts is interpolated.
    const double spread = std::max(params_.spread_px * pixel_, 0.4);
    std::vector<Weights> along_x, along_y;
    for (std::int32_t k = 0; k < block_side; ++k) {
      along_x.push_back(weights_about(west_m_ / post_m_ + (column + k + 0.5) * pixel_, pixel_, spread));
      along_y.push_back(weights_about(north_m_ / post_m_ - (row + k + 0.5) * pixel_, pixel_, spread));
    }
    const host::Raster<float> means = means_of(patch.radiance, patch, along_x, along_y);
    for (std::int32_t y = 0; y < block_side; ++y) {
      for (std::int32_t x = 0; x < block_side; ++x) {
        const double noise = params_.noise * normal_at(column + x, row + y, params_.seed);
        light.at(column + x, row + y) = static_cast<float>(std::max(double{means.at(x, y)} + noise, 0.0));
      }
    }
  }
  void put_heights(const SurfacePatch& patch, std::int32_t column, std::int32_t row,
                   host::Raster<float>& heights) const {
    const double box = map_posts_apart * pixel_;
    const std::int32_t first_i = column / map_posts_apart, first_j = row / map_posts_apart;
    // The last blocks have the posts on their far border too.
    const std::int32_t columns = first_i + posts_of_block + 1 == heights.width ? posts_of_block + 1 : posts_of_block;
    const std::int32_t rows = first_j + posts_of_block + 1 == heights.height ? posts_of_block + 1 : posts_of_block;
    std::vector<Weights> along_x, along_y;
    for (std::int32_t k = 0; k < columns; ++k) {
      along_x.push_back(weights_about(west_m_ / post_m_ + (first_i + k) * box, box, 0.4));
    }
    for (std::int32_t k = 0; k < rows; ++k) {
      along_y.push_back(weights_about(north_m_ / post_m_ - (first_j + k) * box, box, 0.4));
    }
    const host::Raster<float> means = means_of(patch.height_m, patch, along_x, along_y);
    for (std::int32_t j = 0; j < rows; ++j) {
      for (std::int32_t i = 0; i < columns; ++i) {
        const double error =
            params_.height_sigma_m * smooth_error(first_i + i, first_j + j, params_.seed ^ 0xA511E9B3U);
        heights.at(first_i + i, first_j + j) = static_cast<float>(double{means.at(i, j)} + error);
      }
    }
  }

  const Terrain& terrain_;
  double west_m_, north_m_;
  OrbitalMapParams params_;
  double post_m_, pixel_;  // of the world; of the map, in posts
};

void require(bool condition, const char* what) {
  if (!condition) throw std::invalid_argument(what);
}

}  // namespace

OrbitalMap render_orbital_map(const Terrain& terrain, double west_m, double north_m, std::int32_t columns,
                              std::int32_t rows, const OrbitalMapParams& params) {
  require(columns > 0 && rows > 0 && columns % block_side == 0 && rows % block_side == 0,
          "columns and rows of an orbital map must be multiples of 64");
  require(params.pixel_m >= terrain.params().post_spacing_m / 2, "the pixel of an orbital map is below half a post");
  require(params.spread_px >= 0 && params.spread_px <= 0.8 && params.noise >= 0 && params.height_sigma_m >= 0,
          "errors of an orbital map: a spread of 0 to 0.8 px, noise and heights' sigma of 0 or more expected");
  OrbitalMap map;
  map.light = host::Raster<float>(columns, rows);
  map.heights = host::Raster<float>(columns / map_posts_apart + 1, rows / map_posts_apart + 1);
  const MapRenderer renderer(terrain, west_m, north_m, params);
  const std::int32_t across = columns / block_side;
  host::for_each_parallel(static_cast<std::size_t>(across) * static_cast<std::size_t>(rows / block_side),
                          [&](std::size_t k) {
                            const auto block = static_cast<std::int32_t>(k);
                            renderer.render(block % across * block_side, block / across * block_side, map);
                          });
  return map;
}

}  // namespace ilp::world
