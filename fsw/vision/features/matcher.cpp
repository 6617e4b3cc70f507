#include "fsw/vision/features/matcher.hpp"

#include "fsw/base/math.hpp"
#include "fsw/vision/features/match_steps.hpp"

namespace ilp {
namespace {

constexpr std::uint16_t none = MatcherWorkspace::none;

void extract_patches(const SmoothView& a, const Corners& corners_a, const SmoothView& b, const Corners& corners_b,
                     const double (&h)[9], std::int32_t side, MatcherWorkspace& w) {
  for (std::size_t i = 0; i < corners_a.size(); ++i) {
    w.usable_a[i] = predict(h, corners_a[i], w.predicted[i]) && extract_warped_patch(a, corners_a[i], i, side, w);
    w.best_a[i] = {0, 0, none};
  }
  for (std::size_t i = 0; i < corners_b.size(); ++i) {
    const Corner& c = corners_b[i];
    w.usable_b[i] = extract_patch(b, c.x, c.y, {}, side, min_patch_stddev_grey, w.patches_b[i]);
    w.best_b[i] = {0, 0, none};
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

// Fills match_of_a, matched_a and matched_b with the mutual best.
void match_mutual_best(const Corners& corners_a, const Corners& corners_b, const SmoothView& a, const SmoothView& b,
                       const MatcherParams& params, MatcherWorkspace& w) {
  w.matched_a.fill(false);
  w.matched_b.fill(false);
  for (std::size_t i = 0; i < corners_a.size(); ++i) {
    const std::uint16_t j = w.best_a[i].other;
    if (j == none || w.best_b[j].other != i) continue;
    if (!unambiguous(w.best_a[i], params.min_score, params.max_second_ratio) ||
        !unambiguous(w.best_b[j], params.min_score, params.max_second_ratio)) {
      continue;
    }
    Match& match = w.match_of_a[i];
    if (!refine_match(i, corners_a[i], corners_b[j].x, corners_b[j].y, params.min_score, a, b, params, w, match))
      continue;
    match.b = j;
    w.matched_a[i] = w.matched_b[j] = true;
  }
}

// Tracks corners of a without a match from the place that their neighbours predict.
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
    if (!refine_match(i, corners_a[i], x, y, params.min_tracked_score, a, b, params, w, match)) continue;
    match.b = corner_at(match.xb, match.yb, first_new, corners_b, w);
    if (match.b == none) continue;
    w.matched_a[i] = w.matched_b[match.b] = true;
  }
}

/// Matches the corners of both images, which end in the workspace. If `tracked_b` is given, unmatched corners are
/// followed into image b, where they end at a free corner or a new one.
Status match(GrayView image_a, const Corners& corners_a, GrayView image_b, const Corners& corners_b,
             const double (&plane)[9], const MatcherParams& params, MatcherWorkspace& w, Corners* tracked_b,
             Matches& matches) {
  matches.clear();
  ILP_TRY(check_matching(image_a, image_b, plane, params));
  if (image_a.empty() || image_b.empty()) return {};
  smooth_both(image_a, image_b, w);
  const SmoothView a(w.smooth_a.data(), image_a.width, image_a.height);
  const SmoothView b(w.smooth_b.data(), image_b.width, image_b.height);
  extract_patches(a, corners_a, b, corners_b, plane, params.patch_side_px, w);
  fill_grid(image_b, corners_b, w.usable_b, w.grid_b);
  search(corners_a, corners_b, params, w);
  match_mutual_best(corners_a, corners_b, a, b, params, w);
  if (tracked_b != nullptr) track_unmatched(image_a, corners_a, *tracked_b, a, b, params, w);
  return list_matches(corners_a.size(), w, matches);
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

}  // namespace ilp
