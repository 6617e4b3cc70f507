// The disparities that each tile of the image searches (paper 3.3: coarse to fine). A map at a quarter of the
// resolution gives the range in which the ground of a tile lies.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/vision/stereo/disparity_range.hpp"

namespace ilp {

/// Disparities are processed in blocks of this many, so that every inner loop is a whole number of vectors.
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

/// The runs of a row, from the left, without gaps.
struct SearchRow {
  std::array<SearchRun, static_cast<std::size_t>(max_search_tiles)> runs;
  std::int32_t size = 0;

  [[nodiscard]] const SearchRun* begin() const { return runs.data(); }
  [[nodiscard]] const SearchRun* end() const { return runs.data() + size; }
};
[[nodiscard]] bool operator==(const SearchRow& a, const SearchRow& b);

/// Calls `use(count)` with `count` as a type that converts to the number. The usual short searches thus have a count
/// that the compiler knows, and their loops need no control.
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

/// Every column searches the whole range.
[[nodiscard]] SearchRow search_everything(std::int32_t width, std::int32_t padded_disparities);

/// The map of a CoarsePair (coarse_level.hpp): pixels and disparities count coarse_step pixels of the image.
struct CoarseMap {
  ImageView<const float> disparity_px;
  ImageView<const float> sigma_px;  ///< 0 = not matched
  MaskView left_valid;
};

/// Added to the range of a tile on either side, for objects that are too small for the coarse map.
inline constexpr std::int32_t search_margin_px = 5;

/// What rows `band * search_tile` and the following search: in each tile the disparities that the coarse map has there
/// and up to half a tile around it, and search_margin_px more at both ends. Tiles of which the coarse map
/// could not match nine tenths search the whole range. A pixel that the other image does not show at
/// any of the tile's disparities does not count as unmatched. `width`: of the full resolution.
[[nodiscard]] SearchRow search_of_band(const CoarseMap& coarse, std::int32_t width, std::int32_t band,
                                       const DisparityRange& range);

}  // namespace ilp
