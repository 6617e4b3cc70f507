#include "fsw/vision/overlap/registration.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/image/sampling.hpp"
#include "fsw/vision/image/small_solver.hpp"

namespace ilp {
namespace {

// Grey values of b carry three fractional bits: products with gradients summed over a block then fit 32 bits.
constexpr int value_bits = 3;
constexpr double value_unit = 1 << value_bits;
constexpr std::int32_t small_image_px = registration_max_side / 2;
constexpr double step_done_px = 0.05;
// Residuals of neighbouring pixels are alike (interpolation, relief): this many pixels count as one.
constexpr double correlated_px = 9;
constexpr double min_blocks = 6;  // fewer do not fix the unknowns

// The mapping near one block: value and derivatives at its centre.
struct LocalWarp {
  double x, y;            ///< in b, centred
  double xx, xy, yx, yy;  ///< d(x, y) of b by d(x, y) of a
};

/// The effect of a step of the mapping on a point of a at (x, y): d(x, y) = (along_x, along_y) * step.
template <int N>
struct Motion {
  double along_x[N], along_y[N];
};

struct SimilarityModel {
  static constexpr int freedom = 4;
  static constexpr bool same_everywhere = true;  ///< the derivatives
  using Warp = CentredSimilarity;

  static LocalWarp local(const Warp& w, double x, double y) {
    LocalWarp l{0, 0, w.m_re, -w.m_im, w.m_im, w.m_re};
    w.apply(x, y, l.x, l.y);
    return l;
  }
  static Motion<freedom> motion(double x, double y) { return {{x, -y, 1, 0}, {y, x, 0, 1}}; }
  static constexpr int shift_x = 2, shift_y = 3;

  // warp := warp o step^-1
  static bool compose_inverse(const double (&step)[freedom], Warp& warp) {
    const double re = 1 + step[0], im = step[1];
    const double norm = re * re + im * im;
    const Warp old = warp;
    warp.m_re = (old.m_re * re + old.m_im * im) / norm;
    warp.m_im = (old.m_im * re - old.m_re * im) / norm;
    warp.d_x = old.d_x - (warp.m_re * step[2] - warp.m_im * step[3]);
    warp.d_y = old.d_y - (warp.m_im * step[2] + warp.m_re * step[3]);
    return true;
  }
};

// Coordinates in the step are divided by this, so that all unknowns of the normal equations are of one order.
constexpr double projective_unit = 128;

struct ProjectiveModel {
  static constexpr int freedom = 8;
  static constexpr bool same_everywhere = false;
  using Warp = CentredProjectivity;

  static LocalWarp local(const Warp& w, double x, double y) {
    LocalWarp l{};
    const double z = w.h[6] * x + w.h[7] * y + w.h[8];
    l.x = (w.h[0] * x + w.h[1] * y + w.h[2]) / z;
    l.y = (w.h[3] * x + w.h[4] * y + w.h[5]) / z;
    l.xx = (w.h[0] - w.h[6] * l.x) / z;
    l.xy = (w.h[1] - w.h[7] * l.x) / z;
    l.yx = (w.h[3] - w.h[6] * l.y) / z;
    l.yy = (w.h[4] - w.h[7] * l.y) / z;
    return l;
  }
  static Motion<freedom> motion(double x, double y) {
    const double u = x / projective_unit, v = y / projective_unit;
    return {{u, v, 0, 0, 1, 0, -u * x, -v * x}, {0, 0, u, v, 0, 1, -u * y, -v * y}};
  }
  static constexpr int shift_x = 4, shift_y = 5;

