#include "fsw/vision/place/place_verification.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "fsw/base/argument.hpp"
#include "fsw/base/math.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/place/descriptor_distance.hpp"
#include "fsw/vision/place/place_match_workspace.hpp"
#include "fsw/vision/place/plane_map.hpp"

namespace ilp {
namespace {

using Features = std::span<const PlaceFeature>;
using Alike = PlaceMatchWorkspace::Alike;

constexpr std::size_t tried_matches = 40;
constexpr std::size_t followed = 4;  // similarities that guide a second search
constexpr int rotation_bins = 32;
constexpr int angle_tolerance = 14;      // 20 degrees
constexpr int max_distance_bits = 72;    // of mutual nearest features
constexpr int max_guided_bits = 85;      // where the place and the angle are predicted
constexpr double inlier_radius_px = 10;  // of the first similarity: relief and tilt
constexpr double guided_radius_px = 14;  // of the matches that it guides to
constexpr std::int32_t min_inliers = 5;  // of the first similarity
constexpr std::int32_t min_cells = 6;    // squares with a guided match, in both images
constexpr double min_spread_px = 15;     // of the guided matches across the line along which they spread most
constexpr double max_rival_share = 0.4F, max_rival_rate = 0.7F;  // of PlaceMatch
constexpr double min_base_px = 20;                               // between the two matches that give a similarity
constexpr double max_scale = 3;
constexpr double same_place_px = 40;
constexpr double fit_unit_px = 300;
constexpr float cell_px = 40;
constexpr double beside_px[] = {40, 60, 80, 100};  // from a map to those that tell what chance finds
constexpr double repeat_cell_px = 24;              // in which shifts of a repeated pattern are counted
constexpr int repeats_followed = 3;
constexpr double least_shared = 0.25;  // of the corners that another place must show to be compared
constexpr std::uint16_t none = limits::max_place_features;

// Counts the squares of an image in which something was put.
class Cells {
 public:
  void put(const PlaceFeature& feature) {
    const auto column = static_cast<std::size_t>(std::max(feature.x, 0.0F) / cell_px);
    const auto row = static_cast<std::size_t>(std::max(feature.y, 0.0F) / cell_px);
    bool& cell = used_[std::min(row, side - 1) * side + std::min(column, side - 1)];
    count_ += cell ? 0 : 1;
    cell = true;
  }
  [[nodiscard]] int count() const { return count_; }

 private:
  static constexpr std::size_t side = limits::max_image_side / 40 + 1;
  int count_ = 0;
  bool used_[side * side] = {};
};

std::uint8_t angle_of(double x, double y) {
  const double turns = det_atan2(y, x) * (128 / pi);
  return static_cast<std::uint8_t>(static_cast<std::int32_t>(std::floor(turns + 0.5)) & 255);
}

// How far the angle of b is from that of a, turned, at most 128.
int angle_error(const Alike& pair, std::uint8_t rotation) {
  return std::abs(static_cast<int>(static_cast<std::int8_t>(static_cast<std::uint8_t>(pair.turn - rotation))));
}

/// What a map does to angles and levels.
struct Guide {
  std::uint8_t rotation = 0;
  int level_step = 0;  ///< of image b, in halves of a level

  explicit Guide(const PlaneMap& map) {
    rotation = angle_of(map.h[0] + map.h[4], map.h[3] - map.h[1]);
    const double scale = std::sqrt(std::fabs(map.h[0] * map.h[4] - map.h[1] * map.h[3]));
    const double levels = det_log(std::max(scale, 1e-3)) / det_log(place_level_ratio);
    level_step = static_cast<int>(std::floor(2 * levels + 0.5));
  }
  [[nodiscard]] bool admits_level(const PlaceFeature& a, const PlaceFeature& b) const {
    return std::abs(2 * (b.level - a.level) - level_step) <= 3;
  }
};

class Verification {
 public:
  Verification(Features older, Features newer, float min_evidence, PlaceMatchWorkspace& w)
      : a_(older), b_(newer), min_evidence_(min_evidence), w_(w) {
    for (const PlaceFeature& a : a_) {
      middle_x_ += static_cast<double>(a.x) / static_cast<double>(a_.size());
      middle_y_ += static_cast<double>(a.y) / static_cast<double>(a_.size());
    }
  }

