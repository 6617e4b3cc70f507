#include "fsw/vision/place/place_verification.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/vision/place/descriptor_distance.hpp"
#include "fsw/vision/place/place_match_workspace.hpp"

namespace ilp {
namespace {

using Features = std::span<const PlaceFeature>;
using Alike = PlaceMatchWorkspace::Alike;

constexpr std::size_t tried_matches = 40;
constexpr int rotation_bins = 32;
constexpr int angle_tolerance = 14;  // 20 degrees
constexpr float min_base_px = 20;    // between the two matches that give a similarity
constexpr float max_scale = 3;
constexpr float inlier_cell_px = 30, guided_cell_px = 40;

// x_b = m x_a + t with complex numbers.
struct Similar {
  float m_re = 1, m_im = 0, t_x = 0, t_y = 0;

  void apply(float x, float y, float& u, float& v) const {
    u = m_re * x - m_im * y + t_x;
    v = m_im * x + m_re * y + t_y;
  }
};

// Counts the squares of an image in which something was put.
class Cells {
 public:
  explicit Cells(float side_px) : side_px_(side_px) {}
  void put(float x, float y) {
    const auto column = static_cast<std::size_t>(std::max(x, 0.0F) / side_px_);
    const auto row = static_cast<std::size_t>(std::max(y, 0.0F) / side_px_);
    bool& cell = used_[std::min(row, side - 1) * side + std::min(column, side - 1)];
    count_ += cell ? 0 : 1;
    cell = true;
  }
  [[nodiscard]] int count() const { return count_; }