  static bool compose_inverse(const double (&step)[freedom], Warp& warp) {
    const double k = 1 / projective_unit;
    const double s[9] = {1 + k * step[0], k * step[1], step[4], k * step[2], 1 + k * step[3], step[5],
                         k * step[6],     k * step[7], 1};
    const double inv[9] = {s[4] - s[5] * s[7],        s[2] * s[7] - s[1],        s[1] * s[5] - s[2] * s[4],
                           s[5] * s[6] - s[3],        s[0] - s[2] * s[6],        s[2] * s[3] - s[0] * s[5],
                           s[3] * s[7] - s[4] * s[6], s[1] * s[6] - s[0] * s[7], s[0] * s[4] - s[1] * s[3]};
    double product[9];
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) {
        product[3 * r + c] = warp.h[3 * r] * inv[c] + warp.h[3 * r + 1] * inv[3 + c] + warp.h[3 * r + 2] * inv[6 + c];
      }
    }
    if (!(std::fabs(product[8]) > 1e-6)) return false;
    for (int i = 0; i < 9; ++i) warp.h[i] = product[i] / product[8];
    return true;
  }
};

/// Sums over the covered blocks. Unknowns: the step times the gain, then gain and offset.
template <int N>
struct NormalEquations {
  double a[N + 2][N + 2];
  double rhs[N + 2];
  double count, blocks;
  double sum_a, sum_aa, sum_b, sum_bb, sum_ab;
  double detail_aa, detail_bb, detail_ab;  ///< with the block's mean removed
  struct Region {
    double blocks, aa, bb, ab;  ///< as detail
  } regions[RegistrationFit::max_regions];
};

using I16 [[gnu::vector_size(16)]] = std::int16_t;
using I32 [[gnu::vector_size(16)]] = std::int32_t;

/// Sums of a block: b, and b^2, a b and the gradients times b.
struct BlockProducts {
  std::int32_t b;
  I32 with_b;
};

/// From the first pixel of a block to the others, in b.
template <std::int32_t Side>
struct BlockSteps {
  FixedCoordinate x[Side * Side], y[Side * Side];

  explicit BlockSteps(const LocalWarp& warp) {
    const FixedCoordinate xx = to_fixed(warp.xx), xy = to_fixed(warp.xy);
    const FixedCoordinate yx = to_fixed(warp.yx), yy = to_fixed(warp.yy);
    for (std::int32_t r = 0; r < Side; ++r) {
      for (std::int32_t c = 0; c < Side; ++c) {
        x[r * Side + c] = r * xy + c * xx;
        y[r * Side + c] = r * yy + c * yx;
      }
    }
  }
};

/// As sample_bilinear() at every pixel of a block. Only the loads go pixel by pixel.
template <std::int32_t Side>
void sample_block(const RegistrationImage& b, const LocalWarp& warp, const BlockSteps<Side>& steps,
                  std::int16_t* __restrict out) {
  constexpr std::int32_t count = Side * Side;
  constexpr double half = 0.5 * (Side - 1);
  const FixedCoordinate left = to_fixed(warp.x - half * (warp.xx + warp.xy) + 0.5 * (b.width() - 1));
  const FixedCoordinate top = to_fixed(warp.y - half * (warp.yx + warp.yy) + 0.5 * (b.height() - 1));
  std::uint16_t share_x[count], share_y[count];
  std::uint32_t offset[count];
  std::uint32_t quads[count];
  const std::int32_t stride = b.width();
#pragma GCC unroll 1
  for (std::int32_t i = 0; i < count; ++i) {
    const FixedCoordinate x = left + steps.x[i], y = top + steps.y[i];
    share_x[i] = static_cast<std::uint16_t>((x >> 8) & 255);
    share_y[i] = static_cast<std::uint16_t>((y >> 8) & 255);
    offset[i] = static_cast<std::uint32_t>((y >> 16) * stride + (x >> 16));
  }
  const std::uint32_t* const from = b.quads();
#pragma GCC unroll 4
  for (std::int32_t i = 0; i < count; ++i) quads[i] = from[offset[i]];
#pragma GCC unroll 1
  for (std::int32_t i = 0; i < count; ++i) {
    // 256 times a grey value, which fits 16 bits.
    const auto rest = static_cast<std::uint16_t>(256 - share_x[i]);
    const auto upper = static_cast<std::uint16_t>(quads[i]), lower = static_cast<std::uint16_t>(quads[i] >> 16U);
    const auto above = static_cast<std::uint16_t>((upper & 255U) * rest + (upper >> 8U) * share_x[i]);
    const auto below = static_cast<std::uint16_t>((lower & 255U) * rest + (lower >> 8U) * share_x[i]);
    const std::int32_t value = (above << 8) + share_y[i] * (below - above);
    out[i] = static_cast<std::int16_t>((value + (1 << (15 - value_bits))) >> (16 - value_bits));
  }
}