  void run(PlaceMatch& match) {
    match.verdict = PlaceVerdict::too_few_matches;
    compare_all();
    match_mutually(w_.alike, [&](const Alike& p) { return p.distance <= max_distance_bits; });
    if (w_.matches.size() < static_cast<std::size_t>(min_inliers)) return;
    std::uint8_t rotations[3];
    dominant_rotations(rotations);
    match.verdict = PlaceVerdict::no_similarity;
    for (const std::uint8_t rotation : rotations) {
      match_mutually(w_.alike, [&](const Alike& p) {
        return p.distance <= max_distance_bits && angle_error(p, rotation) <= angle_tolerance;
      });
      try_similarities(match);
    }
    if (match.inliers < min_inliers) return;
    follow_best(match);
  }

 private:
  struct Hypothesis {
    PlaneMap map;
    int inliers = 0;
    std::size_t matches = 0;  ///< guided
  };

  void set_words_of_b() {
    for (std::size_t b = 0; b < b_.size(); ++b) {
      for (std::size_t word = 0; word < descriptor_words; ++word) {
        w_.words_of_b[b / 8 * descriptor_words + word][b % 8] = b_[b].descriptor[word];
      }
    }
  }

  // Where more pairs look alike than there is room for, those that look least alike are left out.
  void compare_all() {
    const std::size_t capacity =
        std::min(std::max(PlaceMatchWorkspace::alike_of_few, a_.size() * b_.size() / 16), w_.alike.capacity());
    w_.alike.clear();
    set_words_of_b();
    int bits = max_guided_bits;
    std::array<std::size_t, 256> count{};
    std::size_t pairs = 0;
    const auto consider = [&](std::size_t a, std::size_t b, int distance) {
      if (distance > bits) return;
      ++count[static_cast<std::size_t>(distance)];
      if (++pairs > capacity) {
        for (; pairs > capacity; --bits) pairs -= count[static_cast<std::size_t>(bits)];
        keep_alike(bits);
        if (distance > bits) return;
      }
      (void)w_.alike.push_back({static_cast<std::uint16_t>(a), static_cast<std::uint16_t>(b),
                                static_cast<std::uint8_t>(distance), turn_of(a, b)});
    };
    with_widest_vectors([&] {
      for (std::size_t a = 0; a < a_.size(); ++a) {
        EightWords one[descriptor_words];
        for (std::size_t word = 0; word < descriptor_words; ++word) one[word] = EightWords{} + a_[a].descriptor[word];
        for (std::size_t b = 0; b < b_.size(); b += 8) {
          EightWords distances;
          hamming_256_of_eight(one, &w_.words_of_b[b / 8 * descriptor_words], distances);
          if (!any(distances <= static_cast<std::uint32_t>(bits))) continue;
          for (std::size_t k = 0; k < std::min<std::size_t>(8, b_.size() - b); ++k) {
            consider(a, b + k, static_cast<int>(distances[k]));
          }
        }
      }
    });
  }

  void keep_alike(int bits) {
    const auto less_alike = [bits](const Alike& pair) { return pair.distance > bits; };
    const auto end = std::remove_if(w_.alike.begin(), w_.alike.end(), less_alike);
    (void)w_.alike.resize(static_cast<std::size_t>(end - w_.alike.begin()));
  }

  [[nodiscard]] std::uint8_t turn_of(std::size_t a, std::size_t b) const {
    return static_cast<std::uint8_t>(b_[b].angle - a_[a].angle);
  }

  // Of the admitted pairs, those that are the nearest of both features; of equal distances the first counts.
  template <typename Pairs, typename Admits>
  void match_mutually(const Pairs& pairs, Admits&& admits) {
    std::uint8_t nearest_a[limits::max_place_features], nearest_b[limits::max_place_features];
    std::fill_n(nearest_a, a_.size(), std::uint8_t{255});
    std::fill_n(nearest_b, b_.size(), std::uint8_t{255});
    std::fill_n(w_.best_a.begin(), a_.size(), none);
    std::fill_n(w_.best_b.begin(), b_.size(), none);
    for (const Alike& p : pairs) {
      if (!admits(p)) continue;
      if (p.distance < nearest_a[p.a]) {
        nearest_a[p.a] = p.distance;
        w_.best_a[p.a] = p.b;
      }
      if (p.distance < nearest_b[p.b]) {
        nearest_b[p.b] = p.distance;
        w_.best_b[p.b] = p.a;
      }
    }
    w_.matches.clear();
    for (std::size_t a = 0; a < a_.size(); ++a) {
      const std::uint16_t b = w_.best_a[a];
      if (b == none || w_.best_b[b] != a) continue;
      (void)w_.matches.push_back({static_cast<std::uint16_t>(a), b, nearest_a[a], turn_of(a, b)});
    }
  }

