#include "sim/tools/lab/guided_matcher.hpp"

#include "fsw/base/argument.hpp"
#include "fsw/vision/features/match_steps.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

// A detection lies this far from its true place: the detector's error under a change of view.
constexpr double detector_px = 2;
// Step of the search along a line, px; registration converges from half of it.
constexpr float line_step_px = 2;
constexpr std::int32_t max_line_steps = 64;
// Places nearer to the best place along a line belong to its peak and are no rivals.
constexpr std::int32_t peak_steps = 2;

struct Guide {
  explicit Guide(const MatchGuide& g) : source(g) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) matrix(r, c) = g.matrix[3 * r + c];
    }
  }

  [[nodiscard]] Vec2 ideal_a(const Corner& c) const { return ideal_from_pixel(source.camera_a, Vec2(c.x, c.y)); }
  [[nodiscard]] Vec2 ideal_b(float x, float y) const { return ideal_from_pixel(source.camera_b, Vec2(x, y)); }

  /// Maps a by the plane; false beyond the horizon.
  [[nodiscard]] bool transfer(const Vec2& a, Vec2& b) const {
    const Vec3 p = matrix * Vec3(a.x(), a.y(), 1);
    if (!(std::fabs(p.z()) > 1e-12)) return false;
    b = Vec2(p.x() / p.z(), p.y() / p.z());
    return true;
  }

  [[nodiscard]] Vec3 line_in_b(const Vec2& a) const { return matrix * Vec3(a.x(), a.y(), 1); }

  /// Squared px.
  [[nodiscard]] double distance_squared(const Vec2& a, const Vec2& b) const {
    constexpr double never = 1e12;
    if (source.kind == GuideKind::plane) {
      Vec2 there;
      return transfer(a, there) ? (there - b).squaredNorm() : never;
    }
    const Vec3 line = line_in_b(a);
    const Vec3 back = matrix.transpose() * Vec3(b.x(), b.y(), 1);
    const double residual = line.x() * b.x() + line.y() * b.y() + line.z();
    const double slope = line.head<2>().squaredNorm() + back.head<2>().squaredNorm();
    return slope > 0 ? residual * residual / slope : never;
  }

  const MatchGuide& source;
  Mat3 matrix;
};

Status check(const MatchGuide& guide, const GuidedParams& p) {
  ILP_TRY(validate(guide.camera_a));
  ILP_TRY(validate(guide.camera_b));
  bool zero = true;
  for (const double value : guide.matrix) {
    if (!(std::fabs(value) < 1e12)) return out_of_range(Argument::guide, value);
    zero = zero && value == 0;
  }
  if (zero) return out_of_range(Argument::guide, 0);
  const bool good = p.max_distance_px > 0 && p.max_distance_px <= 20 && p.search_radius_px > 0 &&
                    p.search_radius_px <= static_cast<float>(limits::max_image_side) && p.min_score > 0 &&
                    p.min_score <= 1 && p.max_second_ratio > 0 && p.max_second_ratio <= 1;
  return good ? Status{} : out_of_range(Argument::match_parameters);
}

struct GuidedPass {
  GrayView image_a, image_b;
  SmoothView a, b;
  const Corners& corners_a;
  Corners& corners_b;
  const double (&plane)[9];
  Guide guide;
  const MatcherParams& params;
  const GuidedParams& guided;
  MatcherWorkspace& w;

  // Takes over the matches that agree with the guide.
  Status keep(const Matches& matches) {
    w.matched_a.fill(false);
    w.matched_b.fill(false);
    for (std::size_t k = 0; k < matches.size(); ++k) {
      const Match& m = matches[k];
      if (m.a >= corners_a.size() || m.b >= corners_b.size() || w.matched_a[m.a] || w.matched_b[m.b]) {
        return out_of_range(Argument::match, k);
      }
      if (!predict(plane, corners_a[m.a], w.predicted[m.a]) || !agrees(m)) continue;
      w.match_of_a[m.a] = m;
      w.matched_a[m.a] = w.matched_b[m.b] = true;
    }
    return {};
  }

  [[nodiscard]] bool agrees(const Match& m) const {
    const double bound = static_cast<double>(guided.max_distance_px);
    return guide.distance_squared(guide.ideal_a(corners_a[m.a]), guide.ideal_b(m.xb, m.yb)) <= bound * bound;
  }