/// Products of eight words, added in pairs; which ones make a pair does not matter to their sum.
[[gnu::always_inline]] inline I32 multiply_in_pairs(I16 p, I16 q) {
#if defined(__SSE2__)
  // GCC does not find this instruction by itself.
  using I16OfCompiler [[gnu::vector_size(16)]] = short;  // NOLINT(google-runtime-int)
  return reinterpret_cast<I32>(
      __builtin_ia32_pmaddwd128(reinterpret_cast<I16OfCompiler>(p), reinterpret_cast<I16OfCompiler>(q)));
#else
  using Half [[gnu::vector_size(8)]] = std::int16_t;
  const auto lower = [](I16 v) { return __builtin_convertvector(Half{v[0], v[1], v[2], v[3]}, I32); };
  const auto upper = [](I16 v) { return __builtin_convertvector(Half{v[4], v[5], v[6], v[7]}, I32); };
  return lower(p) * lower(q) + upper(p) * upper(q);
#endif
}

/// The sum of each of four vectors.
[[gnu::always_inline]] inline I32 sums_of_four(I32 p, I32 q, I32 r, I32 s) {
  const I32 pq = __builtin_shufflevector(p, q, 0, 4, 1, 5) + __builtin_shufflevector(p, q, 2, 6, 3, 7);
  const I32 rs = __builtin_shufflevector(r, s, 0, 4, 1, 5) + __builtin_shufflevector(r, s, 2, 6, 3, 7);
  return __builtin_shufflevector(pq, rs, 0, 1, 4, 5) + __builtin_shufflevector(pq, rs, 2, 3, 6, 7);
}

template <std::int32_t Count>
BlockProducts products(const std::int16_t* a, const std::int16_t* gx, const std::int16_t* gy, const std::int16_t* b) {
  constexpr I16 ones{1, 1, 1, 1, 1, 1, 1, 1};
  const auto load = [](const std::int16_t* from) {
    I16 v;
    std::memcpy(&v, from, sizeof v);
    return v;
  };
  I32 sum{}, bb{}, ab{}, gxb{}, gyb{};
  for (std::int32_t i = 0; i < Count; i += 8) {
    const I16 v = load(b + i);
    sum += multiply_in_pairs(v, ones);
    bb += multiply_in_pairs(v, v);
    ab += multiply_in_pairs(v, load(a + i));
    gxb += multiply_in_pairs(v, load(gx + i));
    gyb += multiply_in_pairs(v, load(gy + i));
  }
  return {sum[0] + sum[1] + sum[2] + sum[3], sums_of_four(bb, ab, gxb, gyb)};
}

bool block_inside(const RegistrationImage& b, const LocalWarp& warp, double half) {
  const double cx = 0.5 * (b.width() - 1), cy = 0.5 * (b.height() - 1);
  // Half a pixel of margin also pays for the rounding of the fixed-point steps.
  const double reach_x = half * (std::fabs(warp.xx) + std::fabs(warp.xy)) + 0.5;
  const double reach_y = half * (std::fabs(warp.yx) + std::fabs(warp.yy)) + 0.5;
  return warp.x - reach_x >= -cx && warp.x + reach_x <= cx && warp.y - reach_y >= -cy && warp.y + reach_y <= cy;
}

