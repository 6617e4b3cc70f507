#include "fsw/vision/overlap/overlap.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "fsw/vision/overlap/wide_search.hpp"

namespace ilp {
namespace {

// Hypotheses that continue from the first level of registration, from the next one, and from all others.
constexpr std::size_t survivors[] = {6, 3, 2};
// Few, because most hypotheses are wrong.
constexpr int first_iterations = 3;
constexpr double strong_ncc = 0.7;
constexpr double hopeless_share = 0.4;
// Of these the NCC of the second best peak is the highest.
constexpr std::size_t rivals = 6;
// In sides of the image: from nearer a hypothesis may still come to the same peak.
constexpr double same_peak_reach = 0.06, far_from_peak = 0.2;
constexpr int max_iterations = 8;
// Quarter resolution: noise no longer counts, and a blur that affects only corner detection is accepted.
constexpr int quality_level = 2;
constexpr double min_registered = 0.05;  // share of a's blocks; fewer prove nothing
constexpr std::size_t min_regions = 4;
constexpr double perfect_region_ncc = 0.85;
constexpr double large_part = 1.2;        // of the smallest overlap asked for
constexpr double max_repetition = 0.75;   // of OverlapResult::repetition
constexpr double imperfect_share = 0.75;  // of it, unless the match is nearly perfect
constexpr double min_peak_margin = 0.1;   // best minus second best peak
constexpr double max_second_share = 0.6;  // second best peak / best
// Below these an image is too dark, poor in texture, or blurred (ImageQuality).
constexpr double min_mean_grey = 8, min_stddev_grey = 4, min_sharpness = 0.06;
constexpr double repetition_slack = 1.06;
// Below this share of the smallest requested overlap, a match may be due to chance.
constexpr double outside_search = 0.7;

// Of the two best peaks of an exhaustive search, and the least NCC of the parts then. Chosen on 190 pairs
// (docs/compute.md).
constexpr double distinct_score_ratio = 1.3;
constexpr double distinct_region_ncc = 0.15;

static_assert((limits::max_image_side >> (limits::max_pyramid_levels - 1)) <= coarse_max_side);

using Hypothesis = OverlapHypothesis;
using Hypotheses = decltype(OverlapWorkspace::hypotheses);

Status check_size(GrayView image) {
  if (std::min(image.width, image.height) < limits::min_image_side) {
    return out_of_range(Argument::image_size, image.width);
  }
  if (image.area() > limits::max_image_pixels || std::max(image.width, image.height) > limits::max_image_side) {
    return {StatusCode::image_too_large, image.width, image.height};
  }
  return {};
}

Status check_params(const OverlapParams& p) {
  if (!(p.min_overlap >= 0.1 && p.min_overlap <= 1)) return out_of_range(Argument::min_overlap, p.min_overlap);
  if (!(p.max_rotation_rad >= 0 && p.max_rotation_rad <= pi))
    return out_of_range(Argument::rotation, p.max_rotation_rad);
  if (!(p.max_scale >= 1 && p.predicted_scale > 0)) return out_of_range(Argument::scale, p.predicted_scale);
  const double extreme = std::max(p.predicted_scale, 1 / p.predicted_scale) * p.max_scale;
  if (!(extreme <= coarse_max_scale)) return out_of_range(Argument::scale, p.max_scale);
  if (!(std::fabs(p.predicted_rotation_rad) <= 2 * pi))
    return out_of_range(Argument::rotation, p.predicted_rotation_rad);
  return {};
}

OverlapVerdict judge_image(const ImageQuality& quality) {
  if (quality.mean < min_mean_grey) return OverlapVerdict::too_dark;
  if (quality.stddev < min_stddev_grey) return OverlapVerdict::texture_poor;
  if (quality.sharpness < min_sharpness) return OverlapVerdict::blurred;
  return OverlapVerdict::ok;
}

double apart_px(const CentredSimilarity& p, const CentredSimilarity& q, double side_px) {
  const double half = 0.5 * side_px;
  const double turn = half * std::sqrt((p.m_re - q.m_re) * (p.m_re - q.m_re) + (p.m_im - q.m_im) * (p.m_im - q.m_im));
  const double shift = std::sqrt((p.d_x - q.d_x) * (p.d_x - q.d_x) + (p.d_y - q.d_y) * (p.d_y - q.d_y));
  return turn + shift;
}

bool same_peak(const CentredSimilarity& p, const CentredSimilarity& q, double side_px) {
  return apart_px(p, q, side_px) < same_peak_reach * side_px;
}

// A step of the refinement may leave the searched range a little, but a result far outside of it is not valid.
bool inside_search(const CentredSimilarity& m, const OverlapParams& params) {
  constexpr double slack = 0.1;
  const double scale = m.scale() / params.predicted_scale;
  const double bound = params.max_scale * (1 + slack);
  if (scale > bound || scale < 1 / bound) return false;
  double turn = std::fabs(m.rotation_rad() - params.predicted_rotation_rad);
  turn -= 2 * pi * std::floor(turn / (2 * pi));
  return std::min(turn, 2 * pi - turn) <= params.max_rotation_rad + slack;
}

// Into the first `count` of the list, which has room for one more.
void insert_sorted(const Hypothesis& r, double side_px, Hypotheses& list, std::size_t& count) {
  const auto same = std::find_if(list.begin(), list.begin() + count, [&](const Hypothesis& other) {
    return same_peak(other.b_from_a, r.b_from_a, side_px);
  });
  if (same == list.begin() + count) {
    list[count++] = r;
  } else if (same->fit.detail_ncc < r.fit.detail_ncc) {
    *same = r;
  }
  for (std::size_t i = count - 1; i > 0 && list[i].fit.detail_ncc > list[i - 1].fit.detail_ncc; --i)
    std::swap(list[i], list[i - 1]);
}

// Up to `last_step` of at most `iterations` steps.
Status advance(const RegistrationTemplate& a, const RegistrationImage& b, int last_step, int iterations,
               Hypothesis& r) {
  for (; r.goes_on && r.steps <= last_step; ++r.steps) {
    ILP_TAKE(r.goes_on, step_similarity(a, b, r.steps < iterations, r.b_from_a, r.fit));
  }
  return {};
}

// Rivals far below a strong best match need no exact registration. `dropped` is the highest of their correlations.
bool is_hopeless(const Hypothesis& r, const Hypothesis& best) {
  return best.fit.detail_ncc >= strong_ncc && r.fit.detail_ncc < hopeless_share * best.fit.detail_ncc;
}

void drop_hopeless(Hypotheses& hypotheses, double& dropped) {
  while (hypotheses.size() > 1 && is_hopeless(hypotheses.back(), hypotheses[0])) {
    dropped = std::max(dropped, hypotheses.back().fit.detail_ncc);
    hypotheses.pop_back();
  }
}

// One step of each tells which ones are hopeless. Those that lie near the best one go on all the same, because they may
// come to its peak, and so do the best rivals, because one of them is the second best peak.
Status drop_after_one_step(const RegistrationTemplate& a, const RegistrationImage& b, int iterations,
                           Hypotheses& hypotheses) {
  FixedVector<double, coarse_max_candidates> agreement;
  const Hypothesis* best = hypotheses.begin();
  for (Hypothesis& r : hypotheses) {
    ILP_TRY(advance(a, b, 1, iterations, r));
    if (r.fit.detail_ncc > best->fit.detail_ncc) best = &r;
    static_cast<void>(agreement.push_back(r.fit.detail_ncc));
  }
  std::sort(agreement.begin(), agreement.end(), [](double p, double q) { return p > q; });
  const double rival = agreement[std::min(rivals, agreement.size()) - 1];
  const Hypothesis leader = *best;
  const double side_px = std::max(a.width, a.height);
  const auto goes_on = [&](const Hypothesis& r) {
    return r.fit.detail_ncc >= rival || !is_hopeless(r, leader) ||
           apart_px(r.b_from_a, leader.b_from_a, side_px) <= far_from_peak * side_px;
  };
  std::size_t left = 0;
  for (const Hypothesis& r : hypotheses) {
    if (goes_on(r)) hypotheses[left++] = r;
  }
  while (hypotheses.size() > left) hypotheses.pop_back();
  return {};
}

// Registers hypotheses at one level. Those that end at the same peak become one. Best first.
Status refine(const RegistrationTemplate& a, const RegistrationImage& b, double to_level, int iterations,
              const OverlapParams& params, Hypotheses& hypotheses) {
  for (Hypothesis& r : hypotheses) {
    r.b_from_a.d_x *= to_level;
    r.b_from_a.d_y *= to_level;
    r.fit = {};
    r.steps = 0;
    r.goes_on = true;
  }
  if (hypotheses.size() > rivals) ILP_TRY(drop_after_one_step(a, b, iterations, hypotheses));
  // Those that are registered take the places of those that have been.
  std::size_t refined = 0;
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    Hypothesis r = hypotheses[i];
    ILP_TRY(advance(a, b, iterations, iterations, r));
    if (r.fit.ncc > 0 && r.fit.covered >= min_registered && inside_search(r.b_from_a, params)) {
      insert_sorted(r, std::max(a.width, a.height), hypotheses, refined);
    }
  }
  while (hypotheses.size() > refined) hypotheses.pop_back();
  return {};
}

// A tenth of a pixel there is far below what the overlap or the prediction of corners needs.
int finest_level(const Pyramid& pyramid) {
  int k = 0;
  while (k + 1 < pyramid.levels() && std::max(pyramid.level(k).width, pyramid.level(k).height) > registration_max_side)
    ++k;
  return k;
}

ImageQuality assess(const Pyramid& pyramid) {
  return assess_image(pyramid.level(std::min(quality_level, pyramid.levels() - 1)));
}

// The coarsest level with fractional bits, from a finer one: rounding in between would lose the remaining contrast.
CoarseView shrink_to_coarse(const Pyramid& pyramid, CoarseImage& out) {
  const int coarsest = pyramid.levels() - 1;
  const int halvings = std::min(coarsest, 2);
  const GrayView fine = pyramid.level(coarsest - halvings);
  const ImageView<std::int16_t> coarse(out.data(), pyramid.level(coarsest).width, pyramid.level(coarsest).height);
  const std::int32_t side = 1 << halvings;
  for (std::int32_t y = 0; y < coarse.height; ++y) {
    for (std::int32_t x = 0; x < coarse.width; ++x) {
      std::int32_t sum = 0;
      for (std::int32_t v = 0; v < side; ++v) {
        const std::uint8_t* const row = fine.row(y * side + v) + std::ptrdiff_t{x} * side;
        for (std::int32_t u = 0; u < side; ++u) sum += row[u];
      }
      coarse.at(x, y) = static_cast<std::int16_t>(((sum << coarse_value_bits) + side * side / 2) >> (2 * halvings));
    }
  }
  return coarse;
}

// The mapping between the centres of two images of level `k`, about the pixel origin of the full images.
void to_full_resolution(const CentredProjectivity& centred, GrayView level, int k, double (&h)[9]) {
  const double unit = 1 << k;
  const double cx = 0.5 * ((level.width << k) - 1), cy = 0.5 * ((level.height << k) - 1);
  double m[9];
  for (int i = 0; i < 9; ++i) m[i] = centred.h[i];
  m[2] *= unit;
  m[5] *= unit;
  m[6] /= unit;
  m[7] /= unit;
  for (std::size_t r = 0; r < 3; ++r) m[3 * r + 2] -= m[3 * r] * cx + m[3 * r + 1] * cy;
  for (int c = 0; c < 3; ++c) {
    m[c] += cx * m[6 + c];
    m[3 + c] += cy * m[6 + c];
  }
  for (int i = 0; i < 9; ++i) h[i] = m[i] / m[8];
}

}  // namespace

