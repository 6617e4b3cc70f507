// Steps that the matchers share. They work on the matchers' workspace and have no other callers.
#pragma once

#include <algorithm>
#include <cmath>

#include "fsw/vision/features/matcher_workspace.hpp"

namespace ilp {

/// Least standard deviation of a smoothed patch: the camera's noise stays below it.
inline constexpr float min_patch_stddev_grey = 0.7F;

Status check_matching(GrayView a, GrayView b, const double (&plane_b_from_a)[9], const MatcherParams& params);
void smooth_both(GrayView image_a, GrayView image_b, MatcherWorkspace& w);

/// Maps the corner by the homography and gives the derivative there; false beyond the horizon.
[[nodiscard]] bool predict(const double (&b_from_a)[9], const Corner& corner, MatcherWorkspace::Predicted& out);

/// Extracts corner i of a as it would appear in b, by `predicted`.
[[nodiscard]] bool extract_warped_patch(SmoothView a, const Corner& corner, std::size_t i, std::int32_t side,
                                        MatcherWorkspace& w);

[[nodiscard]] inline std::int32_t grid_cell(float v, std::int32_t count) {
  const float cell = std::floor(v * (1.0F / CornerGrid::cell_px));
  return static_cast<std::int32_t>(std::clamp(cell, 0.0F, static_cast<float>(count - 1)));
}

[[nodiscard]] inline std::size_t grid_cell_index(const CornerGrid& grid, std::int32_t column, std::int32_t row) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns) + static_cast<std::size_t>(column);
}

/// Fills the grid with the corners that have a flag. Their positions lie inside the image.
void fill_grid(GrayView image, const Corners& corners, const CornerFlags& flags, CornerGrid& grid);

/// Calls visit(index, squared distance) for every corner of the grid within `radius` of (x, y).
template <typename Visit>
void for_each_near(const CornerGrid& grid, const Corners& corners, float x, float y, float radius, Visit visit) {
  const std::int32_t x0 = grid_cell(x - radius, grid.columns), x1 = grid_cell(x + radius, grid.columns);
  for (std::int32_t row = grid_cell(y - radius, grid.rows); row <= grid_cell(y + radius, grid.rows); ++row) {
    const auto first = grid_cell_index(grid, x0, row);
    const auto last = grid_cell_index(grid, x1, row);
    for (std::size_t k = grid.begin[first]; k < grid.begin[last + 1]; ++k) {
      const std::size_t i = grid.items[k];
      const float dx = corners[i].x - x, dy = corners[i].y - y;
      const float squared = dx * dx + dy * dy;
      if (squared <= radius * radius) visit(i, squared);
    }
  }
}

/// Keeps the best and the second best score.
void offer(std::int32_t score, std::size_t other, MatcherWorkspace::Best& best);
[[nodiscard]] bool unambiguous(const MatcherWorkspace::Best& best, float min_score, float max_second_ratio);

/// Sub-pixel position in b of corner i of a, near (x, y); the score is at least `min_score`. Match::b stays open.
[[nodiscard]] bool refine_match(std::size_t i, const Corner& a, float x, float y, float min_score, SmoothView image_a,
                                SmoothView image_b, const MatcherParams& params, MatcherWorkspace& w, Match& match);

/// How far the matches around a corner lie from their predictions: the median over the nearest ones, for each
/// coordinate. False if there are too few. Needs grid_a, match_of_a and predicted of the matched corners.
struct LocalDeviation {
  float x = 0, y = 0;
};
[[nodiscard]] bool local_deviation(const Corner& at, const Corners& corners_a, const MatcherWorkspace& w,
                                   LocalDeviation& deviation);

/// The corner of b for a tracked position: a free one nearby, a new one, or MatcherWorkspace::none when the place is
/// taken or no room is left. `first_new` is the index of the first new one; the others are in grid_b.
[[nodiscard]] std::uint16_t corner_at(float x, float y, std::size_t first_new, Corners& corners_b, MatcherWorkspace& w);

Status list_matches(std::size_t corners_a, const MatcherWorkspace& w, Matches& matches);

}  // namespace ilp