/// What a block of a adds to the normal equations for itself.
template <int N>
void add_own(const RegistrationTemplate::Block& t, double count, const Motion<N>& m, NormalEquations<N>& n) {
  const double gxx = 0.25 * t.gxx, gxy = 0.25 * t.gxy, gyy = 0.25 * t.gyy;
  const double gx = 0.5 * t.gx, gy = 0.5 * t.gy, gxa = 0.5 * t.gxa, gya = 0.5 * t.gya;
  // Whole rows, because a vector unit adds them at once; the upper triangle is not used.
  for (int i = 0; i < N; ++i) {
    const double row_x = gxx * m.along_x[i] + gxy * m.along_y[i];
    const double row_y = gxy * m.along_x[i] + gyy * m.along_y[i];
    for (int k = 0; k < N; ++k) n.a[i][k] += row_x * m.along_x[k] + row_y * m.along_y[k];
  }
  for (int i = 0; i < N; ++i) n.a[N][i] += gxa * m.along_x[i] + gya * m.along_y[i];
  for (int i = 0; i < N; ++i) n.a[N + 1][i] += gx * m.along_x[i] + gy * m.along_y[i];
  const double a = t.a, aa = t.aa;
  n.sum_a += a;
  n.sum_aa += aa;
  n.detail_aa += aa - a * a / count;
}

using Two [[gnu::vector_size(16)]] = double;
using Four [[gnu::vector_size(32)]] = double;

/// What the blocks add together with b; vectors, because they add several sums at once.
template <int N>
struct SumsWithB {
  double blocks = 0, b = 0;
  Two products{}, detail{};                         ///< bb, ab
  Four regions[RegistrationFit::max_regions] = {};  ///< blocks and details: aa, bb, ab

  void add(double a, double detail_aa, const BlockProducts& p, double count, const Motion<N>& m, std::size_t region,
           NormalEquations<N>& n) {
    const double gxb = 0.5 / value_unit * p.with_b[2], gyb = 0.5 / value_unit * p.with_b[3];
    for (int i = 0; i < N; ++i) n.rhs[i] += gxb * m.along_x[i] + gyb * m.along_y[i];
    const double block_b = p.b / value_unit;
    const Two with_b = Two{static_cast<double>(p.with_b[0]), static_cast<double>(p.with_b[1])} *
                       Two{1 / (value_unit * value_unit), 1 / value_unit};
    const Two details = with_b - Two{block_b, a} * block_b / count;
    blocks += 1;
    b += block_b;
    products += with_b;
    detail += details;
    regions[region] += Four{1, detail_aa, details[0], details[1]};
  }
  void put_into(double count, NormalEquations<N>& n) const {
    n.count = count * blocks;
    n.blocks = blocks;
    n.sum_b = b;
    n.sum_bb = products[0];
    n.sum_ab = products[1];
    n.detail_bb = detail[0];
    n.detail_ab = detail[1];
    for (std::size_t i = 0; i < RegistrationFit::max_regions; ++i) {
      n.regions[i] = {regions[i][0], regions[i][1], regions[i][2], regions[i][3]};
    }
  }
};

/// Sums of RegistrationTemplate::SimilarityTerms, which are added to those of other blocks in the same order as theirs
/// are in add_own().
struct SimilaritySums {
  RegistrationTemplate::SimilarityTerms terms{};

  void add(const RegistrationTemplate::SimilarityTerms& block) {
    for (int i = 0; i < 10; ++i) terms.step[i] += block.step[i];
    for (int i = 0; i < 4; ++i) terms.gain[i] += block.gain[i];
    for (int i = 0; i < 4; ++i) terms.offset[i] += block.offset[i];
    terms.a += block.a;
    terms.aa += block.aa;
    terms.detail_aa += block.detail_aa;
  }
  void put_into(NormalEquations<4>& n) const {
    for (int i = 0, at = 0; i < 4; ++i) {
      for (int k = 0; k <= i; ++k, ++at) n.a[i][k] = terms.step[at];
      n.a[4][i] = terms.gain[i];
      n.a[5][i] = terms.offset[i];
    }
    n.sum_a = terms.a;
    n.sum_aa = terms.aa;
    n.detail_aa = terms.detail_aa;
  }
};

