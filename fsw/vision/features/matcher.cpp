#include "fsw/vision/features/matcher.hpp"

#include <algorithm>

#include "fsw/base/math.hpp"
#include "fsw/vision/features/match_steps.hpp"

namespace ilp {
namespace {

constexpr std::uint16_t none = MatcherWorkspace::none;

using Part = MatcherWorkspace::Part;

// A slice takes about 10 ms on a processor of 1000 MIPS.
constexpr std::size_t patches_of_a_slice = 700;
constexpr std::size_t searches_of_a_slice = 300;
constexpr std::size_t refinements_of_a_slice = 150;

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
  if (!unambiguous(w.best_a[i], params.min_score, params.max_second_ratio) ||
      !unambiguous(w.best_b[j], params.min_score, params.max_second_ratio)) {
    return;
  }
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
  const float least = pair.params.min_tracked_score;
  if (!refine_match(i, pair.corners_a[i], x, y, least, pair.a(), pair.b(), pair.params, w, match)) return;
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
