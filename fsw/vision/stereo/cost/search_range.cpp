#include "fsw/vision/stereo/cost/search_range.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/stereo/cost/coarse_level.hpp"

namespace ilp {
namespace {

constexpr std::int32_t coarse_tile = search_tile / coarse_step;

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

void find_extent(const CoarseMap& coarse, const TileWindow& window, TileStatistics& tile) {
  bool any = false;
  for (std::int32_t y = window.y_begin; y < window.y_end; ++y) {
    const float* disparity = coarse.disparity_px.row(y);
    const float* sigma = coarse.sigma_px.row(y);
    for (std::int32_t x = window.x_begin; x < window.x_end; ++x) {
      if (!(sigma[x] > 0)) continue;
      tile.lowest_px = any ? std::min(tile.lowest_px, disparity[x]) : disparity[x];
      tile.highest_px = any ? std::max(tile.highest_px, disparity[x]) : disparity[x];
      any = true;
    }
  }
}

void count_matched(const CoarseMap& coarse, const TileWindow& window, TileStatistics& tile) {
  for (std::int32_t y = window.y_begin; y < window.y_end; ++y) {
    const float* sigma = coarse.sigma_px.row(y);
    const std::uint8_t* valid = coarse.left_valid.row(y);
    for (std::int32_t x = window.x_begin; x < window.x_end; ++x) {
      if (valid[x] == 0) continue;
      const auto column = static_cast<float>(x);
      if (sigma[x] > 0) {
        ++tile.matched;
        ++tile.visible;
      } else if (column >= tile.lowest_px && column - tile.highest_px < static_cast<float>(coarse.sigma_px.width)) {
        ++tile.visible;
      }
    }
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

SearchRun run_of_tile(const CoarseMap& coarse, std::int32_t column, std::int32_t band, const DisparityRange& range,
                      const StereoParams& params) {
  TileStatistics tile;
  find_extent(coarse, tile_window(coarse, column, band, coarse_tile / 2), tile);
  count_matched(coarse, tile_window(coarse, column, band, 0), tile);
  if (tile.matched == 0 || tile.matched < params.min_coarse_matched * tile.visible) {
    return {0, 0, 0, whole_blocks(range.count())};
  }
  return narrowed(tile, range, params.search_margin_px);
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

SearchRow search_of_band(const CoarseMap& coarse, std::int32_t width, std::int32_t band, const DisparityRange& range,
                         const StereoParams& params) {
  SearchRow row;
  for (std::int32_t column = 0; column * search_tile < width; ++column) {
    SearchRun run = run_of_tile(coarse, column, band, range, params);
    run.begin = column * search_tile;
    run.end = std::min(run.begin + search_tile, width);
    SearchRun* last = row.size > 0 ? &row.runs[static_cast<std::size_t>(row.size - 1)] : nullptr;
    if (last != nullptr && last->first == run.first && last->count == run.count) {
      last->end = run.end;
    } else {
      row.runs[static_cast<std::size_t>(row.size++)] = run;
    }
  }
  return row;
}

}  // namespace ilp