RegistrationTemplate::SimilarityTerms similarity_terms(const RegistrationTemplate::Block& block, double count) {
  NormalEquations<4> n{};
  add_own<4>(block, count, SimilarityModel::motion(block.x, block.y), n);
  RegistrationTemplate::SimilarityTerms terms;
  for (int i = 0, at = 0; i < 4; ++i) {
    for (int k = 0; k <= i; ++k, ++at) terms.step[at] = n.a[i][k];
    terms.gain[i] = n.a[4][i];
    terms.offset[i] = n.a[5][i];
  }
  terms.a = n.sum_a;
  terms.aa = n.sum_aa;
  terms.detail_aa = n.detail_aa;
  return terms;
}

template <typename Model, std::int32_t Side>
void sum_blocks(const RegistrationTemplate& a, const RegistrationImage& b, const typename Model::Warp& warp,
                NormalEquations<Model::freedom>& n) {
  constexpr std::int32_t count = Side * Side;
  constexpr double half = 0.5 * (Side - 1);
  std::int16_t sampled[count];
  BlockSteps<Side> steps(Model::local(warp, 0, 0));
  SimilaritySums sums;
  SumsWithB<Model::freedom> with_b;
  constexpr std::int32_t regions = RegistrationFit::region_columns;
  for (std::int32_t row = 0, i = 0; row < a.block_rows; ++row) {
    const std::int32_t first_region = row * regions / a.block_rows * regions;
    for (std::int32_t column = 0, region = 0; column < a.block_columns; ++column, ++i) {
      if ((region + 1) * a.block_columns <= column * regions) ++region;
      const auto& block = a.blocks[static_cast<std::size_t>(i)];
      const LocalWarp local = Model::local(warp, block.x, block.y);
      if (!block_inside(b, local, half)) continue;
      if constexpr (!Model::same_everywhere) steps = BlockSteps<Side>(local);
      sample_block<Side>(b, local, steps, sampled);
      const std::size_t start = static_cast<std::size_t>(i) * static_cast<std::size_t>(count);
      const BlockProducts p = products<count>(&a.value[start], &a.gradient_x[start], &a.gradient_y[start], sampled);
      const auto motion = Model::motion(block.x, block.y);
      const auto& own = a.similarity_terms[static_cast<std::size_t>(i)];
      if constexpr (Model::same_everywhere) {
        sums.add(own);
      } else {
        add_own<Model::freedom>(block, count, motion, n);
      }
      with_b.add(own.a, own.detail_aa, p, count, motion, static_cast<std::size_t>(first_region + region), n);
    }
  }
  with_b.put_into(count, n);
  if constexpr (Model::same_everywhere) sums.put_into(n);
}

template <typename Model>
void build_equations(const RegistrationTemplate& a, const RegistrationImage& b, const typename Model::Warp& warp,
                     NormalEquations<Model::freedom>& n) {
  constexpr int N = Model::freedom;
  n = {};
  with_widest_vectors([&] {
    if (a.block_px == registration_block_px) {
      sum_blocks<Model, registration_block_px>(a, b, warp, n);
    } else {
      sum_blocks<Model, registration_block_px / 2>(a, b, warp, n);
    }
  });
  n.a[N][N] = n.sum_aa;
  n.a[N + 1][N] = n.sum_a;
  n.a[N + 1][N + 1] = n.count;
  n.rhs[N] = n.sum_ab;
  n.rhs[N + 1] = n.sum_b;
}

// Below a quantisation step of variance there is nothing to correlate.
double correlation(double count, double var_a, double var_b, double covariance) {
  const double floor = count / 12;
  return var_a > floor && var_b > floor ? covariance / std::sqrt(var_a * var_b) : 0;
}

