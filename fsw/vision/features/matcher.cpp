#include "fsw/vision/features/matcher.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fsw/base/argument.hpp"
#include "fsw/base/math.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"

namespace ilp {
namespace {

constexpr std::uint16_t none = MatcherWorkspace::none;

using Part = MatcherWorkspace::Part;

// A slice takes about 10 ms on a processor of 1000 MIPS.
constexpr std::size_t patches_of_a_slice = 700;
constexpr std::size_t searches_of_a_slice = 300;
constexpr std::size_t refinements_of_a_slice = 150;
/// Least standard deviation of a smoothed patch: the camera's noise stays below it.
constexpr float min_patch_stddev_grey = 0.7F;
/// Second best over best correlation inside the window: above it the match is ambiguous.
constexpr float max_second_ratio = 0.95F;
/// Between corner b and the refined position.
constexpr float max_refinement_px = 3;
/// Of a tracked corner: stricter than of a match, because no rival is compared.
constexpr float min_tracked_score = 0.8F;

bool invert(const Linear2& m, Linear2& inverse) {
  const float det = m.xx * m.yy - m.xy * m.yx;
  if (!(det > 0.05F && det < 20)) return false;
  inverse = {m.yy / det, -m.xy / det, -m.yx / det, m.xx / det};
  return true;
}

// Insertion sort, for a few values.
float median_of(float* values, std::size_t count) {
  for (std::size_t i = 1; i < count; ++i) {
    const float value = values[i];
    std::size_t k = i;
    for (; k > 0 && values[k - 1] > value; --k) values[k] = values[k - 1];
    values[k] = value;
  }
  return values[count / 2];
}

Status check_matching(GrayView a, GrayView b, const double (&plane_b_from_a)[9], const MatcherParams& params) {
  for (const GrayView& image : {a, b}) {
    if (image.area() > limits::max_image_pixels || std::max(image.width, image.height) > limits::max_image_side) {
      return {StatusCode::image_too_large, image.width, image.height};
    }
  }
  if (params.patch_side_px < 7 || params.patch_side_px > limits::max_patch_side || params.patch_side_px % 2 == 0) {
    return out_of_range(Argument::patch_side, params.patch_side_px);
  }
  if (!(params.search_radius_px > 0 && params.search_radius_px <= static_cast<float>(limits::max_image_side))) {
    return out_of_range(Argument::search_radius, params.search_radius_px);
  }
  for (const double value : plane_b_from_a) {
    if (!(std::fabs(value) < 1e6)) return out_of_range(Argument::homography, value);
  }
  if (!(params.min_score > 0 && params.min_score <= 1)) return out_of_range(Argument::match_parameters);
  return {};
}

/// Maps the corner by the homography and gives the derivative there; false beyond the horizon.
bool predict(const double (&b_from_a)[9], const Corner& corner, MatcherWorkspace::Predicted& out) {
  const auto& h = b_from_a;
  const double z = h[6] * corner.x + h[7] * corner.y + h[8];
  if (!(z > 1e-3)) return false;
  const double x = (h[0] * corner.x + h[1] * corner.y + h[2]) / z;
  const double y = (h[3] * corner.x + h[4] * corner.y + h[5]) / z;
  out.x = static_cast<float>(x);
  out.y = static_cast<float>(y);
  out.b_from_a = {static_cast<float>((h[0] - h[6] * x) / z), static_cast<float>((h[1] - h[7] * x) / z),
                  static_cast<float>((h[3] - h[6] * y) / z), static_cast<float>((h[4] - h[7] * y) / z)};
  return true;
}

/// Extracts corner i of a as it would appear in b, by `predicted`.
bool extract_warped_patch(SmoothView a, const Corner& corner, std::size_t i, std::int32_t side, MatcherWorkspace& w) {
  Linear2 a_from_b;
  return invert(w.predicted[i].b_from_a, a_from_b) &&
         extract_patch(a, corner.x, corner.y, a_from_b, side, min_patch_stddev_grey, w.patches_a[i]);
}

std::int32_t grid_cell(float v, std::int32_t count) {
  const float cell = std::floor(v * (1.0F / CornerGrid::cell_px));
  return static_cast<std::int32_t>(std::clamp(cell, 0.0F, static_cast<float>(count - 1)));
}

std::size_t grid_cell_index(const CornerGrid& grid, std::int32_t column, std::int32_t row) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns) + static_cast<std::size_t>(column);
}

