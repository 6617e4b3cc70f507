#include "sim/ground/map/seam_measure.hpp"

#include <cmath>
#include <optional>
#include <span>
#include <vector>

namespace ilp::map {
namespace {

constexpr std::int32_t reach = 2;

class Sums {
 public:
  void add(bool border, double difference) {
    Part& part = border ? border_ : other_;
    ++part.samples;
    part.squares += difference * difference;
  }
  void add(const Sums& sums) {
    border_.add(sums.border_);
    other_.add(sums.other_);
  }
  [[nodiscard]] Roughness roughness() const {
    return {static_cast<std::uint64_t>(border_.samples), static_cast<std::uint64_t>(other_.samples),
            border_.root_mean_square(), other_.root_mean_square()};
  }

 private:
  struct Part {
    double samples = 0;
    double squares = 0;
    void add(const Part& part) {
      samples += part.samples;
      squares += part.squares;
    }
    [[nodiscard]] double root_mean_square() const { return samples == 0 ? 0 : std::sqrt(squares / samples); }
  };
  Part border_, other_;
};

struct TileSums {
  Sums height, grey, grey_step;
};

/// Cells i - reach * step to i + reach * step.
void add_sample(const MapTile& tile, std::size_t i, std::size_t step, double cell, Sums& height, Sums& grey) {
  bool border = false;
  for (std::size_t at = i - reach * step; at <= i + reach * step; at += step) {
    if (tile.source.samples[at] == 0) return;
    border = border || tile.source.samples[at] != tile.source.samples[i];
  }
  const auto second_difference = [&](const auto& raster) {
    return static_cast<double>(raster.samples[i - step]) - 2.0 * raster.samples[i] + raster.samples[i + step];
  };
  height.add(border, second_difference(tile.height) / cell);
  grey.add(border, second_difference(tile.ortho));
}

constexpr std::size_t run = 8;

/// Whether three runs of cells come from one keyframe, from two that meet in the middle run, or neither.
enum class Runs { mixed, one, two };

Runs runs_at(const MapTile& tile, std::size_t from, std::size_t step) {
  const auto source = [&](std::size_t k) { return tile.source.samples[from + k * step]; };
  const std::uint16_t left = source(0), right = source(3 * run - 1);
  if (left == 0 || right == 0) return Runs::mixed;
  std::size_t meet = 0;
  while (meet < 3 * run && source(meet) == left) ++meet;
  if (meet == 3 * run) return Runs::one;
  if (meet < run || meet > 2 * run) return Runs::mixed;
  for (std::size_t k = meet; k < 3 * run; ++k) {
    if (source(k) != right) return Runs::mixed;
  }
  return Runs::two;
}

double step_of(const MapTile& tile, std::size_t from, std::size_t step) {
  double difference = 0;
  for (std::size_t k = 0; k < run; ++k) {
    difference += tile.ortho.samples[from + (2 * run + k) * step];
    difference -= tile.ortho.samples[from + k * step];
  }
  return difference / run;
}

/// The runs that begin at cell i, the `at`-th of `length` cells in its row or column, if they cross a border, and those
/// of one keyframe two runs before and behind.
void add_step(const MapTile& tile, std::size_t i, std::size_t step, std::int32_t at, std::int32_t length,
              Sums& grey_step) {
  constexpr auto away = static_cast<std::int32_t>(2 * run), all = static_cast<std::int32_t>(3 * run);
  if (at + all > length || runs_at(tile, i, step) != Runs::two) return;
  bool beside = false;
  const auto compare = [&](std::size_t from) {
    if (runs_at(tile, from, step) != Runs::one) return;
    grey_step.add(false, step_of(tile, from, step));
    beside = true;
  };
  if (at >= away) compare(i - 2 * run * step);
  if (at + away + all <= length) compare(i + 2 * run * step);
  if (beside) grey_step.add(true, step_of(tile, i, step));
}

TileSums sums_of(const MapTile& tile, double cell) {
  TileSums sums;
  const auto width = static_cast<std::size_t>(tile.height.width);
  for (std::int32_t y = 0; y < tile.height.height; ++y) {
    for (std::int32_t x = 0; x < tile.height.width; ++x) {
      const std::size_t i = tile.height.index(x, y);
      const auto inside = [](std::int32_t at, std::int32_t size) { return at >= reach && at < size - reach; };
      if (inside(x, tile.height.width)) add_sample(tile, i, 1, cell, sums.height, sums.grey);
      if (inside(y, tile.height.height)) add_sample(tile, i, width, cell, sums.height, sums.grey);
      add_step(tile, i, 1, x, tile.height.width, sums.grey_step);
      add_step(tile, i, width, y, tile.height.height, sums.grey_step);
    }
  }
  return sums;
}

/// From `kept`, by the digest of the tile, or from the tile.
std::optional<TileSums> sums_of(const Mosaic& mosaic, std::int32_t column, std::int32_t row,
                                intake::ResultCache* kept) {
  const bool keeps = kept != nullptr && mosaic.digest;
  const std::optional<std::uint64_t> digest = keeps ? mosaic.digest(column, row) : std::nullopt;
  if (keeps && !digest) return std::nullopt;
  const std::uint64_t key =
      intake::InputDigest("seams of a tile 3").add_value(digest.value_or(0)).add_value(mosaic.geometry.cell).value();
  std::vector<TileSums> sums;
  const auto known = keeps ? kept->result(key) : std::nullopt;
  std::span<const std::uint8_t> bytes = known ? std::span<const std::uint8_t>(*known) : std::span<const std::uint8_t>();
  if (intake::take(bytes, sums) && sums.size() == 1) return sums[0];
  const std::optional<MapTile> tile = mosaic.tile(column, row);
  if (!tile) return std::nullopt;
  sums.assign(1, sums_of(*tile, mosaic.geometry.cell));
  if (keeps) {
    std::vector<std::uint8_t> reported;
    intake::append(sums, reported);
    kept->put_result(key, reported);
  }
  return sums[0];
}

}  // namespace

SeamMeasure measure_seams(const Mosaic& mosaic, intake::ResultCache* kept) {
  TileSums all;
  for (std::int32_t row = 0; row < mosaic.tile_rows; ++row) {
    for (std::int32_t column = 0; column < mosaic.tile_columns; ++column) {
      const std::optional<TileSums> sums = sums_of(mosaic, column, row, kept);
      if (!sums) continue;
      all.height.add(sums->height);
      all.grey.add(sums->grey);
      all.grey_step.add(sums->grey_step);
    }
  }
  return {all.height.roughness(), all.grey.roughness(), all.grey_step.roughness()};
}

}  // namespace ilp::map