ImageQuality assess_image(GrayView image) {
  ImageQuality quality;
  if (image.width < 5 || image.height < 5) return quality;
  std::int64_t sum = 0, squares = 0;
  // Directions 0, 45, 90 and 135 degrees; differences to the first and the second pixel that way.
  std::array<std::int64_t, 4> near{}, far{};
  const std::ptrdiff_t s = image.stride;
  const std::array<std::ptrdiff_t, 4> way{1, s + 1, s, s - 1};
  with_widest_vectors([&] {
    for (std::int32_t y = 0; y + 2 < image.height; ++y) {
      const std::uint8_t* const p = image.row(y);
      std::int32_t row_sum = 0, row_squares = 0;
      for (std::int32_t x = 0; x < image.width; ++x) {
        row_sum += p[x];
        row_squares += p[x] * p[x];
      }
      sum += row_sum;
      squares += row_squares;
      for (std::size_t d = 0; d < way.size(); ++d) {
        const std::uint8_t* const one = p + way[d];
        const std::uint8_t* const two = p + 2 * way[d];
        std::int32_t row_near = 0, row_far = 0;
        for (std::int32_t x = 2; x < image.width - 2; ++x) {
          row_near += (one[x] - p[x]) * (one[x] - p[x]);
          row_far += (two[x] - p[x]) * (two[x] - p[x]);
        }
        near[d] += row_near;
        far[d] += row_far;
      }
    }
  });
  const double rows = image.height - 2;
  const double n = rows * image.width;
  quality.mean = static_cast<double>(sum) / n;
  quality.stddev = std::sqrt(std::max(static_cast<double>(squares) / n - quality.mean * quality.mean, 0.0));
  quality.sharpness = 1;
  for (std::size_t d = 0; d < way.size(); ++d) {
    if (far[d] == 0) continue;
    const double ratio = static_cast<double>(near[d]) / static_cast<double>(far[d]);
    quality.sharpness = std::min(quality.sharpness, (4 * ratio - 1) / 3);
  }
  return quality;
}