// Regions of which b covers at least half.
template <int N>
void compare_regions(const NormalEquations<N>& n, double all_blocks, std::int32_t block_area, RegistrationFit& fit) {
  fit.region_count = 0;
  for (const auto& part : n.regions) {
    if (part.blocks < 0.5 * all_blocks / RegistrationFit::max_regions) continue;
    auto& region = fit.regions[fit.region_count++];
    region.ncc = correlation(part.blocks * block_area, part.aa, part.bb, part.ab);
    const double in_a = n.detail_aa > 0 ? part.aa / n.detail_aa : 0, in_b = n.detail_bb > 0 ? part.bb / n.detail_bb : 0;
    region.contrast = std::max(in_a, in_b) / part.blocks;
  }
}

template <int N>
double motion_length(const Motion<N>& m, const double (&step)[N]) {
  double x = 0, y = 0;
  for (int k = 0; k < N; ++k) {
    x += m.along_x[k] * step[k];
    y += m.along_y[k] * step[k];
  }
  return std::sqrt(x * x + y * y);
}

template <typename Model>
Status register_model(const RegistrationTemplate& a, const RegistrationImage& b, int max_iterations,
                      typename Model::Warp& warp, RegistrationFit& fit) {
  constexpr int N = Model::freedom;
  fit = {};
  if (b.width() != a.width || b.height() != a.height) return {StatusCode::image_size_changed, b.width(), b.height()};
  const double radius = 0.5 * std::max(a.width, a.height);
  const double all_blocks = std::max(a.block_columns * a.block_rows, 1);
  for (int iteration = 0; iteration <= max_iterations; ++iteration) {
    NormalEquations<N> n;
    build_equations<Model>(a, b, warp, n);
    fit.covered = n.blocks / all_blocks;
    fit.ncc = fit.detail_ncc = 0;
    if (n.blocks < min_blocks) return {};
    fit.ncc = correlation(n.count, n.sum_aa - n.sum_a * n.sum_a / n.count, n.sum_bb - n.sum_b * n.sum_b / n.count,
                          n.sum_ab - n.sum_a * n.sum_b / n.count);
    fit.detail_ncc = correlation(n.count, n.detail_aa, n.detail_bb, n.detail_ab);
    const auto finish = [&] { compare_regions(n, all_blocks, a.block_px * a.block_px, fit); };
    if (!(fit.ncc > 0)) {
      finish();
      return {};
    }

    double solution[N + 2];
    for (int k = 0; k < N + 2; ++k) solution[k] = n.rhs[k];
    const bool solvable = factor_positive_definite<N + 2>(n.a, 1e-10);
    if (solvable) solve_factored<N + 2>(n.a, solution);
    if (!solvable || !(solution[N] > 0)) {
      finish();
      return {};
    }
    const double gain = solution[N];
    double step[N];
    for (int k = 0; k < N; ++k) step[k] = solution[k] / gain;
    const double moved =
        motion_length<N>(Model::motion(radius, 0), step) + motion_length<N>(Model::motion(0, radius), step);
    // A step of more than that is far outside the range of the gradients.
    const bool goes_on = iteration < max_iterations && moved < 0.5 * radius && Model::compose_inverse(step, warp);
    fit.converged = goes_on && moved < step_done_px;
    if (goes_on && !fit.converged) continue;
    double explained = 0;
    for (int k = 0; k < N + 2; ++k) explained += n.rhs[k] * solution[k];
    const double variance = std::max(n.sum_bb - explained, 0.0) / n.count * correlated_px;
    fit.sigma_px =
        std::sqrt(0.5 * variance *
                  (inverse_diagonal<N + 2>(n.a, Model::shift_x) + inverse_diagonal<N + 2>(n.a, Model::shift_y))) /
        gain;
    finish();
    return {};
  }
  return {};
}