/// Fills the grid with the corners that have a flag. Their positions lie inside the image.
void fill_grid(GrayView image, const Corners& corners, const CornerFlags& flags, CornerGrid& grid) {
  grid.columns = (image.width + CornerGrid::cell_px - 1) / CornerGrid::cell_px;
  grid.rows = (image.height + CornerGrid::cell_px - 1) / CornerGrid::cell_px;
  const auto cell = [&](const Corner& c) {
    return grid_cell_index(grid, grid_cell(c.x, grid.columns), grid_cell(c.y, grid.rows));
  };
  const std::size_t cells = grid_cell_index(grid, 0, grid.rows);
  std::fill_n(grid.begin.begin(), cells + 1, std::uint16_t{0});
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (flags[i]) ++grid.begin[cell(corners[i])];
  }
  for (std::size_t i = 1; i <= cells; ++i) {
    grid.begin[i] = static_cast<std::uint16_t>(grid.begin[i] + grid.begin[i - 1]);
  }
  // Filled from the back, every cell's begin ends where its first item is.
  for (std::size_t i = corners.size(); i-- > 0;) {
    if (flags[i]) grid.items[--grid.begin[cell(corners[i])]] = static_cast<std::uint16_t>(i);
  }
}

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
void offer(std::int32_t score, std::size_t other, MatcherWorkspace::Best& best) {
  if (score > best.score) {
    best.second = best.score;
    best.score = score;
    best.other = static_cast<std::uint16_t>(other);
  } else if (score > best.second) {
    best.second = score;
  }
}

bool unambiguous(const MatcherWorkspace::Best& best, float min_score) {
  const auto score = static_cast<float>(best.score);
  return score >= min_score * normalized_patch_square && static_cast<float>(best.second) <= max_second_ratio * score;
}

/// Sub-pixel position in b of corner i of a, near (x, y); the score is at least `min_score`. Match::b stays open.
bool refine_match(std::size_t i, const Corner& a, float x, float y, float min_score, SmoothView image_a,
                  SmoothView image_b, const MatcherParams& params, MatcherWorkspace& w, Match& match) {
  if (!prepare_patch(image_a, a.x, a.y, params.patch_side_px, w.patch)) return false;
  PatchWarp warp{x, y, w.predicted[i].b_from_a, 0};
  if (!register_patch(w.patch, image_b, warp)) return false;
  const float dx = warp.x - x, dy = warp.y - y;
  if (dx * dx + dy * dy > max_refinement_px * max_refinement_px || warp.ncc < min_score) return false;
  match = {static_cast<std::uint16_t>(i), none, std::min(warp.ncc, 1.0F), warp.x, warp.y};
  return true;
}

/// How far the matches around a corner lie from their predictions: the median over the nearest ones, for each
/// coordinate. False if there are too few. Needs grid_a, match_of_a and predicted of the matched corners.
struct LocalDeviation {
  float x = 0, y = 0;
};
bool local_deviation(const Corner& at, const Corners& corners_a, const MatcherWorkspace& w, LocalDeviation& deviation) {
  constexpr std::size_t neighbours = 5, enough = 3;
  constexpr float reach_px = 80;
  std::array<std::pair<float, std::size_t>, neighbours> nearest;
  std::size_t count = 0;
  for_each_near(w.grid_a, corners_a, at.x, at.y, reach_px, [&](std::size_t i, float squared) {
    if (count == neighbours && nearest[neighbours - 1].first <= squared) return;
    std::size_t k = count < neighbours ? count++ : neighbours - 1;
    for (; k > 0 && nearest[k - 1].first > squared; --k) nearest[k] = nearest[k - 1];
    nearest[k] = {squared, i};
  });
  if (count < enough) return false;
  float dx[neighbours], dy[neighbours];
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = nearest[k].second;
    dx[k] = w.match_of_a[i].xb - w.predicted[i].x;
    dy[k] = w.match_of_a[i].yb - w.predicted[i].y;
  }
  deviation = {median_of(dx, count), median_of(dy, count)};
  return true;
}

/// The corner of b for a tracked position: a free one nearby, a new one, or `none` when the place is taken or no room
/// is left. `first_new` is the index of the first new one; the others are in grid_b.
std::uint16_t corner_at(float x, float y, std::size_t first_new, Corners& corners_b, MatcherWorkspace& w) {
  constexpr float same_px = 2;
  std::size_t nearest = none;
  float best = same_px * same_px;
  const auto closer = [&](std::size_t j, float squared) {
    if (squared <= best) {
      best = squared;
      nearest = j;
    }
  };
  for_each_near(w.grid_b, corners_b, x, y, same_px, closer);
  for (std::size_t j = first_new; j < corners_b.size(); ++j) {
    const float dx = corners_b[j].x - x, dy = corners_b[j].y - y;
    closer(j, dx * dx + dy * dy);
  }
  if (nearest != none) return w.matched_b[nearest] ? none : static_cast<std::uint16_t>(nearest);
  if (!corners_b.push_back({x, y, 0})) return none;
  return static_cast<std::uint16_t>(corners_b.size() - 1);
}