 private:
  static constexpr std::size_t side = limits::max_image_side / 30 + 1;
  float side_px_;
  int count_ = 0;
  bool used_[side * side] = {};
};

void compare_all(Features older, Features newer, PlaceMatchWorkspace& w) {
  for (std::size_t a = 0; a < older.size(); ++a) {
    for (std::size_t b = 0; b < newer.size(); ++b) {
      w.distance[a][b] =
          static_cast<std::uint8_t>(std::min(hamming_256(older[a].descriptor, newer[b].descriptor), 255));
    }
  }
}

int angle_between(std::uint8_t from, std::uint8_t to) {
  return std::abs(static_cast<int>(static_cast<std::int8_t>(static_cast<std::uint8_t>(to - from))));
}

// Mutual nearest neighbours among the pairs that `allowed` and within max_bits.
template <typename Allowed>
void match_mutually(Features older, Features newer, int max_bits, Allowed&& allowed, PlaceMatchWorkspace& w) {
  w.matches.clear();
  for (std::size_t b = 0; b < newer.size(); ++b) {
    int best = 256;
    for (std::size_t a = 0; a < older.size(); ++a) {
      if (w.distance[a][b] < best && allowed(a, b)) {
        best = w.distance[a][b];
        w.best_of_b[b] = static_cast<std::uint16_t>(a);
      }
    }
    if (best > max_bits) w.best_of_b[b] = limits::max_place_features;
  }
  for (std::size_t a = 0; a < older.size(); ++a) {
    int best = 256;
    std::size_t best_b = 0;
    for (std::size_t b = 0; b < newer.size(); ++b) {
      if (w.distance[a][b] < best && allowed(a, b)) {
        best = w.distance[a][b];
        best_b = b;
      }
    }
    if (best > max_bits || w.best_of_b[best_b] != a) continue;
    (void)w.matches.push_back({older[a].x, older[a].y, newer[best_b].x, newer[best_b].y, static_cast<std::uint16_t>(a),
                               static_cast<std::uint16_t>(best_b), static_cast<std::uint8_t>(best)});
  }
}

std::uint8_t dominant_rotation(Features older, Features newer, const PlaceMatchWorkspace& w) {
  int votes[rotation_bins] = {};
  for (const Alike& m : w.matches) {
    const auto rotation = static_cast<std::uint8_t>(newer[m.b].angle - older[m.a].angle);
    ++votes[rotation / (256 / rotation_bins)];
  }
  int best = 0, best_bin = 0;
  for (int k = 0; k < rotation_bins; ++k) {
    const int sum = votes[(k + rotation_bins - 1) % rotation_bins] + 2 * votes[k] + votes[(k + 1) % rotation_bins];
    if (sum > best) {
      best = sum;
      best_bin = k;
    }
  }
  return static_cast<std::uint8_t>(best_bin * (256 / rotation_bins) + 128 / rotation_bins);
}

bool similarity_of(const Alike& p, const Alike& q, Similar& s) {
  const float ax = q.xa - p.xa, ay = q.ya - p.ya, bx = q.xb - p.xb, by = q.yb - p.yb;
  const float aa = ax * ax + ay * ay, bb = bx * bx + by * by;
  if (aa < min_base_px * min_base_px || bb < min_base_px * min_base_px) return false;
  if (bb > max_scale * max_scale * aa || aa > max_scale * max_scale * bb) return false;
  s.m_re = (ax * bx + ay * by) / aa;
  s.m_im = (ax * by - ay * bx) / aa;
  s.t_x = p.xb - s.m_re * p.xa + s.m_im * p.ya;
  s.t_y = p.yb - s.m_im * p.xa - s.m_re * p.ya;
  return true;
}

std::uint8_t angle_of(const Similar& s) {
  const double turns = det_atan2(static_cast<double>(s.m_im), static_cast<double>(s.m_re)) * (128 / pi);
  return static_cast<std::uint8_t>(static_cast<std::int32_t>(std::floor(turns + 0.5)) & 255);
}

bool fits(const Similar& s, const Alike& m, float radius) {
  float u, v;
  s.apply(m.xa, m.ya, u, v);
  return (u - m.xb) * (u - m.xb) + (v - m.yb) * (v - m.yb) <= radius * radius;
}

// Least squares over the matches that are used; false when there are too few, or all in one place.
template <typename Used>
bool fit_similarity(const PlaceMatchWorkspace& w, Used&& used, Similar& s, double& residual) {
  double n = 0, xa = 0, ya = 0, xb = 0, yb = 0;
  for (const Alike& m : w.matches) {
    if (!used(m)) continue;
    n += 1;
    xa += m.xa;
    ya += m.ya;
    xb += m.xb;
    yb += m.yb;
  }
  if (n < 3) return false;
  xa /= n;
  ya /= n;
  xb /= n;
  yb /= n;
  double aa = 0, bb = 0, dot = 0, cross = 0;
  for (const Alike& m : w.matches) {
    if (!used(m)) continue;
    const double pa = m.xa - xa, qa = m.ya - ya, pb = m.xb - xb, qb = m.yb - yb;
    aa += pa * pa + qa * qa;
    bb += pb * pb + qb * qb;
    dot += pa * pb + qa * qb;
    cross += pa * qb - qa * pb;
  }
  if (!(aa > 0)) return false;
  const double re = dot / aa, im = cross / aa;
  s = {static_cast<float>(re), static_cast<float>(im), static_cast<float>(xb - re * xa + im * ya),
       static_cast<float>(yb - im * xa - re * ya)};
  residual = std::sqrt(std::max(bb - (dot * dot + cross * cross) / aa, 0.0) / (2 * n - 4));
  return true;
}

// The pairs that the similarity predicts: each feature with the most similar one near its predicted place.
void match_guided(Features older, Features newer, const Similar& s, const PlaceMatchParams& params,
                  PlaceMatchWorkspace& w) {
  const std::uint8_t rotation = angle_of(s);
  const float radius = params.guided_radius_px;
  const auto allowed = [&](std::size_t a, std::size_t b) {
    if (w.distance[a][b] > params.max_guided_bits) return false;
    const Alike m{older[a].x, older[a].y, newer[b].x, newer[b].y, 0, 0, 0};
    return fits(s, m, radius) &&
           angle_between(static_cast<std::uint8_t>(older[a].angle + rotation), newer[b].angle) <= angle_tolerance;
  };
  match_mutually(older, newer, params.max_guided_bits, allowed, w);
}

}  // namespace

Status verify_place(Features older, Features newer, const PlaceMatchParams& params, PlaceMatchWorkspace& w,
                    PlaceMatch& match) {
  match = {};
  if (std::max(older.size(), newer.size()) > limits::max_place_features) return {StatusCode::invalid_argument, 1};
  const auto least = static_cast<std::size_t>(std::max(params.min_inliers, 2));
  if (std::min(older.size(), newer.size()) < least) return {};

  match.verdict = PlaceVerdict::too_few_matches;
  compare_all(older, newer, w);
  match_mutually(
      older, newer, params.max_distance_bits, [](std::size_t, std::size_t) { return true; }, w);
  if (w.matches.size() < least) return {};
  const std::uint8_t rotation = dominant_rotation(older, newer, w);
  match_mutually(
      older, newer, params.max_distance_bits,
      [&](std::size_t a, std::size_t b) {
        return angle_between(static_cast<std::uint8_t>(older[a].angle + rotation), newer[b].angle) <= angle_tolerance;
      },
      w);
  if (w.matches.size() < least) return {};

  match.verdict = PlaceVerdict::no_similarity;
  const auto better = [](const Alike& p, const Alike& q) {
    return p.distance != q.distance ? p.distance < q.distance : p.a < q.a;
  };
  std::make_heap(w.matches.begin(), w.matches.end(), better);
  std::sort_heap(w.matches.begin(), w.matches.end(), better);
  const std::size_t tried = std::min(tried_matches, w.matches.size());
  Similar best;
  for (std::size_t i = 0; i < tried; ++i) {
    for (std::size_t k = i + 1; k < tried; ++k) {
      Similar s;
      if (!similarity_of(w.matches[i], w.matches[k], s)) continue;
      std::int32_t inliers = 0;
      for (const Alike& m : w.matches) inliers += fits(s, m, params.inlier_radius_px) ? 1 : 0;
      if (inliers <= match.inliers) continue;
      match.inliers = inliers;
      best = s;
    }
  }
  if (match.inliers < params.min_inliers) return {};
  match.verdict = PlaceVerdict::too_few_cells;
  Cells cells_a(inlier_cell_px), cells_b(inlier_cell_px);
  for (const Alike& m : w.matches) {
    if (!fits(best, m, params.inlier_radius_px)) continue;
    cells_a.put(m.xa, m.ya);
    cells_b.put(m.xb, m.yb);
  }
  match.cells = std::min(cells_a.count(), cells_b.count());
  if (match.cells < params.min_cells) return {};

  Similar fitted;
  if (!fit_similarity(
          w, [&](const Alike& m) { return fits(best, m, params.inlier_radius_px); }, fitted, match.residual_px))
    return {};
  for (int pass = 0; pass < 2; ++pass) {
    match_guided(older, newer, fitted, params, w);
    if (!fit_similarity(
            w, [](const Alike&) { return true; }, fitted, match.residual_px))
      return {};
  }
  Cells guided_a(guided_cell_px), guided_b(guided_cell_px);
  for (const Alike& m : w.matches) {
    guided_a.put(m.xa, m.ya);
    guided_b.put(m.xb, m.yb);
  }
  match.cells = std::min(guided_a.count(), guided_b.count());
  for (const Alike& m : w.matches) (void)match.pairs.push_back({m.a, m.b});
  const double re = fitted.m_re, im = fitted.m_im, x = fitted.t_x, y = fitted.t_y;
  match.newer_from_older = {std::sqrt(re * re + im * im), det_atan2(im, re), x, y};
  const double plane[9] = {re, -im, x, im, re, y, 0, 0, 1};
  std::copy_n(plane, 9, match.plane_newer_from_older);
  if (match.cells < params.min_guided_cells) return {};
  match.verdict = PlaceVerdict::verified;
  return {};
}

}  // namespace ilp