  void dominant_rotations(std::uint8_t (&rotations)[3]) const {
    constexpr int width = 256 / rotation_bins;
    int votes[rotation_bins] = {}, sums[rotation_bins];
    for (const Alike& m : w_.matches) ++votes[m.turn / width];
    for (int k = 0; k < rotation_bins; ++k) {
      sums[k] = votes[(k + rotation_bins - 1) % rotation_bins] + 2 * votes[k] + votes[(k + 1) % rotation_bins];
    }
    for (std::uint8_t& rotation : rotations) {
      const auto best = static_cast<int>(std::max_element(sums, sums + rotation_bins) - sums);
      rotation = static_cast<std::uint8_t>(best * width + width / 2);
      for (int k = -2; k <= 2; ++k) sums[(best + k + rotation_bins) % rotation_bins] = -1;
    }
  }

  bool similarity_of(const Alike& p, const Alike& q, PlaneMap& map) const {
    const double xa = a_[p.a].x, ya = a_[p.a].y, xb = b_[p.b].x, yb = b_[p.b].y;
    const double ax = a_[q.a].x - xa, ay = a_[q.a].y - ya, bx = b_[q.b].x - xb, by = b_[q.b].y - yb;
    const double aa = ax * ax + ay * ay, bb = bx * bx + by * by;
    if (std::min(aa, bb) < min_base_px * min_base_px) return false;
    if (bb > max_scale * max_scale * aa || aa > max_scale * max_scale * bb) return false;
    const double re = (ax * bx + ay * by) / aa, im = (ax * by - ay * bx) / aa;
    map = {{re, -im, xb - re * xa + im * ya, im, re, yb - im * xa - re * ya, 0, 0, 1}};
    return true;
  }

  // Of a similarity, whose third row is (0, 0, 1).
  int count_inliers(const PlaneMap& map, double radius2) const {
    int inliers = 0;
    for (std::size_t i = 0; i < w_.matches.size(); ++i) {
      const double x = w_.matched_a[i].x, y = w_.matched_a[i].y;
      const double du = map.h[0] * x + map.h[1] * y + map.h[2] - w_.matched_b[i].x;
      const double dv = map.h[3] * x + map.h[4] * y + map.h[5] - w_.matched_b[i].y;
      inliers += du * du + dv * dv <= radius2 ? 1 : 0;
    }
    return inliers;
  }

  // Every pair of the best matches, as far as it agrees with itself in angle.
  void try_similarities(PlaceMatch& match) {
    const auto better = [](const Alike& p, const Alike& q) {
      return p.distance != q.distance ? p.distance < q.distance : p.a < q.a;
    };
    std::make_heap(w_.matches.begin(), w_.matches.end(), better);
    std::sort_heap(w_.matches.begin(), w_.matches.end(), better);
    for (std::size_t i = 0; i < w_.matches.size(); ++i) {
      const PlaceFeature &a = a_[w_.matches[i].a], &b = b_[w_.matches[i].b];
      w_.matched_a[i] = {a.x, a.y};
      w_.matched_b[i] = {b.x, b.y};
    }
    const std::size_t tried = std::min(tried_matches, w_.matches.size());
    const double radius2 = inlier_radius_px * inlier_radius_px;
    for (std::size_t i = 0; i < tried; ++i) {
      for (std::size_t k = i + 1; k < tried; ++k) {
        Hypothesis h;
        if (!similarity_of(w_.matches[i], w_.matches[k], h.map)) continue;
        const std::uint8_t rotation = angle_of(h.map.h[0], h.map.h[3]);
        if (angle_error(w_.matches[i], rotation) > angle_tolerance) continue;
        h.inliers = count_inliers(h.map, radius2);
        keep(h);
      }
    }
    for (const Hypothesis& h : hypotheses_) match.inliers = std::max(match.inliers, h.inliers);
  }