namespace {

// Registers the hypotheses of `w` level by level, from `from` on; they are in px of a level `to_level` times as coarse.
// The finest level remains in `w.registered`.
Status refine_levels(const OverlapTemplate& a, int from, double to_level, int iterations, const OverlapParams& params,
                     OverlapWorkspace& w, double& dropped) {
  Hypotheses& hypotheses = w.hypotheses;
  std::size_t step = 0;
  for (int k = from; k >= a.finest; --k) {
    const RegistrationTemplate& level = a.levels[static_cast<std::size_t>(k - a.finest)];
    ILP_TRY(w.registered.build(w.b.level(k)));
    ILP_TRY(refine(level, w.registered, k == from ? to_level : 2, k == from ? iterations : max_iterations, params,
                   hypotheses));
    while (hypotheses.size() > survivors[step]) hypotheses.pop_back();
    drop_hopeless(hypotheses, dropped);
    step = std::min(step + 1, std::size(survivors) - 1);
  }
  return {};
}

void take(const CoarseCandidates& candidates, Hypotheses& hypotheses) {
  hypotheses.clear();
  for (const CoarseCandidate& candidate : candidates) {
    if (!hypotheses.push_back({.b_from_a = candidate.b_from_a, .fit = {}})) break;
  }
}

Status find_hypotheses(const OverlapTemplate& a, const OverlapParams& params, OverlapWorkspace& w, double& dropped) {
  const int coarsest = w.b.levels() - 1;
  const GrayView size = w.b.level(coarsest);
  (void)shrink_to_coarse(w.b, w.coarse_b);
  ILP_TRY(search_coarse({a.coarse.data(), size.width, size.height}, {w.coarse_b.data(), size.width, size.height},
                        params, w.coarse, w.candidates));
  take(w.candidates, w.hypotheses);
  return refine_levels(a, a.first, coarsest == a.first ? 1 : 2, first_iterations, params, w, dropped);
}

// The NCC that three quarters of the regions reach, and all of those with more than the median of contrast: noise may
// spoil a flat region, but every distinct feature must be in the other image.
double weakest_region(RegistrationFit fit) {
  const std::size_t count = fit.region_count;
  if (count < min_regions) return 0;
  using Region = RegistrationFit::Region;
  std::sort(fit.regions, fit.regions + count, [](const Region& p, const Region& q) { return p.contrast > q.contrast; });
  double weakest = 1;
  for (std::size_t i = 0; i < count / 2; ++i) weakest = std::min(weakest, fit.regions[i].ncc);
  std::sort(fit.regions, fit.regions + count, [](const Region& p, const Region& q) { return p.ncc < q.ncc; });
  return std::min(weakest, fit.regions[count / 4].ncc);
}

// Ground that resembles itself is accepted only if a large part of it matches almost perfectly.
double repetition_bound(const OverlapResult& r, const RegistrationFit& fit, const OverlapParams& params) {
  const bool perfect = r.region_ncc >= perfect_region_ncc && r.overlap >= large_part * params.min_overlap;
  const double bound = perfect ? max_repetition : max_repetition * imperfect_share;
  // Noise lowers the correlation of a pattern with itself as much as that of the images.
  return bound * std::min(1.0, fit.detail_ncc * repetition_slack);
}

OverlapVerdict judge_peak(const OverlapResult& r, const RegistrationFit& fit, const OverlapParams& params) {
  const bool high = r.ncc >= params.min_ncc && r.region_ncc >= params.min_region_ncc;
  const bool single = r.ncc - r.ncc_second >= min_peak_margin && r.ncc_second <= max_second_share * r.ncc;
  const bool unique = r.repetition <= repetition_bound(r, fit, params);
  const bool searched = r.overlap >= outside_search * params.min_overlap;
  return high && single && unique && searched ? OverlapVerdict::ok : OverlapVerdict::overlap_unknown;
}

}  // namespace