void join_rows(const std::uint8_t* upper, const std::uint8_t* lower, std::int32_t width,
               std::uint32_t* __restrict out) {
  for (std::ptrdiff_t x = 0; x < width; ++x) {
    const auto above = static_cast<std::uint16_t>(upper[x] | upper[x + 1] << 8U);
    const auto below = static_cast<std::uint16_t>(lower[x] | lower[x + 1] << 8U);
    out[x] = above | std::uint32_t{below} << 16U;
  }
}

}  // namespace

Status RegistrationImage::build(GrayView image) {
  if (std::max(image.width, image.height) > registration_max_side) {
    return {StatusCode::image_too_large, image.width, image.height};
  }
  const std::int32_t width = width_ = image.width, height = height_ = image.height;
  with_widest_vectors([&] {
    for (std::int32_t y = 0; y + 1 < height; ++y) {
      join_rows(image.row(y), image.row(y + 1), width - 1, quads_.data() + std::ptrdiff_t{y} * width);
    }
  });
  return {};
}

Status prepare_registration(GrayView a, RegistrationTemplate& out) {
  const std::int32_t side = std::max(a.width, a.height);
  if (side > registration_max_side) return {StatusCode::image_too_large, a.width, a.height};
  const std::int32_t bs = side <= small_image_px ? registration_block_px / 2 : registration_block_px;
  out.width = a.width;
  out.height = a.height;
  out.block_px = bs;
  // The outermost pixels have no central difference; both sides share the pixels that do not fill a block.
  out.block_columns = std::max((a.width - 2) / bs, 0);
  out.block_rows = std::max((a.height - 2) / bs, 0);
  const std::int32_t left = (a.width - out.block_columns * bs) / 2, top = (a.height - out.block_rows * bs) / 2;
  std::size_t pixel = 0;
  for (std::int32_t row = 0; row < out.block_rows; ++row) {
    for (std::int32_t column = 0; column < out.block_columns; ++column) {
      RegistrationTemplate::Block sums{};
      const std::int32_t x0 = left + column * bs, y0 = top + row * bs;
      sums.x = static_cast<float>(x0 + 0.5 * (bs - 1) - 0.5 * (a.width - 1));
      sums.y = static_cast<float>(y0 + 0.5 * (bs - 1) - 0.5 * (a.height - 1));
      for (std::int32_t y = y0; y < y0 + bs; ++y) {
        const std::uint8_t* const p = a.row(y);
        for (std::int32_t x = x0; x < x0 + bs; ++x, ++pixel) {
          const std::int32_t v = p[x], gx = p[x + 1] - p[x - 1], gy = p[x + a.stride] - p[x - a.stride];
          out.value[pixel] = static_cast<std::int16_t>(v);
          out.gradient_x[pixel] = static_cast<std::int16_t>(gx);
          out.gradient_y[pixel] = static_cast<std::int16_t>(gy);
          sums.gxx += gx * gx;
          sums.gxy += gx * gy;
          sums.gyy += gy * gy;
          sums.gx += gx;
          sums.gy += gy;
          sums.gxa += gx * v;
          sums.gya += gy * v;
          sums.a += v;
          sums.aa += v * v;
        }
      }
      const std::int32_t block = row * out.block_columns + column;
      out.blocks[static_cast<std::size_t>(block)] = sums;
      out.similarity_terms[static_cast<std::size_t>(block)] = similarity_terms(sums, bs * bs);
    }
  }
  return {};
}

Status register_similarity(const RegistrationTemplate& a, const RegistrationImage& b, int max_iterations,
                           CentredSimilarity& b_from_a, RegistrationFit& fit) {
  return register_model<SimilarityModel>(a, b, max_iterations, b_from_a, fit);
}

Status register_projectivity(const RegistrationTemplate& a, const RegistrationImage& b, int max_iterations,
                             CentredProjectivity& b_from_a, RegistrationFit& fit) {
  return register_model<ProjectiveModel>(a, b, max_iterations, b_from_a, fit);
}

}  // namespace ilp