Status list_matches(std::size_t corners_a, const MatcherWorkspace& w, Matches& matches) {
  for (std::size_t i = 0; i < corners_a; ++i) {
    if (w.matched_a[i]) ILP_ASSERT(matches.push_back(w.match_of_a[i]), i);
  }
  return {};
}

/// What the parts work on.
struct Pair {
  GrayView image_a, image_b;
  const Corners& corners_a;
  const Corners& corners_b;
  const double (&plane)[9];
  const MatcherParams& params;
  MatcherWorkspace& w;
  Corners* tracked_b;  ///< corners_b, if corners without a partner are followed into image b

  [[nodiscard]] SmoothView a() const { return {w.smooth_a.data(), image_a.width, image_a.height}; }
  [[nodiscard]] SmoothView b() const { return {w.smooth_b.data(), image_b.width, image_b.height}; }
};

void extract_from_a(const Pair& pair, std::size_t i) {
  MatcherWorkspace& w = pair.w;
  const Corner& c = pair.corners_a[i];
  w.usable_a[i] =
      predict(pair.plane, c, w.predicted[i]) && extract_warped_patch(pair.a(), c, i, pair.params.patch_side_px, w);
  w.best_a[i] = {0, 0, none};
}

void extract_from_b(const Pair& pair, std::size_t i) {
  MatcherWorkspace& w = pair.w;
  const Corner& c = pair.corners_b[i];
  w.usable_b[i] =
      extract_patch(pair.b(), c.x, c.y, {}, pair.params.patch_side_px, min_patch_stddev_grey, w.patches_b[i]);
  w.best_b[i] = {0, 0, none};
}

// Correlates a corner of a with all corners of b around its predicted position.
void search(const Pair& pair, std::size_t i) {
  MatcherWorkspace& w = pair.w;
  if (!w.usable_a[i]) return;
  const auto compare = [&](std::size_t j, float) {
    const std::int32_t score = correlate(w.patches_a[i], w.patches_b[j], pair.params.patch_side_px);
    offer(score, j, w.best_a[i]);
    offer(score, i, w.best_b[j]);
  };
  for_each_near(w.grid_b, pair.corners_b, w.predicted[i].x, w.predicted[i].y, pair.params.search_radius_px, compare);
}

// Fills match_of_a, matched_a and matched_b if a corner of a and one of b are mutually the best.
void match_mutual_best(const Pair& pair, std::size_t i) {
  MatcherWorkspace& w = pair.w;
  const MatcherParams& params = pair.params;
  const std::uint16_t j = w.best_a[i].other;
  if (j == none || w.best_b[j].other != i) return;
  if (!unambiguous(w.best_a[i], params.min_score) || !unambiguous(w.best_b[j], params.min_score)) return;
  Match& match = w.match_of_a[i];
  const Corner& b = pair.corners_b[j];
  if (!refine_match(i, pair.corners_a[i], b.x, b.y, params.min_score, pair.a(), pair.b(), params, w, match)) return;
  match.b = j;
  w.matched_a[i] = w.matched_b[j] = true;
}

// Tracks a corner of a without a match from the place that its neighbours predict.
void track_unmatched(const Pair& pair, std::size_t i) {
  MatcherWorkspace& w = pair.w;
  if (w.matched_a[i] || !w.usable_a[i]) return;
  LocalDeviation deviation;
  if (!local_deviation(pair.corners_a[i], pair.corners_a, w, deviation)) return;
  const float x = w.predicted[i].x + deviation.x, y = w.predicted[i].y + deviation.y;
  Match& match = w.match_of_a[i];
  if (!refine_match(i, pair.corners_a[i], x, y, min_tracked_score, pair.a(), pair.b(), pair.params, w, match)) return;
  match.b = corner_at(match.xb, match.yb, w.progress.first_new, *pair.tracked_b, w);
  if (match.b == none) return;
  w.matched_a[i] = w.matched_b[match.b] = true;
}

/// Does the next `most` of `count` corners; true when it was the last of them.
template <typename Do>
bool do_corners(const Pair& pair, std::size_t count, std::size_t most, Do one) {
  const std::size_t end = std::min(count, pair.w.progress.next + most);
  for (std::size_t i = pair.w.progress.next; i < end; ++i) one(pair, i);
  pair.w.progress.next = end;
  return end == count;
}