Status prepare_overlap(GrayView image, OverlapTemplate& keyframe, OverlapWorkspace& w) {
  ILP_TRY(check_size(image));
  ILP_TRY(keyframe.pyramid.build(image, coarse_max_side));
  const Pyramid& pyramid = keyframe.pyramid;
  keyframe.quality = assess(pyramid);
  keyframe.finest = finest_level(pyramid);
  keyframe.first = std::max(pyramid.levels() - 2, keyframe.finest);
  (void)shrink_to_coarse(pyramid, keyframe.coarse);
  keyframe.repetition = 0;
  for (int k = keyframe.finest; k <= keyframe.first; ++k) {
    ILP_TRY(prepare_registration(pyramid.level(k), keyframe.levels[static_cast<std::size_t>(k - keyframe.finest)]));
    double peak = 0;
    ILP_TRY(measure_repetition(pyramid.level(k), w.repetition, peak));
    keyframe.repetition = std::max(keyframe.repetition, peak);
  }
  return {};
}

namespace {

// Whether both images can be compared: the verdict of `result` is `ok` then.
Status begin(const OverlapTemplate& a, GrayView image_b, const OverlapParams& params, OverlapWorkspace& w,
             OverlapResult& result) {
  result = {};
  if (a.pyramid.levels() == 0) return StatusCode::not_ready;
  const GrayView image_a = a.pyramid.level(0);
  if (image_a.width != image_b.width || image_a.height != image_b.height) {
    return {StatusCode::image_size_changed, image_b.width, image_b.height};
  }
  ILP_TRY(check_params(params));
  ILP_TRY(w.b.build(image_b, coarse_max_side));
  result.verdict = judge_image(a.quality);
  if (result.verdict == OverlapVerdict::ok) result.verdict = judge_image(assess(w.b));
  return {};
}

// The answer of the registered hypotheses, best first.
Status conclude(const OverlapTemplate& a, const Hypotheses& hypotheses, double dropped, const OverlapParams& params,
                OverlapWorkspace& w, OverlapResult& result) {
  result.verdict = OverlapVerdict::overlap_unknown;
  if (hypotheses.empty()) return {};
  const Hypothesis& best = hypotheses[0];
  CentredSimilarity full = best.b_from_a;
  full.d_x *= 1 << a.finest;
  full.d_y *= 1 << a.finest;
  // Halving drops odd rows and columns, so the centres of coarse images lie a little off the image's.
  const GrayView image_a = a.pyramid.level(0);
  const GrayView level = a.pyramid.level(a.finest);
  result.b_from_a = about_origin(full, level.width << a.finest, level.height << a.finest);
  result.ncc = best.fit.detail_ncc;
  result.ncc_second = hypotheses.size() > 1 ? std::max(hypotheses[1].fit.detail_ncc, dropped) : dropped;
  result.sigma_px = best.fit.sigma_px * (1 << a.finest);
  result.repetition = a.repetition;

  // A tilt of the camera bends the footprint, so all eight parameters are used if they explain more than four do.
  CentredProjectivity plane(best.b_from_a);
  RegistrationFit fit;
  ILP_TRY(register_projectivity(a.levels[0], w.registered, max_iterations, plane, fit));
  if (!(fit.converged && fit.detail_ncc > best.fit.detail_ncc)) {
    plane = CentredProjectivity(best.b_from_a);
    fit = best.fit;
  }
  to_full_resolution(plane, level, a.finest, result.plane_b_from_a);
  result.overlap = footprint_overlap_of_plane(image_a.width, image_a.height, result.plane_b_from_a);
  result.region_ncc = weakest_region(fit);
  result.verdict = judge_peak(result, fit, params);
  return {};
}

}  // namespace

