#include "fsw/vision/stereo/cost/search_range.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/stereo/cost/coarse_level.hpp"

namespace ilp {
namespace {

constexpr std::int32_t coarse_tile = search_tile / coarse_step;
// Share of a tile that the coarse map must match, or the whole range is searched.
constexpr double min_coarse_matched = 0.9;

struct TileStatistics {
  float lowest_px = 0, highest_px = 0;  ///< disparity of the coarse map
  std::int32_t matched = 0, visible = 0;
};

struct TileWindow {
  std::int32_t x_begin, x_end, y_begin, y_end;
};

TileWindow tile_window(const CoarseMap& coarse, std::int32_t column, std::int32_t band, std::int32_t border) {
  return {
      std::max(column * coarse_tile - border, 0), std::min((column + 1) * coarse_tile + border, coarse.sigma_px.width),
      std::max(band * coarse_tile - border, 0), std::min((band + 1) * coarse_tile + border, coarse.sigma_px.height)};
}

/// The lowest and the highest disparity in a window; false if none is matched.
bool find_extent(const CoarseMap& coarse, const TileWindow& window, TileStatistics& tile) {
  constexpr std::int32_t lanes = 4;
  constexpr float infinity = std::numeric_limits<float>::infinity();
  using Floats [[gnu::vector_size(sizeof(float) * lanes)]] = float;
  Floats lowest = Floats{} + infinity, highest = Floats{} - infinity;
  const auto take = [&](Floats d, Floats s) {
    const Floats low = s > 0 ? d : Floats{} + infinity, high = s > 0 ? d : Floats{} - infinity;
    lowest = low < lowest ? low : lowest;
    highest = high > highest ? high : highest;
  };
  for (std::int32_t y = window.y_begin; y < window.y_end; ++y) {
    const float* disparity = coarse.disparity_px.row(y);
    const float* sigma = coarse.sigma_px.row(y);
    std::int32_t x = window.x_begin;
    for (; x + lanes <= window.x_end; x += lanes) {
      Floats d, s;
      std::memcpy(&d, disparity + x, sizeof d);
      std::memcpy(&s, sigma + x, sizeof s);
      take(d, s);
    }
    for (; x < window.x_end; ++x) take(Floats{} + disparity[x], Floats{} + sigma[x]);
  }
  tile.lowest_px = std::min(std::min(lowest[0], lowest[1]), std::min(lowest[2], lowest[3]));
  tile.highest_px = std::max(std::max(highest[0], highest[1]), std::max(highest[2], highest[3]));
  return tile.lowest_px <= tile.highest_px;
}

void count_matched(const CoarseMap& coarse, const TileWindow& window, TileStatistics& tile) {
  const auto width = static_cast<float>(coarse.sigma_px.width);
  const float lowest = tile.lowest_px, highest = tile.highest_px;
  for (std::int32_t y = window.y_begin; y < window.y_end; ++y) {
    const float* __restrict sigma = coarse.sigma_px.row(y);
    const std::uint8_t* __restrict valid = coarse.left_valid.row(y);
    std::int32_t matched = 0, visible = 0;
    // Without branches, so that several pixels are taken at once.
    for (std::int32_t x = window.x_begin; x < window.x_end; ++x) {
      const auto column = static_cast<float>(x);
      const int is_matched = static_cast<int>(valid[x] != 0) & static_cast<int>(sigma[x] > 0);
      const int is_seen = static_cast<int>(valid[x] != 0) & static_cast<int>(column >= lowest) &
                          static_cast<int>(column - highest < width);
      matched += is_matched;
      visible += is_matched | is_seen;
    }
    tile.matched += matched;
    tile.visible += visible;
  }
}

SearchRun narrowed(const TileStatistics& tile, const DisparityRange& range, std::int32_t margin) {
  const std::int32_t padded = whole_blocks(range.count());
  const std::int32_t low = static_cast<std::int32_t>(std::floor(coarse_step * tile.lowest_px)) - margin - range.min_px;
  const std::int32_t high = static_cast<std::int32_t>(std::ceil(coarse_step * tile.highest_px)) + margin - range.min_px;
  SearchRun run;
  run.count = std::min(whole_blocks(high - low + 1), padded);
  run.first = std::clamp((low + high + 1 - run.count) / 2, 0, padded - run.count);
  return run;
}

SearchRun run_of_tile(const CoarseMap& coarse, std::int32_t column, std::int32_t band, const DisparityRange& range) {
  TileStatistics tile;
  const SearchRun everything{0, 0, 0, whole_blocks(range.count())};
  if (!find_extent(coarse, tile_window(coarse, column, band, coarse_tile / 2), tile)) return everything;
  count_matched(coarse, tile_window(coarse, column, band, 0), tile);
  if (tile.matched == 0 || tile.matched < min_coarse_matched * tile.visible) return everything;
  return narrowed(tile, range, search_margin_px);
}

void find_search(const CoarseMap& coarse, std::int32_t width, std::int32_t band, const DisparityRange& range,
                 SearchRow& row) {
  for (std::int32_t column = 0; column * search_tile < width; ++column) {
    SearchRun run = run_of_tile(coarse, column, band, range);
    run.begin = column * search_tile;
    run.end = std::min(run.begin + search_tile, width);
    SearchRun* last = row.size > 0 ? &row.runs[static_cast<std::size_t>(row.size - 1)] : nullptr;
    if (last != nullptr && last->first == run.first && last->count == run.count) {
      last->end = run.end;
    } else {
      row.runs[static_cast<std::size_t>(row.size++)] = run;
    }
  }
}

}  // namespace

bool operator==(const SearchRow& a, const SearchRow& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

SearchRow search_everything(std::int32_t width, std::int32_t padded_disparities) {
  SearchRow row;
  row.runs[0] = {0, width, 0, padded_disparities};
  row.size = 1;
  return row;
}

SearchRow search_of_band(const CoarseMap& coarse, std::int32_t width, std::int32_t band, const DisparityRange& range) {
  SearchRow row;
  with_widest_vectors([&] { find_search(coarse, width, band, range, row); });
  return row;
}

}  // namespace ilp