  // The best ones that differ: those that send the middle of the image to about the same place count as one.
  void keep(const Hypothesis& h) {
    std::size_t same = hypotheses_.size();
    for (std::size_t i = 0; i < hypotheses_.size() && same == hypotheses_.size(); ++i) {
      if (same_place(hypotheses_[i].map, h.map)) same = i;
    }
    if (same < hypotheses_.size()) {
      if (h.inliers > hypotheses_[same].inliers) hypotheses_[same] = h;
    } else if (!hypotheses_.push_back(h)) {
      std::size_t worst = 0;
      for (std::size_t i = 1; i < hypotheses_.size(); ++i) {
        if (hypotheses_[i].inliers <= hypotheses_[worst].inliers) worst = i;
      }
      if (h.inliers > hypotheses_[worst].inliers) hypotheses_[worst] = h;
    }
  }

  [[nodiscard]] bool same_place(const PlaneMap& p, const PlaneMap& q) const {
    double u, v;
    p.apply(middle_x_, middle_y_, u, v);
    return q.squared_distance(middle_x_, middle_y_, u, v) < same_place_px * same_place_px;
  }

  void send(const PlaneMap& map) {
    for (std::size_t i = 0; i < a_.size(); ++i) map.apply(a_[i].x, a_[i].y, w_.sent[i].x, w_.sent[i].y);
  }

  // Between where the map of the last send() leads and where the other feature is.
  [[nodiscard]] double squared_distance(const Alike& p) const {
    const double du = w_.sent[p.a].x - static_cast<double>(b_[p.b].x);
    const double dv = w_.sent[p.a].y - static_cast<double>(b_[p.b].y);
    return du * du + dv * dv;
  }

  [[nodiscard]] bool admits(const Guide& guide, const Alike& p) const {
    return angle_error(p, guide.rotation) <= angle_tolerance && p.distance <= max_guided_bits &&
           guide.admits_level(a_[p.a], b_[p.b]);
  }

  // Matches that the map brings together within a radius. Returns how many.
  std::size_t match_along(const PlaneMap& map, double radius_px) {
    const Guide guide(map);
    send(map);
    match_mutually(w_.alike,
                   [&](const Alike& p) { return admits(guide, p) && squared_distance(p) <= radius_px * radius_px; });
    return w_.matches.size();
  }

  [[nodiscard]] PlaneFit fit() const {
    PlaneFit fit(middle_x_, middle_y_, fit_unit_px);
    for (const Alike& m : w_.matches) fit.add(a_[m.a].x, a_[m.a].y, b_[m.b].x, b_[m.b].y);
    return fit;
  }

  // Leads a map to the one that fits most of the matches that it brings together.
  template <typename Match>
  void follow(PlaneMap& map, Match&& match) const {
    for (int pass = 0; pass < 5; ++pass) {
      const std::size_t count = match(map, pass < 3 ? guided_radius_px : inlier_radius_px);
      const PlaneFit points = fit();
      const bool fitted = pass > 1 && count >= 14  ? points.homography(map)
                          : pass > 0 && count >= 8 ? points.affine(map)
                                                   : points.similarity(map);
      if (!fitted) return;
    }
  }

  // Features of image a that lie together, as those of several levels do, tell the same: they are one corner.
  void find_corners() {
    std::uint16_t first[limits::max_place_features];
    const double radius2 = inlier_radius_px * inlier_radius_px;
    corners_ = 0;
    for (std::size_t i = 0; i < a_.size(); ++i) {
      std::size_t c = 0;
      for (; c < corners_; ++c) {
        const double dx = a_[i].x - a_[first[c]].x, dy = a_[i].y - a_[first[c]].y;
        if (dx * dx + dy * dy <= radius2) break;
      }
      corner_of_[i] = static_cast<std::uint16_t>(c);
      if (c < corners_) continue;
      first[c] = static_cast<std::uint16_t>(i);
      ++corners_;
    }
  }

