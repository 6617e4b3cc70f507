#include "fsw/vision/features/matcher.hpp"

#include <algorithm>
#include <cmath>

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

// Usable corners only: their positions are known to be inside.
void fill_grid(GrayView image, const Corners& corners, MatcherWorkspace& w) {
  CornerGrid& grid = w.grid;
  grid.columns = (image.width + CornerGrid::cell_px - 1) / CornerGrid::cell_px;
  grid.rows = (image.height + CornerGrid::cell_px - 1) / CornerGrid::cell_px;
  const auto cell = [&](const Corner& c) {
    return static_cast<std::size_t>(grid_cell(c.y, grid.rows) * grid.columns + grid_cell(c.x, grid.columns));
  };
  const auto cells = static_cast<std::size_t>(grid.columns * grid.rows);
  std::fill_n(grid.begin.begin(), cells + 1, std::uint16_t{0});
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (w.best_b[i].usable) ++grid.begin[cell(corners[i])];
  }
  for (std::size_t i = 1; i <= cells; ++i) {
    grid.begin[i] = static_cast<std::uint16_t>(grid.begin[i] + grid.begin[i - 1]);
  }
  // Filled from the back, every cell's begin ends where its first item is.
  for (std::size_t i = corners.size(); i-- > 0;) {
    if (w.best_b[i].usable) grid.items[--grid.begin[cell(corners[i])]] = static_cast<std::uint16_t>(i);
  }
}

void extract_patches(GrayView image_a, const Corners& corners_a, GrayView image_b, const Corners& corners_b,
                     const double (&h)[9], std::int32_t side, MatcherWorkspace& w) {
  const SmoothView a(w.smooth_a.data(), image_a.width, image_a.height);
  const SmoothView b(w.smooth_b.data(), image_b.width, image_b.height);
  for (std::size_t i = 0; i < corners_a.size(); ++i) {
    const Corner& c = corners_a[i];
    Linear2 a_from_b;
    const bool usable = predict(h, c, w.predicted[i]) && invert(w.predicted[i].b_from_a, a_from_b) &&
                        extract_patch(a, c.x, c.y, a_from_b, side, min_patch_stddev, w.patches_a[i]);
    w.best_a[i] = {0, 0, none, usable};
  }
  for (std::size_t i = 0; i < corners_b.size(); ++i) {
    const Corner& c = corners_b[i];
    w.best_b[i] = {0, 0, none, extract_patch(b, c.x, c.y, {}, side, min_patch_stddev, w.patches_b[i])};
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

// Correlates corner i of a with all corners of b around (x, y).
void search(std::size_t i, float x, float y, float radius, std::int32_t side, const Corners& corners_b,
            MatcherWorkspace& w) {
  const CornerGrid& grid = w.grid;
  const std::int32_t x0 = grid_cell(x - radius, grid.columns), x1 = grid_cell(x + radius, grid.columns);
  for (std::int32_t row = grid_cell(y - radius, grid.rows); row <= grid_cell(y + radius, grid.rows); ++row) {
    const std::int32_t first = row * grid.columns;
    for (std::size_t k = grid.begin[static_cast<std::size_t>(first + x0)];
         k < grid.begin[static_cast<std::size_t>(first + x1 + 1)]; ++k) {
      const std::size_t j = grid.items[k];
      const float dx = corners_b[j].x - x, dy = corners_b[j].y - y;
      if (dx * dx + dy * dy > radius * radius) continue;
      const std::int32_t score = correlate(w.patches_a[i], w.patches_b[j], side);
      offer(score, j, w.best_a[i]);
      offer(score, i, w.best_b[j]);
    }
  }
}

bool unambiguous(const MatcherWorkspace::Best& best, const MatcherParams& params) {
  const auto score = static_cast<float>(best.score);
  return score >= params.min_score * normalized_patch_square &&
         static_cast<float>(best.second) <= params.max_second_ratio * score;
}

// Sub-pixel position of corner i in b, starting at corner j.
bool refine(std::size_t i, std::size_t j, const Corner& a, const Corner& b, const SmoothView& image_a,
            const SmoothView& image_b, const MatcherParams& params, MatcherWorkspace& w, Match& match) {
  if (!prepare_patch(image_a, a.x, a.y, params.patch_side_px, w.patch)) return false;
  PatchWarp warp{b.x, b.y, w.predicted[i].b_from_a, 0};
  if (!register_patch(w.patch, image_b, warp)) return false;
  const float dx = warp.x - b.x, dy = warp.y - b.y;
  if (dx * dx + dy * dy > params.max_refinement_px * params.max_refinement_px || warp.ncc < params.min_score) {
    return false;
  }
  match = {static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(j), std::min(warp.ncc, 1.0F), warp.x, warp.y};
  return true;
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
  smooth(image_a, {w.smooth_a.data(), image_a.width, image_a.height});
  smooth(image_b, {w.smooth_b.data(), image_b.width, image_b.height});
  const SmoothView a(w.smooth_a.data(), image_a.width, image_a.height);
  const SmoothView b(w.smooth_b.data(), image_b.width, image_b.height);

  extract_patches(image_a, corners_a, image_b, corners_b, plane_b_from_a, params.patch_side_px, w);
  fill_grid(image_b, corners_b, w);
  for (std::size_t i = 0; i < corners_a.size(); ++i) {
    if (!w.best_a[i].usable) continue;
    search(i, w.predicted[i].x, w.predicted[i].y, params.search_radius_px, params.patch_side_px, corners_b, w);
  }
  for (std::size_t i = 0; i < corners_a.size(); ++i) {
    const std::size_t j = w.best_a[i].other;
    if (j == none || w.best_b[j].other != i) continue;
    if (!unambiguous(w.best_a[i], params) || !unambiguous(w.best_b[j], params)) continue;
    Match match;
    if (!refine(i, j, corners_a[i], corners_b[j], a, b, params, w, match)) continue;
    ILP_ASSERT(matches.push_back(match), matches.size());
  }
  return {};
}

}  // namespace ilp