Status measure_overlap(const OverlapTemplate& a, GrayView image_b, const OverlapParams& params, OverlapWorkspace& w,
                       OverlapResult& result) {
  ILP_TRY(begin(a, image_b, params, w, result));
  if (result.verdict != OverlapVerdict::ok) return {};
  result.verdict = OverlapVerdict::overlap_unknown;
  double dropped = 0;
  ILP_TRY(find_hypotheses(a, params, w, dropped));
  return conclude(a, w.hypotheses, dropped, params, w, result);
}

namespace {

// A peak that no other of all rotations, scales and shifts comes near to needs less agreement of every part.
bool stands_out(const CoarseCandidates& candidates) {
  return candidates.size() > 1 && candidates[0].score >= distinct_score_ratio * candidates[1].score;
}

// Whether the best hypothesis has come from the best candidate, whose pixels are `coarser` levels larger.
bool is_first(const CoarseCandidates& candidates, const Hypothesis& best, int coarser, const OverlapTemplate& a) {
  CentredSimilarity first = candidates[0].b_from_a;
  first.d_x *= 1 << coarser;
  first.d_y *= 1 << coarser;
  const GrayView level = a.pyramid.level(a.finest);
  return same_peak(first, best.b_from_a, std::max(level.width, level.height));
}

}  // namespace