  // Corners that the map sends to where image b has features.
  [[nodiscard]] double corners_inside(const PlaneMap& map) {
    constexpr double near_px = 60;
    float low_x = b_[0].x, high_x = low_x, low_y = b_[0].y, high_y = low_y;
    for (const PlaceFeature& b : b_) {
      low_x = std::min(low_x, b.x);
      high_x = std::max(high_x, b.x);
      low_y = std::min(low_y, b.y);
      high_y = std::max(high_y, b.y);
    }
    bool inside[limits::max_place_features] = {};
    send(map);
    for (std::size_t i = 0; i < a_.size(); ++i) {
      const double u = w_.sent[i].x, v = w_.sent[i].y;
      if (u < low_x - near_px || u > high_x + near_px || v < low_y - near_px || v > high_y + near_px) continue;
      bool& found = inside[corner_of_[i]];
      for (std::size_t k = 0; k < b_.size() && !found; ++k) {
        const double du = u - static_cast<double>(b_[k].x), dv = v - static_cast<double>(b_[k].y);
        found = du * du + dv * dv <= near_px * near_px;
      }
    }
    return static_cast<double>(std::count(inside, inside + corners_, true));
  }

  // Pairs that look alike, and that the map or one beside it may bring together.
  void find_near(const PlaneMap& map) {
    constexpr double reach = beside_px[std::size(beside_px) - 1] + same_place_px;
    const Guide guide(map);
    send(map);
    w_.near.clear();
    for (const Alike& p : w_.alike) {
      if (admits(guide, p) && squared_distance(p) <= reach * reach) (void)w_.near.push_back(p);
    }
  }

  std::size_t match_near(const PlaneMap& map, double radius_px) {
    send(map);
    match_mutually(w_.near, [&](const Alike& p) { return squared_distance(p) <= radius_px * radius_px; });
    return w_.matches.size();
  }

  // How many corners have a match that keeps to tighter bounds on place and likeness, and on which `other` disagrees.
  static constexpr int radii = 3, likenesses = 5;
  using Counts = std::array<double, static_cast<std::size_t>(radii) * likenesses>;
  [[nodiscard]] Counts count(const PlaneMap& map, const PlaneMap* other) const {
    bool met[limits::max_place_features][radii * likenesses] = {};
    const double widest = inlier_radius_px;
    for (const Alike& m : w_.matches) {
      const PlaceFeature &a = a_[m.a], &b = b_[m.b];
      if (other != nullptr && other->squared_distance(a.x, a.y, b.x, b.y) <= 4 * widest * widest) continue;
      const double squared = map.squared_distance(a.x, a.y, b.x, b.y);
      for (int r = 0; r < radii; ++r) {
        const double radius = (r + 1) * widest / radii;
        for (int k = 0; k < likenesses; ++k) {
          if (squared <= radius * radius && m.distance <= max_guided_bits - 10 * k) {
            met[corner_of_[m.a]][k * radii + r] = true;
          }
        }
      }
    }
    Counts counts{};
    for (std::size_t c = 0; c < corners_; ++c) {
      for (std::size_t i = 0; i < counts.size(); ++i) counts[i] += met[c][i] ? 1 : 0;
    }
    return counts;
  }

  struct Evidence {
    double value = 0;
    std::size_t bounds = 0;  ///< index of those that tell most
    double found = 0;        ///< corners with a match that keeps to them
    double possible = 0;     ///< corners
  };

  // Under chance, a map that starts beside this one and is followed in the same way brings as many corners together.
  // Dunes and layers make chance large: along their crests the ground looks alike, and a map that can be bent finds it,
  // so that those beside it that find most are what counts. Tried for several bounds: on ground with little texture of
  // its own only the nearest and most alike tell.
  Evidence evidence(const PlaneMap& map) {
    const double possible = corners_inside(map);
    if (possible < 1) return {};
    find_near(map);
    match_near(map, inlier_radius_px);
    const Counts found = count(map, nullptr);
    std::array<Counts, 6> beside{};  // largest first
    constexpr int directions = 16;
    for (int k = 0; k < directions; ++k) {
      const double angle = 2 * pi * k / directions;
      for (const double length : beside_px) {
        PlaneMap other = shifted(map, length * det_cos(angle), length * det_sin(angle));
        follow(other, [&](const PlaneMap& m, double radius_px) { return match_near(m, radius_px); });
        match_near(other, inlier_radius_px);
        Counts met = count(other, &map);
        for (Counts& larger : beside) {
          for (std::size_t i = 0; i < met.size(); ++i) {
            if (met[i] > larger[i]) std::swap(met[i], larger[i]);
          }
        }
      }
    }
    Evidence best;
    for (std::size_t i = 0; i < found.size(); ++i) {
      double expected = 0.5;
      for (const Counts& met : beside) expected += met[i] / static_cast<double>(beside.size());
      const double value = surprise(found[i], expected, possible);
      if (value > best.value) best = {value, i, found[i], possible};
    }
    return best;
  }

