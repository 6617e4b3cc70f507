// Scratch of match_corners; a component owns one.
#pragma once

#include <array>

#include "fsw/vision/features/matcher.hpp"
#include "fsw/vision/features/patch.hpp"
#include "fsw/vision/features/subpixel.hpp"

namespace ilp {

/// Corner indices by cell of a regular grid, so that a search is limited to nearby corners.
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
    std::int32_t score, second;  ///< in units of normalized_patch_square
    std::uint16_t other;         ///< none: no corner correlates
  };
  struct Predicted {
    float x, y;
    Linear2 b_from_a;  ///< linear part there
  };

  std::array<std::uint16_t, limits::max_image_pixels> smooth_a, smooth_b;
  std::array<NormalizedPatch, limits::max_corners> patches_a, patches_b;
  std::array<Predicted, limits::max_corners> predicted;
  std::array<Best, limits::max_corners> best_a, best_b;
  CornerFlags usable_a, usable_b;  ///< the patch is inside and has texture
  std::array<Match, limits::max_corners> match_of_a;
  CornerFlags matched_a, matched_b;
  CornerGrid grid_a, grid_b;  ///< matched corners of a, usable ones of b
  /// What match_and_track_corners does next, and with which corner.
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
    std::size_t first_new;  ///< the first new corner of b
  };
  Progress progress;

  PatchTemplate patch;
  NormalizedPatch candidate;  ///< of a search along a line
};

}  // namespace ilp
