#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fsw/base/rng.hpp"

namespace ilp {
namespace {

bool is_finite(const PointPair& pair) {
  return std::isfinite(pair.xa) && std::isfinite(pair.ya) && std::isfinite(pair.xb) && std::isfinite(pair.yb);
}

/// The caller copies from a container of the same capacity.
void append_pair(const NormalisedPair& pair, std::uint16_t source, NormalisedPairs& out) {
  const std::size_t i = out.size();
  if (!out.exact.push_back(pair) || !out.source.push_back(source)) return;
  out.xa[i] = static_cast<float>(pair.xa);
  out.ya[i] = static_cast<float>(pair.ya);
  out.xb[i] = static_cast<float>(pair.xb);
  out.yb[i] = static_cast<float>(pair.yb);
}

/// NaN counts as the worst quality, so that the order is total.
float ordered_quality(float quality) {
  return quality == quality ? quality : -3.0e38F;
}

void sort_by_quality(const PointPairs& pairs, NormalisedPairs& out) {
  out.by_quality.clear();
  out.qualities_differ = false;
  const std::size_t n = out.size();
  static_cast<void>(out.by_quality.resize(n));
  for (std::size_t i = 0; i < n; ++i) {
    out.by_quality[i] = static_cast<std::uint16_t>(i);
    out.qualities_differ |=
        ordered_quality(pairs[out.source[i]].quality) != ordered_quality(pairs[out.source[0]].quality);
  }
  if (!out.qualities_differ) return;
  const auto better = [&](std::uint16_t i, std::uint16_t j) {
    const float qi = ordered_quality(pairs[out.source[i]].quality);
    const float qj = ordered_quality(pairs[out.source[j]].quality);
    return qi != qj ? qi > qj : i < j;
  };
  // A heap, because std::sort recurses.
  std::make_heap(out.by_quality.begin(), out.by_quality.end(), better);
  std::sort_heap(out.by_quality.begin(), out.by_quality.end(), better);
}

}  // namespace

Mat3 ImageNormalisation::pixel_from_normalised() const {
  Mat3 m;
  m << scale_x, 0, centre_x, 0, scale_y, centre_y, 0, 0, 1;
  return m;
}

Mat3 ImageNormalisation::normalised_from_pixel() const {
  Mat3 m;
  m << 1 / scale_x, 0, -centre_x / scale_x, 0, 1 / scale_y, -centre_y / scale_y, 0, 0, 1;
  return m;
}

ImageNormalisation intrinsics_of(const CameraModel& camera) {
  return {camera.fx, camera.fy, camera.cx, camera.cy};
}

void isotropic_normalisation(const PointPairs& pairs, ImageNormalisation& a, ImageNormalisation& b) {
  a = {};
  b = {};
  double count = 0;
  for (const PointPair& p : pairs) {
    if (!is_finite(p)) continue;
    count += 1;
    a.centre_x += p.xa;
    a.centre_y += p.ya;
    b.centre_x += p.xb;
    b.centre_y += p.yb;
  }
  if (count == 0) return;
  for (ImageNormalisation* image : {&a, &b}) {
    image->centre_x /= count;
    image->centre_y /= count;
  }
  double distance_a = 0;
  double distance_b = 0;
  for (const PointPair& p : pairs) {
    if (!is_finite(p)) continue;
    distance_a += Vec2(p.xa - a.centre_x, p.ya - a.centre_y).norm();
    distance_b += Vec2(p.xb - b.centre_x, p.yb - b.centre_y).norm();
  }
  const double unit = count * std::sqrt(2.0);
  if (distance_a > 0) a.scale_x = a.scale_y = distance_a / unit;
  if (distance_b > 0) b.scale_x = b.scale_y = distance_b / unit;
}

void normalise_pairs(const PointPairs& pairs, const ImageNormalisation& a, const ImageNormalisation& b,
                     std::uint64_t seed, NormalisedPairs& out) {
  out.exact.clear();
  out.source.clear();
  out.scale = {a.scale_x, a.scale_y, b.scale_x, b.scale_y};
  auto& shuffled = out.by_quality;
  shuffled.clear();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (is_finite(pairs[i])) static_cast<void>(shuffled.push_back(static_cast<std::uint16_t>(i)));
  }
  constexpr std::uint64_t shuffle_stream = 1;
  Rng rng(seed, shuffle_stream);
  for (std::size_t i = shuffled.size(); i > 1; --i) {
    std::swap(shuffled[i - 1], shuffled[rng.below(static_cast<std::uint32_t>(i))]);
  }
  for (const std::uint16_t source : shuffled) {
    const PointPair& p = pairs[source];
    append_pair({(p.xa - a.centre_x) / a.scale_x, (p.ya - a.centre_y) / a.scale_y, (p.xb - b.centre_x) / b.scale_x,
                 (p.yb - b.centre_y) / b.scale_y},
                source, out);
  }
  sort_by_quality(pairs, out);
}

void select_subset(const NormalisedPairs& pairs, const PairIndices& selected, NormalisedPairs& subset) {
  subset.exact.clear();
  subset.source.clear();
  subset.by_quality.clear();
  subset.scale = pairs.scale;
  subset.qualities_differ = false;
  for (std::size_t i = 0; i < selected.size(); ++i) {
    append_pair(pairs.exact[selected[i]], pairs.source[selected[i]], subset);
    static_cast<void>(subset.by_quality.push_back(static_cast<std::uint16_t>(i)));
  }
}

}  // namespace ilp