  // -ln of Hoeffding's bound on the probability of so many successes of so many trials.
  static double surprise(double found, double expected, double trials) {
    if (found <= expected || expected >= trials) return 0;
    const double p = expected / trials, k = std::min(found / trials, 1 - 1e-9);
    return trials * (k * det_log(k / p) + (1 - k) * det_log((1 - k) / (1 - p)));
  }

  // Follows each similarity to the map that most features agree with.
  void follow_best(PlaceMatch& match) {
    std::size_t best = 0;
    PlaneMap best_map;
    for (Hypothesis& h : hypotheses_) {
      h.matches = 0;
      if (h.inliers < min_inliers) continue;
      follow(h.map, [&](const PlaneMap& m, double radius_px) { return match_along(m, radius_px); });
      h.matches = match_along(h.map, inlier_radius_px);
      if (h.matches <= best) continue;
      best = h.matches;
      best_map = h.map;
    }
    if (best == 0) return;
    match_along(best_map, inlier_radius_px);
    if (!describe(best_map, match)) return;
    if (match.cells < min_cells || match.spread_px < min_spread_px) {
      match.verdict = PlaceVerdict::too_few_cells;
      return;
    }
    rival_matches_ = 0;
    for (const Hypothesis& h : hypotheses_) {
      if (!same_place(h.map, best_map)) consider_rival(h.map, h.matches);
    }
    find_repeats(best_map);
    conclude(best_map, match);
  }

  // A map that leads (dx, dy) beside the other one, in image b.
  static PlaneMap shifted(const PlaneMap& map, double dx, double dy) {
    PlaneMap result = map;
    for (int c = 0; c < 3; ++c) {
      result.h[c] += dx * map.h[6 + c];
      result.h[3 + c] += dy * map.h[6 + c];
    }
    return result;
  }

  void consider_rival(const PlaneMap& map, std::size_t matches) {
    (void)rivals_.push_back(map);
    if (matches <= rival_matches_) return;
    rival_matches_ = matches;
    rival_ = map;
  }

  // How often corners have a match at the best other place, as a share of how often they have one at this one. Repeats
  // that lie close together are chance to each other, so that they have no evidence; this tells of them.
  double rival_rate(const Evidence& best) {
    double rate = 0;
    for (const PlaneMap& rival : rivals_) {
      const double possible = corners_inside(rival);
      if (possible < least_shared * best.possible) continue;
      match_along(rival, inlier_radius_px);
      rate = std::max(rate, count(rival, nullptr)[best.bounds] / possible);
    }
    return best.found > 0 ? rate * best.possible / best.found : 0;
  }