  void extract_free_patches() {
    for (std::size_t i = 0; i < corners_a.size(); ++i) {
      w.usable_a[i] = !w.matched_a[i] && predict(plane, corners_a[i], w.predicted[i]) &&
                      extract_warped_patch(a, corners_a[i], i, params.patch_side_px, w);
      w.best_a[i] = {0, 0, MatcherWorkspace::none};
    }
    for (std::size_t j = 0; j < corners_b.size(); ++j) {
      const Corner& c = corners_b[j];
      w.usable_b[j] = !w.matched_b[j] &&
                      extract_patch(b, c.x, c.y, {}, params.patch_side_px, min_patch_stddev_grey, w.patches_b[j]);
      w.best_b[j] = {0, 0, MatcherWorkspace::none};
    }
  }

  // The expected place of corner i: by the plane, or by the prediction and the matches around it.
  [[nodiscard]] Vec2 expected(std::size_t i) const {
    Vec2 there;
    if (guide.source.kind == GuideKind::plane && guide.transfer(guide.ideal_a(corners_a[i]), there)) {
      return pixel_from_ideal(guide.source.camera_b, there);
    }
    LocalDeviation deviation;
    (void)local_deviation(corners_a[i], corners_a, w, deviation);
    return {static_cast<double>(w.predicted[i].x + deviation.x), static_cast<double>(w.predicted[i].y + deviation.y)};
  }

  // Matches free corners of both images that agree with the guide.
  void match_detections() {
    fill_grid(image_b, corners_b, w.usable_b, w.grid_b);
    const bool line = guide.source.kind == GuideKind::line;
    const double reach = static_cast<double>(guided.max_distance_px) + detector_px;
    const float radius = line ? guided.search_radius_px : static_cast<float>(reach);
    for (std::size_t i = 0; i < corners_a.size(); ++i) {
      if (!w.usable_a[i]) continue;
      const Vec2 centre = expected(i);
      const Vec2 ideal = guide.ideal_a(corners_a[i]);
      const auto compare = [&](std::size_t j, float) {
        if (guide.distance_squared(ideal, guide.ideal_b(corners_b[j].x, corners_b[j].y)) > reach * reach) return;
        const std::int32_t score = correlate(w.patches_a[i], w.patches_b[j], params.patch_side_px);
        offer(score, j, w.best_a[i]);
        offer(score, i, w.best_b[j]);
      };
      for_each_near(w.grid_b, corners_b, static_cast<float>(centre.x()), static_cast<float>(centre.y()), radius,
                    compare);
    }
    for (std::size_t i = 0; i < corners_a.size(); ++i) {
      const std::uint16_t j = w.best_a[i].other;
      if (!w.usable_a[i] || j == MatcherWorkspace::none || w.best_b[j].other != i) continue;
      if (!unambiguous(w.best_a[i], guided.min_score, guided.max_second_ratio) ||
          !unambiguous(w.best_b[j], guided.min_score, guided.max_second_ratio)) {
        continue;
      }
      Match& match = w.match_of_a[i];
      if (!refine_match(i, corners_a[i], corners_b[j].x, corners_b[j].y, guided.min_score, a, b, params, w, match) ||
          !agrees(match)) {
        continue;
      }
      match.b = j;
      w.matched_a[i] = w.matched_b[j] = true;
    }
  }