/// Does a slice of the part; true when the part is done.
bool do_part(const Pair& pair) {
  MatcherWorkspace& w = pair.w;
  const std::size_t count_a = pair.corners_a.size();
  switch (w.progress.part) {
    case Part::smooth_a:
      smooth(pair.image_a, {w.smooth_a.data(), pair.image_a.width, pair.image_a.height});
      return true;
    case Part::smooth_b:
      smooth(pair.image_b, {w.smooth_b.data(), pair.image_b.width, pair.image_b.height});
      return true;
    case Part::patches_a:
      return do_corners(pair, count_a, patches_of_a_slice, extract_from_a);
    case Part::patches_b:
      if (!do_corners(pair, pair.corners_b.size(), patches_of_a_slice, extract_from_b)) return false;
      fill_grid(pair.image_b, pair.corners_b, w.usable_b, w.grid_b);
      w.matched_a.fill(false);
      w.matched_b.fill(false);
      return true;
    case Part::search:
      return do_corners(pair, count_a, searches_of_a_slice, search);
    case Part::refine:
      return do_corners(pair, count_a, refinements_of_a_slice, match_mutual_best);
    case Part::begin_tracks:
      if (pair.tracked_b != nullptr) fill_grid(pair.image_a, pair.corners_a, w.matched_a, w.grid_a);
      w.progress.first_new = pair.corners_b.size();
      return true;
    case Part::track:
      return pair.tracked_b == nullptr || do_corners(pair, count_a, refinements_of_a_slice, track_unmatched);
    case Part::list:
      break;
  }
  return true;
}

Result<bool> do_slice(const Pair& pair, Matches& matches) {
  MatcherWorkspace& w = pair.w;
  if (pair.image_a.empty() || pair.image_b.empty()) return false;
  if (w.progress.part == Part::list) {
    ILP_TRY(list_matches(pair.corners_a.size(), w, matches));
    return false;
  }
  if (!do_part(pair)) return true;
  w.progress.part = static_cast<Part>(static_cast<std::uint8_t>(w.progress.part) + 1);
  w.progress.next = 0;
  return true;
}

/// Matches the corners of both images, which end in the workspace.
Status match(GrayView image_a, const Corners& corners_a, GrayView image_b, const Corners& corners_b,
             const double (&plane)[9], const MatcherParams& params, MatcherWorkspace& w, Corners* tracked_b,
             Matches& matches) {
  ILP_TRY(begin_matching(image_a, image_b, plane, params, w, matches));
  const Pair pair{image_a, image_b, corners_a, corners_b, plane, params, w, tracked_b};
  return do_all([&] { return do_slice(pair, matches); });
}

}  // namespace

Status match_corners(GrayView image_a, const Corners& corners_a, GrayView image_b, const Corners& corners_b,
                     const Similarity2& b_from_a, const MatcherParams& params, MatcherWorkspace& workspace,
                     Matches& matches) {
  const double c = b_from_a.scale * det_cos(b_from_a.rotation_rad);
  const double s = b_from_a.scale * det_sin(b_from_a.rotation_rad);
  const double plane[9] = {c, -s, b_from_a.shift_x_px, s, c, b_from_a.shift_y_px, 0, 0, 1};
  return match_corners_by_plane(image_a, corners_a, image_b, corners_b, plane, params, workspace, matches);
}

Status match_corners_by_plane(GrayView image_a, const Corners& corners_a, GrayView image_b, const Corners& corners_b,
                              const double (&plane_b_from_a)[9], const MatcherParams& params, MatcherWorkspace& w,
                              Matches& matches) {
  return match(image_a, corners_a, image_b, corners_b, plane_b_from_a, params, w, nullptr, matches);
}

Status match_and_track_corners(GrayView image_a, const Corners& corners_a, GrayView image_b, Corners& corners_b,
                               const double (&plane_b_from_a)[9], const MatcherParams& params, MatcherWorkspace& w,
                               Matches& matches) {
  return match(image_a, corners_a, image_b, corners_b, plane_b_from_a, params, w, &corners_b, matches);
}

Status begin_matching(GrayView image_a, GrayView image_b, const double (&plane_b_from_a)[9],
                      const MatcherParams& params, MatcherWorkspace& w, Matches& matches) {
  matches.clear();
  w.progress.part = Part::smooth_a;
  w.progress.next = 0;
  return check_matching(image_a, image_b, plane_b_from_a, params);
}

Result<bool> match_and_track_slice(GrayView image_a, const Corners& corners_a, GrayView image_b, Corners& corners_b,
                                   const double (&plane_b_from_a)[9], const MatcherParams& params, MatcherWorkspace& w,
                                   Matches& matches) {
  return do_slice({image_a, image_b, corners_a, corners_b, plane_b_from_a, params, w, &corners_b}, matches);
}

}  // namespace ilp