  // Considers the maps that lead to another place by a shift: a pattern that repeats itself has
  // look-alikes at one distance from many of its features.
  void find_repeats(const PlaneMap& map) {
    constexpr int side = PlaceMatchWorkspace::shift_cells;
    const Guide guide(map);
    send(map);
    w_.shifts.fill(0);
    const auto cell_of = [](double d) { return static_cast<int>(std::floor(d / repeat_cell_px)) + side / 2; };
    for (const Alike& p : w_.alike) {
      if (!admits(guide, p)) continue;
      const double dx = b_[p.b].x - w_.sent[p.a].x, dy = b_[p.b].y - w_.sent[p.a].y;
      if (dx * dx + dy * dy < same_place_px * same_place_px) continue;
      const int column = cell_of(dx), row = cell_of(dy);
      // Each shift counts in the four cells nearest to it, so that no border divides a peak.
      const int left = cell_of(dx - repeat_cell_px / 2), top = cell_of(dy - repeat_cell_px / 2);
      for (const int r : {top, top + 1}) {
        for (const int c : {left, left + 1}) {
          if (r < 0 || c < 0 || r >= side || c >= side) continue;
          std::uint16_t& votes = w_.shifts[static_cast<std::size_t>(r) * side + static_cast<std::size_t>(c)];
          votes = static_cast<std::uint16_t>(votes + (r == row && c == column ? 2 : 1));
        }
      }
    }
    for (int k = 0; k < repeats_followed; ++k) {
      const auto peak = std::max_element(w_.shifts.begin(), w_.shifts.end());
      if (*peak == 0) break;
      const auto index = static_cast<int>(peak - w_.shifts.begin());
      const int column = index % side - side / 2, row = index / side - side / 2;
      PlaneMap rival = shifted(map, (column + 0.5) * repeat_cell_px, (row + 0.5) * repeat_cell_px);
      for (int pass = 0; pass < 2; ++pass) {
        match_along(rival, pass == 0 ? repeat_cell_px : guided_radius_px);
        if (!fit().similarity(rival)) break;
      }
      if (!same_place(rival, map)) consider_rival(rival, match_along(rival, inlier_radius_px));
      *peak = 0;
    }
  }

  // Of the guided matches. False if they determine no similarity.
  bool describe(const PlaneMap& map, PlaceMatch& match) const {
    Cells cells_a, cells_b;
    double squares = 0;
    for (const Alike& m : w_.matches) {
      cells_a.put(a_[m.a]);
      cells_b.put(b_[m.b]);
      squares += map.squared_distance(a_[m.a].x, a_[m.a].y, b_[m.b].x, b_[m.b].y);
      (void)match.pairs.push_back({m.a, m.b});
    }
    match.cells = std::min(cells_a.count(), cells_b.count());
    match.residual_px = std::sqrt(squares / (2 * static_cast<double>(w_.matches.size())));
    const PlaneFit points = fit();
    match.spread_px = points.least_spread_px();
    PlaneMap similar;
    if (!points.similarity(similar)) return false;
    const double re = similar.h[0], im = similar.h[3];
    match.newer_from_older = {std::sqrt(re * re + im * im), det_atan2(im, re), similar.h[2], similar.h[5]};
    std::copy_n(map.h, 9, match.plane_newer_from_older);
    return true;
  }

  void conclude(const PlaneMap& map, PlaceMatch& match) {
    find_corners();
    const Evidence best = evidence(map);
    match.evidence = best.value;
    match.rival_rate = rival_rate(best);
    if (best.value > 0 && 2 * rival_matches_ > match.pairs.size()) {
      match.rival_share = evidence(rival_).value / best.value;
    }
    if (match.rival_share > max_rival_share || match.rival_rate > max_rival_rate) {
      match.verdict = PlaceVerdict::ambiguous;
    } else if (match.evidence < static_cast<double>(min_evidence_)) {
      match.verdict = PlaceVerdict::by_chance;
    } else {
      match.verdict = PlaceVerdict::verified;
    }
  }

  Features a_, b_;
  float min_evidence_;
  PlaceMatchWorkspace& w_;
  double middle_x_ = 0, middle_y_ = 0;  ///< of the older features
  std::array<std::uint16_t, limits::max_place_features> corner_of_{};
  std::size_t corners_ = 0;
  FixedVector<Hypothesis, followed> hypotheses_;
  FixedVector<PlaneMap, followed + repeats_followed> rivals_;
  PlaneMap rival_;  ///< the one with most matches
  std::size_t rival_matches_ = 0;
};

}  // namespace

Status verify_place(Features older, Features newer, float min_evidence, PlaceMatchWorkspace& workspace,
                    PlaceMatch& match) {
  match = {};
  if (std::max(older.size(), newer.size()) > limits::max_place_features)
    return out_of_range(Argument::features, std::max(older.size(), newer.size()));
  if (std::min(older.size(), newer.size()) < static_cast<std::size_t>(min_inliers)) return {};
  Verification(older, newer, min_evidence, workspace).run(match);
  return {};
}

}  // namespace ilp