  // Finds the best place along corner i's epipolar line around (x, y); false without a distinct one.
  bool search_line(std::size_t i, float& x, float& y) {
    const Vec2 start = guide.ideal_b(x, y);
    const Vec3 line = guide.line_in_b(guide.ideal_a(corners_a[i]));
    const double slope = line.head<2>().norm();
    if (!(slope > 0)) return false;
    const Vec2 normal = line.head<2>() / slope;
    const Vec2 foot = start - (line.head<2>().dot(start) + line.z()) / slope * normal;
    const Vec2 along(-normal.y(), normal.x());
    const auto reach = std::min(static_cast<std::int32_t>(guided.search_radius_px / line_step_px), max_line_steps);
    std::int32_t scores[2 * max_line_steps + 1] = {};
    std::int32_t best = 0;
    for (std::int32_t k = -reach; k <= reach; ++k) {
      const Vec2 ideal = foot + static_cast<double>(static_cast<float>(k) * line_step_px) * along;
      const Vec2 at = pixel_from_ideal(guide.source.camera_b, ideal);
      const auto u = static_cast<float>(at.x()), v = static_cast<float>(at.y());
      std::int32_t& score = scores[k + reach];
      if (extract_patch(b, u, v, {}, params.patch_side_px, min_patch_stddev_grey, w.candidate)) {
        score = correlate(w.patches_a[i], w.candidate, params.patch_side_px);
      }
      if (score <= scores[best]) continue;
      best = k + reach;
      x = u;
      y = v;
    }
    std::int32_t second = 0;
    for (std::int32_t k = 0; k <= 2 * reach; ++k) {
      if (k < best - peak_steps || k > best + peak_steps) second = std::max(second, scores[k]);
    }
    return unambiguous({scores[best], second, MatcherWorkspace::none}, guided.min_score, guided.max_second_ratio);
  }

  // Tracks corners that were not detected in b.
  void track() {
    const std::size_t first_new = corners_b.size();
    for (std::size_t j = 0; j < first_new; ++j) w.usable_b[j] = w.usable_b[j] || w.matched_b[j];
    fill_grid(image_b, corners_b, w.usable_b, w.grid_b);
    for (std::size_t i = 0; i < corners_a.size(); ++i) {
      if (w.matched_a[i] || !w.usable_a[i]) continue;
      const Vec2 at = expected(i);
      float x = static_cast<float>(at.x()), y = static_cast<float>(at.y());
      if (guide.source.kind == GuideKind::line && !search_line(i, x, y)) continue;
      Match& match = w.match_of_a[i];
      if (!refine_match(i, corners_a[i], x, y, params.min_tracked_score, a, b, params, w, match) || !agrees(match)) {
        continue;
      }
      match.b = corner_at(match.xb, match.yb, first_new, corners_b, w);
      if (match.b == MatcherWorkspace::none) continue;
      w.matched_a[i] = w.matched_b[match.b] = true;
    }
  }
};

}  // namespace

MatchGuide guide_of_pose(const RigidTransform& b_from_a, const CameraModel& camera_a, const CameraModel& camera_b) {
  const auto normalised_from_pixel_matrix = [](const CameraModel& c) {
    Mat3 m;
    m << 1 / c.fx, 0, -c.cx / c.fx, 0, 1 / c.fy, -c.cy / c.fy, 0, 0, 1;
    return m;
  };
  const Mat3 essential = cross_matrix(b_from_a.translation) * b_from_a.rotation;
  const Mat3 fundamental =
      normalised_from_pixel_matrix(camera_b).transpose() * essential * normalised_from_pixel_matrix(camera_a);
  MatchGuide guide;
  for (int i = 0; i < 9; ++i) guide.matrix[i] = fundamental(i / 3, i % 3);
  guide.camera_a = camera_a;
  guide.camera_b = camera_b;
  return guide;
}

Status match_guided(GrayView image_a, const Corners& corners_a, GrayView image_b, Corners& corners_b,
                    const double (&plane_b_from_a)[9], const MatchGuide& guide, const MatcherParams& params,
                    const GuidedParams& guided, MatcherWorkspace& w, Matches& matches) {
  ILP_TRY(check_matching(image_a, image_b, plane_b_from_a, params));
  ILP_TRY(check(guide, guided));
  GuidedPass pass{image_a,
                  image_b,
                  SmoothView(w.smooth_a.data(), image_a.width, image_a.height),
                  SmoothView(w.smooth_b.data(), image_b.width, image_b.height),
                  corners_a,
                  corners_b,
                  plane_b_from_a,
                  Guide(guide),
                  params,
                  guided,
                  w};
  ILP_TRY(pass.keep(matches));
  matches.clear();
  if (image_a.empty() || image_b.empty()) return {};
  smooth_both(image_a, image_b, w);
  pass.extract_free_patches();
  fill_grid(image_a, corners_a, w.matched_a, w.grid_a);
  pass.match_detections();
  fill_grid(image_a, corners_a, w.matched_a, w.grid_a);
  pass.track();
  return list_matches(corners_a.size(), w, matches);
}

}  // namespace ilp