int wide_search_level(const Pyramid& pyramid) {
  int k = 0;
  while (std::max(pyramid.level(k).width, pyramid.level(k).height) > wide_max_side) ++k;
  return k;
}

Status measure_overlap_of(const OverlapTemplate& a, GrayView image_b, const CoarseCandidates& candidates,
                          const OverlapParams& params, OverlapWorkspace& w, OverlapResult& result) {
  ILP_TRY(begin(a, image_b, params, w, result));
  if (result.verdict != OverlapVerdict::ok) return {};
  result.verdict = OverlapVerdict::overlap_unknown;
  Hypotheses& hypotheses = w.hypotheses;
  take(candidates, hypotheses);
  // A level coarser than that of the search, where the steps of its grid lie within the reach of the registration.
  const int searched = wide_search_level(a.pyramid), from = std::min(searched + 1, a.first);
  double dropped = 0;
  ILP_TRY(refine_levels(a, from, from > searched ? 0.5 : 1 << (searched - from), max_iterations, params, w, dropped));
  OverlapParams judged = params;
  if (stands_out(candidates) && !hypotheses.empty() && is_first(candidates, hypotheses[0], searched - a.finest, a)) {
    judged.min_region_ncc = std::min(judged.min_region_ncc, distinct_region_ncc);
  }
  return conclude(a, hypotheses, dropped, judged, w, result);
}

Status measure_overlap(GrayView image_a, GrayView image_b, const OverlapParams& params, OverlapWorkspace& w,
                       OverlapResult& result) {
  result = {};
  ILP_TRY(prepare_overlap(image_a, w.a, w));
  return measure_overlap(w.a, image_b, params, w, result);
}

}  // namespace ilp
