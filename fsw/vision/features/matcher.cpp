#include "fsw/vision/features/matcher.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fsw/base/math.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"

namespace ilp {
namespace {

constexpr float min_patch_stddev = 0.7F;  // grey levels, smoothed: below is the camera's noise
constexpr std::uint16_t none = MatcherWorkspace::none;

Status check(GrayView a, GrayView b, const double (&h)[9], const MatcherParams& p) {
  for (const GrayView& image : {a, b}) {
    if (image.area() > limits::max_image_pixels || std::max(image.width, image.height) > limits::max_image_side) {
      return {StatusCode::image_too_large, image.width, image.height};
    }
  }
  if (p.patch_side_px < 7 || p.patch_side_px > limits::max_patch_side || p.patch_side_px % 2 == 0) {
    return {StatusCode::invalid_argument, 1, p.patch_side_px};
  }
  if (!(p.search_radius_px > 0 && p.search_radius_px <= static_cast<float>(limits::max_image_side))) {
    return {StatusCode::invalid_argument, 2};
  }
  for (const double value : h) {
    if (!(std::fabs(value) < 1e6)) return {StatusCode::invalid_argument, 3};
  }
  return {};
}

// Where the homography sends (x, y), and its derivative there; false beyond the horizon.
bool predict(const double (&h)[9], const Corner& corner, MatcherWorkspace::Predicted& out) {
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

bool invert(const Linear2& m, Linear2& inverse) {
  const float det = m.xx * m.yy - m.xy * m.yx;
  if (!(det > 0.05F && det < 20)) return false;
  inverse = {m.yy / det, -m.xy / det, -m.yx / det, m.xx / det};
  return true;
}

std::int32_t grid_cell(float v, std::int32_t count) {
  const float cell = std::floor(v * (1.0F / CornerGrid::cell_px));
  return static_cast<std::int32_t>(std::clamp(cell, 0.0F, static_cast<float>(count - 1)));
}

using CornerFlags = std::array<bool, limits::max_corners>;

// Only the corners with a flag; their positions lie inside the image.
void fill_grid(GrayView image, const Corners& corners, const CornerFlags& flags, CornerGrid& grid) {
  grid.columns = (image.width + CornerGrid::cell_px - 1) / CornerGrid::cell_px;
  grid.rows = (image.height + CornerGrid::cell_px - 1) / CornerGrid::cell_px;
  const auto cell = [&](const Corner& c) {
    return static_cast<std::size_t>(grid_cell(c.y, grid.rows) * grid.columns + grid_cell(c.x, grid.columns));
  };
  const auto cells = static_cast<std::size_t>(grid.columns * grid.rows);
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

// Calls visit(index, squared distance) for every corner of the grid within `radius` of (x, y).
template <typename Visit>
void for_each_near(const CornerGrid& grid, const Corners& corners, float x, float y, float radius, Visit visit) {
  const std::int32_t x0 = grid_cell(x - radius, grid.columns), x1 = grid_cell(x + radius, grid.columns);
  for (std::int32_t row = grid_cell(y - radius, grid.rows); row <= grid_cell(y + radius, grid.rows); ++row) {
    const auto first = static_cast<std::size_t>(row * grid.columns + x0);
    const auto last = static_cast<std::size_t>(row * grid.columns + x1);
    for (std::size_t k = grid.begin[first]; k < grid.begin[last + 1]; ++k) {
      const std::size_t i = grid.items[k];
      const float dx = corners[i].x - x, dy = corners[i].y - y;
      const float squared = dx * dx + dy * dy;
      if (squared <= radius * radius) visit(i, squared);
    }
  }
}

void extract_patches(const SmoothView& a, const Corners& corners_a, const SmoothView& b, const Corners& corners_b,
                     const double (&h)[9], std::int32_t side, MatcherWorkspace& w) {
  for (std::size_t i = 0; i < corners_a.size(); ++i) {
    const Corner& c = corners_a[i];
    Linear2 a_from_b;
    w.usable_a[i] = predict(h, c, w.predicted[i]) && invert(w.predicted[i].b_from_a, a_from_b) &&
                    extract_patch(a, c.x, c.y, a_from_b, side, min_patch_stddev, w.patches_a[i]);
    w.best_a[i] = {0, 0, none};
  }
  for (std::size_t i = 0; i < corners_b.size(); ++i) {
    const Corner& c = corners_b[i];
    w.usable_b[i] = extract_patch(b, c.x, c.y, {}, side, min_patch_stddev, w.patches_b[i]);
    w.best_b[i] = {0, 0, none};
  }
}

void offer(std::int32_t score, std::size_t other, MatcherWorkspace::Best& best) {
  if (score > best.score) {
    best.second = best.score;
    best.score = score;
    best.other = static_cast<std::uint16_t>(other);
  } else if (score > best.second) {
    best.second = score;
  }
}

// Correlates every corner of a with all corners of b around its predicted position.
void search(const Corners& corners_a, const Corners& corners_b, const MatcherParams& params, MatcherWorkspace& w) {
  for (std::size_t i = 0; i < corners_a.size(); ++i) {
    if (!w.usable_a[i]) continue;
    const auto compare = [&](std::size_t j, float) {
      const std::int32_t score = correlate(w.patches_a[i], w.patches_b[j], params.patch_side_px);
      offer(score, j, w.best_a[i]);
      offer(score, i, w.best_b[j]);
    };
    for_each_near(w.grid_b, corners_b, w.predicted[i].x, w.predicted[i].y, params.search_radius_px, compare);
  }
}

bool unambiguous(const MatcherWorkspace::Best& best, const MatcherParams& params) {
  const auto score = static_cast<float>(best.score);
  return score >= params.min_score * normalized_patch_square &&
         static_cast<float>(best.second) <= params.max_second_ratio * score;
}

// Sub-pixel position in b of corner i of a, near (x, y); the score is at least `min_score`.
bool refine(std::size_t i, const Corner& a, float x, float y, float min_score, const SmoothView& image_a,
            const SmoothView& image_b, const MatcherParams& params, MatcherWorkspace& w, Match& match) {
  if (!prepare_patch(image_a, a.x, a.y, params.patch_side_px, w.patch)) return false;
  PatchWarp warp{x, y, w.predicted[i].b_from_a, 0};
  if (!register_patch(w.patch, image_b, warp)) return false;
  const float dx = warp.x - x, dy = warp.y - y;
  if (dx * dx + dy * dy > params.max_refinement_px * params.max_refinement_px || warp.ncc < min_score) return false;
  match = {static_cast<std::uint16_t>(i), none, std::min(warp.ncc, 1.0F), warp.x, warp.y};
  return true;
}

// Fills match_of_a, matched_a and matched_b with the mutual best.
void match_mutual_best(const Corners& corners_a, const Corners& corners_b, const SmoothView& a, const SmoothView& b,
                       const MatcherParams& params, MatcherWorkspace& w) {
  w.matched_a.fill(false);
  w.matched_b.fill(false);
  for (std::size_t i = 0; i < corners_a.size(); ++i) {
    const std::uint16_t j = w.best_a[i].other;
    if (j == none || w.best_b[j].other != i) continue;
    if (!unambiguous(w.best_a[i], params) || !unambiguous(w.best_b[j], params)) continue;
    Match& match = w.match_of_a[i];
    if (!refine(i, corners_a[i], corners_b[j].x, corners_b[j].y, params.min_score, a, b, params, w, match)) continue;
    match.b = j;
    w.matched_a[i] = w.matched_b[j] = true;
  }
}

/// How far the nearest matches lie from their prediction: the median of each coordinate.
struct LocalDeviation {
  float x, y;
};

// Insertion sort: a handful of values.
float median_of(float* values, std::size_t count) {
  for (std::size_t i = 1; i < count; ++i) {
    const float value = values[i];
    std::size_t k = i;
    for (; k > 0 && values[k - 1] > value; --k) values[k] = values[k - 1];
    values[k] = value;
  }
  return values[count / 2];
}

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

// The corner of b that a tracked position belongs to: a free one nearby, a new one, or `none` when the place is taken
// or no room is left. `first_new` is where the new ones begin.
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

// Corners of a without a match, where their neighbours say.
void track_unmatched(GrayView image_a, const Corners& corners_a, Corners& corners_b, const SmoothView& a,
                     const SmoothView& b, const MatcherParams& params, MatcherWorkspace& w) {
  fill_grid(image_a, corners_a, w.matched_a, w.grid_a);
  const std::size_t first_new = corners_b.size();
  for (std::size_t i = 0; i < corners_a.size(); ++i) {
    if (w.matched_a[i] || !w.usable_a[i]) continue;
    LocalDeviation deviation;
    if (!local_deviation(corners_a[i], corners_a, w, deviation)) continue;
    const float x = w.predicted[i].x + deviation.x, y = w.predicted[i].y + deviation.y;
    Match& match = w.match_of_a[i];
    if (!refine(i, corners_a[i], x, y, params.min_tracked_score, a, b, params, w, match)) continue;
    match.b = corner_at(match.xb, match.yb, first_new, corners_b, w);
    if (match.b == none) continue;
    w.matched_a[i] = w.matched_b[match.b] = true;
  }
}

void smooth_both(GrayView image_a, GrayView image_b, MatcherWorkspace& w) {
  smooth(image_a, {w.smooth_a.data(), image_a.width, image_a.height});
  smooth(image_b, {w.smooth_b.data(), image_b.width, image_b.height});
}

void match_detections(GrayView image_a, const Corners& corners_a, GrayView image_b, const Corners& corners_b,
                      const double (&plane)[9], const MatcherParams& params, MatcherWorkspace& w) {
  const SmoothView a(w.smooth_a.data(), image_a.width, image_a.height);
  const SmoothView b(w.smooth_b.data(), image_b.width, image_b.height);
  extract_patches(a, corners_a, b, corners_b, plane, params.patch_side_px, w);
  fill_grid(image_b, corners_b, w.usable_b, w.grid_b);
  search(corners_a, corners_b, params, w);
  match_mutual_best(corners_a, corners_b, a, b, params, w);
}

Status list_matches(std::size_t corners_a, const MatcherWorkspace& w, Matches& matches) {
  for (std::size_t i = 0; i < corners_a; ++i) {
    if (w.matched_a[i]) ILP_ASSERT(matches.push_back(w.match_of_a[i]), i);
  }
  return {};
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
  matches.clear();
  ILP_TRY(check(image_a, image_b, plane_b_from_a, params));
  if (image_a.empty() || image_b.empty()) return {};
  smooth_both(image_a, image_b, w);
  match_detections(image_a, corners_a, image_b, corners_b, plane_b_from_a, params, w);
  return list_matches(corners_a.size(), w, matches);
}

Status match_and_track_corners(GrayView image_a, const Corners& corners_a, GrayView image_b, Corners& corners_b,
                               const double (&plane_b_from_a)[9], const MatcherParams& params, MatcherWorkspace& w,
                               Matches& matches) {
  matches.clear();
  ILP_TRY(check(image_a, image_b, plane_b_from_a, params));
  if (image_a.empty() || image_b.empty()) return {};
  smooth_both(image_a, image_b, w);
  match_detections(image_a, corners_a, image_b, corners_b, plane_b_from_a, params, w);
  const SmoothView a(w.smooth_a.data(), image_a.width, image_a.height);
  const SmoothView b(w.smooth_b.data(), image_b.width, image_b.height);
  track_unmatched(image_a, corners_a, corners_b, a, b, params, w);
  return list_matches(corners_a.size(), w, matches);
}

}  // namespace ilp
