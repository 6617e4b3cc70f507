// Scratch memory of match_corners and its variants. The caller keeps one, in static memory because of its size.
#pragma once

#include <array>

#include "fsw/vision/features/matcher.hpp"
#include "fsw/vision/features/patch.hpp"
#include "fsw/vision/features/subpixel.hpp"

namespace ilp {

/// Corner indices sorted by the cells of a regular grid, so that a search visits only nearby corners. The corners of
/// cell c are items[begin[c]] to items[begin[c + 1] - 1].
struct CornerGrid {
  static constexpr std::int32_t cell_px = 32;
  static constexpr std::int32_t max_columns = (limits::max_image_side + cell_px - 1) / cell_px;
  static constexpr std::size_t max_cells =
      static_cast<std::size_t>(max_columns) * static_cast<std::size_t>(max_columns);

  std::int32_t columns = 0, rows = 0;
  std::array<std::uint16_t, max_cells + 1> begin;
  std::array<std::uint16_t, limits::max_corners> items;
};

using CornerFlags = std::array<bool, limits::max_corners>;

struct MatcherWorkspace {
  static constexpr std::uint16_t none = 0xFFFF;
  struct Best {
    std::int32_t score, second;  ///< best and second-best score, in units of 1 / normalized_patch_square
    std::uint16_t other;         ///< index of the best corner in the other image; `none`: no corner correlates
  };
  struct Predicted {
    float x, y;
    Linear2 b_from_a;  ///< linear part of the prediction at the corner
  };

  std::array<std::uint16_t, limits::max_image_pixels> smooth_a, smooth_b;
  std::array<NormalizedPatch, limits::max_corners> patches_a, patches_b;
  std::array<Predicted, limits::max_corners> predicted;
  std::array<Best, limits::max_corners> best_a, best_b;
  CornerFlags usable_a, usable_b;  ///< whether the patch of the corner lies inside the image and has texture
  std::array<Match, limits::max_corners> match_of_a;
  CornerFlags matched_a, matched_b;
  CornerGrid grid_a, grid_b;  ///< grid_a: matched corners of a; grid_b: usable corners of b
  /// The next work of match_and_track_slice: the part, and the index of the next corner in it.
  enum class Part : std::uint8_t {
    smooth_a,
    smooth_b,
    patches_a,
    patches_b,
    search,
    refine,
    begin_tracks,
    track,
    list
  };
  struct Progress {
    Part part;
    std::size_t next;
    std::size_t first_new;  ///< index of the first corner that tracking appended to b
  };
  Progress progress;

  PatchTemplate patch;
  NormalizedPatch candidate;  ///< of a search along a line
};

}  // namespace ilp
