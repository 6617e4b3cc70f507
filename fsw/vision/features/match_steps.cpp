#include "fsw/vision/features/match_steps.hpp"

#include <utility>

#include "fsw/base/argument.hpp"

namespace ilp {
namespace {

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

}  // namespace

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
  const auto share = [](float value) { return value > 0 && value <= 1; };
  if (!share(params.min_score) || !share(params.min_tracked_score) || !share(params.max_second_ratio) ||
      !(params.max_refinement_px > 0)) {
    return out_of_range(Argument::match_parameters);
  }
  return {};
}

void smooth_both(GrayView image_a, GrayView image_b, MatcherWorkspace& w) {
  smooth(image_a, {w.smooth_a.data(), image_a.width, image_a.height});
  smooth(image_b, {w.smooth_b.data(), image_b.width, image_b.height});
}

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

bool extract_warped_patch(SmoothView a, const Corner& corner, std::size_t i, std::int32_t side, MatcherWorkspace& w) {
  Linear2 a_from_b;
  return invert(w.predicted[i].b_from_a, a_from_b) &&
         extract_patch(a, corner.x, corner.y, a_from_b, side, min_patch_stddev_grey, w.patches_a[i]);
}

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

void offer(std::int32_t score, std::size_t other, MatcherWorkspace::Best& best) {
  if (score > best.score) {
    best.second = best.score;
    best.score = score;
    best.other = static_cast<std::uint16_t>(other);
  } else if (score > best.second) {
    best.second = score;
  }
}

bool unambiguous(const MatcherWorkspace::Best& best, float min_score, float max_second_ratio) {
  const auto score = static_cast<float>(best.score);
  return score >= min_score * normalized_patch_square && static_cast<float>(best.second) <= max_second_ratio * score;
}

bool refine_match(std::size_t i, const Corner& a, float x, float y, float min_score, SmoothView image_a,
                  SmoothView image_b, const MatcherParams& params, MatcherWorkspace& w, Match& match) {
  if (!prepare_patch(image_a, a.x, a.y, params.patch_side_px, w.patch)) return false;
  PatchWarp warp{x, y, w.predicted[i].b_from_a, 0};
  if (!register_patch(w.patch, image_b, warp)) return false;
  const float dx = warp.x - x, dy = warp.y - y;
  if (dx * dx + dy * dy > params.max_refinement_px * params.max_refinement_px || warp.ncc < min_score) return false;
  match = {static_cast<std::uint16_t>(i), MatcherWorkspace::none, std::min(warp.ncc, 1.0F), warp.x, warp.y};
  return true;
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

std::uint16_t corner_at(float x, float y, std::size_t first_new, Corners& corners_b, MatcherWorkspace& w) {
  constexpr std::uint16_t none = MatcherWorkspace::none;
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

}  // namespace ilp
