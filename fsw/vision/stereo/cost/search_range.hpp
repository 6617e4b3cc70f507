// The disparities that each tile of an image searches (paper 3.3: coarse to fine). A disparity map at a quarter of the
// resolution gives the range of the ground in a tile.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/vision/stereo/disparity_range.hpp"

namespace ilp {

/// Disparities per block. Disparities are processed in blocks, so that inner loops work on whole vectors.
inline constexpr std::int32_t disparity_block = 16;
[[nodiscard]] constexpr std::int32_t whole_blocks(std::int32_t disparities) {
  return (disparities + disparity_block - 1) / disparity_block * disparity_block;
}
inline constexpr std::int32_t max_padded_disparities = whole_blocks(limits::max_disparities);

inline constexpr std::int32_t search_tile = 32;  ///< columns and rows of a tile, px
inline constexpr std::int32_t max_search_tiles = (limits::max_rectified_width + search_tile - 1) / search_tile;
inline constexpr std::int32_t max_search_bands = (limits::max_rectified_height + search_tile - 1) / search_tile;

/// Columns `begin` to `end - 1` search disparity indices `first` to `first + count - 1`; an index counts from the
/// smallest disparity of the whole range. `count` is a multiple of disparity_block.
struct SearchRun {
  std::int32_t begin = 0, end = 0;
  std::int32_t first = 0, count = 0;
  bool operator==(const SearchRun&) const = default;
};

/// The runs of a row, from left to right, without gaps.
struct SearchRow {
  std::array<SearchRun, static_cast<std::size_t>(max_search_tiles)> runs;
  std::int32_t size = 0;

  [[nodiscard]] const SearchRun* begin() const { return runs.data(); }
  [[nodiscard]] const SearchRun* end() const { return runs.data() + size; }
};
[[nodiscard]] bool operator==(const SearchRow& a, const SearchRow& b);

/// Calls `use(count)`. For the usual short searches `count` is passed as a type that converts to the number, so that
/// the compiler knows the number of iterations of loops over it.
template <typename Use>
void with_known_count(std::int32_t count, Use use) {
  switch (count) {
    case disparity_block:
      return use(std::integral_constant<std::int32_t, disparity_block>{});
    case 2 * disparity_block:
      return use(std::integral_constant<std::int32_t, 2 * disparity_block>{});
    default:
      return use(count);
  }
}

/// Returns a row in which every column searches the whole range.
[[nodiscard]] SearchRow search_everything(std::int32_t width, std::int32_t padded_disparities);

/// Disparity map of a CoarsePair (coarse_level.hpp). Pixels and disparities are in units of coarse_step px of the
/// image.
struct CoarseMap {
  ImageView<const float> disparity_px;
  ImageView<const float> sigma_px;  ///< 0 = not matched
  MaskView left_valid;
};

/// Margin at both ends of a tile's range, for objects that are too small for the coarse map.
inline constexpr std::int32_t search_margin_px = 5;

/// Returns the search of the search_tile rows from `band * search_tile` on. Each tile searches the disparities that the
/// coarse map has in the tile and up to half a tile around it, widened by search_margin_px at both ends. A tile
/// searches the whole range if the coarse map matched less than nine tenths of its pixels; pixels that the right image
/// does not show at any of the tile's disparities are not counted. `width` is the image width at full resolution, px.
[[nodiscard]] SearchRow search_of_band(const CoarseMap& coarse, std::int32_t width, std::int32_t band,
                                       const DisparityRange& range);

}  // namespace ilp
