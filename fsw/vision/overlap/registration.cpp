#include "fsw/vision/overlap/registration.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/vector_width.hpp"
#include "fsw/base/word_lanes.hpp"
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

/// Sums of a block: b, and b^2, a b and the gradients times b.
struct BlockProducts {
  using Products [[gnu::vector_size(16)]] = std::int32_t;
  std::int32_t b;
  Products with_b;
};

/// From the first pixel of a block to the others, in b. Of the pixels of a vector of words come first those with even
/// numbers, then the odd ones, so that two vectors of sums make one of words.
template <typename Width, std::int32_t Side>
struct BlockSteps {
  static constexpr std::int32_t lanes = WordLanes<Width>::sum_count, words = 2 * lanes;
  FixedCoordinate x[Side * Side], y[Side * Side];

  explicit BlockSteps(const LocalWarp& warp) {
    const FixedCoordinate xx = to_fixed(warp.xx), xy = to_fixed(warp.xy);
    const FixedCoordinate yx = to_fixed(warp.yx), yy = to_fixed(warp.yy);
    for (std::int32_t i = 0; i < Side * Side; ++i) {
      const std::int32_t pixel = i / words * words + 2 * (i % lanes) + i % words / lanes;
      const std::int32_t r = pixel / Side, c = pixel % Side;
      x[i] = r * xy + c * xx;
      y[i] = r * yy + c * yx;
    }
  }
};

/// From the centre of a block to its outermost pixels.
template <std::int32_t Side>
constexpr double half_side = 0.5 * (Side - 1);

/// Of the first pixel of a block, in b.
template <std::int32_t Side>
FixedCoordinate first_x(const RegistrationImage& b, double centre_x, const LocalWarp& warp) {
  return to_fixed(centre_x - half_side<Side> * (warp.xx + warp.xy) + 0.5 * (b.width() - 1));
}
template <std::int32_t Side>
FixedCoordinate first_y(const RegistrationImage& b, double centre_y, const LocalWarp& warp) {
  return to_fixed(centre_y - half_side<Side> * (warp.yx + warp.yy) + 0.5 * (b.height() - 1));
}

/// As sample_bilinear(), with value_bits fractional bits, at places of b. Only the loads go pixel by pixel.
template <typename Width>
void sample(const RegistrationImage& b, const typename WordLanes<Width>::Sums& x,
            const typename WordLanes<Width>::Sums& y, typename WordLanes<Width>::Sums& values) {
  using Lanes = WordLanes<Width>;
  using Sums = typename Lanes::Sums;
  using Words = typename Lanes::UnsignedWords;
  Sums quads;
  Lanes::gather(b.quads(), (y >> 16) * b.width() + (x >> 16), quads);
  // Each word is a pixel of the upper or of the lower row; along x their values are 256 times a grey value.
  const Sums share_x = (x >> 8) & 255, share_y = (y >> 8) & 255;
  const Words left = reinterpret_cast<Words>(quads) & 255, right = reinterpret_cast<Words>(quads) >> 8;
  const Words rows = (left << 8) + (right - left) * reinterpret_cast<Words>(share_x | share_x << 16);
  // As signed words they are 2^15 less.
  values = Sums{} + ((1 << 23) + (1 << (15 - value_bits)));
  Lanes::add_products(reinterpret_cast<typename Lanes::Words>(rows ^ 0x8000),
                      reinterpret_cast<typename Lanes::Words>((share_y << 16) + 256 - share_y), values);
  values >>= 16 - value_bits;
}

/// Of a block whose first pixel lies at (left, top) of b; `start` is its first pixel in the template.
template <typename Width, std::int32_t Side>
BlockProducts multiply_block(const RegistrationTemplate& a, std::size_t start, const RegistrationImage& b,
                             FixedCoordinate left, FixedCoordinate top, const BlockSteps<Width, Side>& steps) {
  using Lanes = WordLanes<Width>;
  using Sums = typename Lanes::Sums;
  using Words = typename Lanes::Words;
  const Words ones = Words{} + 1;
  Sums sum{}, bb{}, ab{}, gxb{}, gyb{};
  for (std::int32_t i = 0; i < Side * Side; i += Lanes::word_count) {
    Sums values[2];  // of the even and of the odd pixels
    for (std::int32_t k = 0; k < 2; ++k) {
      Sums x, y;
      load_lanes(steps.x + i + k * Lanes::sum_count, x);
      load_lanes(steps.y + i + k * Lanes::sum_count, y);
      sample<Width>(b, x + left, y + top, values[k]);
    }
    const Words v = reinterpret_cast<Words>(values[0] | values[1] << 16);
    const std::size_t at = start + static_cast<std::size_t>(i);
    Words grey, gx, gy;
    load_lanes(&a.value[at], grey);
    load_lanes(&a.gradient_x[at], gx);
    load_lanes(&a.gradient_y[at], gy);
    Lanes::add_products(v, ones, sum);
    Lanes::add_products(v, v, bb);
    Lanes::add_products(v, grey, ab);
    Lanes::add_products(v, gx, gxb);
    Lanes::add_products(v, gy, gyb);
  }
  return {Lanes::sum_of(sum), Lanes::sums_of_four(bb, ab, gxb, gyb)};
}

/// Where the centre of a block must lie in b.
struct Inside {
  double low_x, high_x, low_y, high_y;

  Inside(const RegistrationImage& b, const LocalWarp& warp, double half) {
    // Half a pixel of margin also pays for the rounding of the fixed-point steps.
    const double reach_x = half * (std::fabs(warp.xx) + std::fabs(warp.xy)) + 0.5;
    const double reach_y = half * (std::fabs(warp.yx) + std::fabs(warp.yy)) + 0.5;
    const double cx = 0.5 * (b.width() - 1), cy = 0.5 * (b.height() - 1);
    low_x = reach_x - cx;
    high_x = cx - reach_x;
    low_y = reach_y - cy;
    high_y = cy - reach_y;
  }
  [[nodiscard]] bool has(double x, double y) const {
    return (x >= low_x) & (x <= high_x) & (y >= low_y) & (y <= high_y);
  }
};

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

using SimilarityTerms = RegistrationTemplate::SimilarityTerms;

SimilarityTerms similarity_terms(const RegistrationTemplate::Block& block, double count) {
  NormalEquations<4> n{};
  add_own<4>(block, count, SimilarityModel::motion(block.x, block.y), n);
  SimilarityTerms terms;
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

/// sum += after - before
void add_difference(const SimilarityTerms& after, const SimilarityTerms& before, SimilarityTerms& sum) {
  for (int i = 0; i < 10; ++i) sum.step[i] += after.step[i] - before.step[i];
  for (int i = 0; i < 4; ++i) sum.gain[i] += after.gain[i] - before.gain[i];
  for (int i = 0; i < 4; ++i) sum.offset[i] += after.offset[i] - before.offset[i];
  sum.a += after.a - before.a;
  sum.aa += after.aa - before.aa;
  sum.detail_aa += after.detail_aa - before.detail_aa;
}

void put_into(const SimilarityTerms& terms, NormalEquations<4>& n) {
  for (int i = 0, at = 0; i < 4; ++i) {
    for (int k = 0; k <= i; ++k, ++at) n.a[i][k] = terms.step[at];
    n.a[4][i] = terms.gain[i];
    n.a[5][i] = terms.offset[i];
  }
  n.sum_a = terms.a;
  n.sum_aa = terms.aa;
  n.detail_aa = terms.detail_aa;
}

using Two [[gnu::vector_size(16)]] = double;
using Four [[gnu::vector_size(32)]] = double;

constexpr std::int32_t region_columns = RegistrationFit::region_columns;

/// The first column of blocks of each region, and the end of the last one.
struct RegionColumns {
  std::int32_t begin[region_columns + 1];

  explicit RegionColumns(std::int32_t block_columns) {
    for (std::int32_t i = 0; i <= region_columns; ++i)
      begin[i] = (i * block_columns + region_columns - 1) / region_columns;
  }
};

/// What the blocks add together with b, whose values are whole numbers of 1 / value_unit. All sums are exact, as those
/// of RegistrationTemplate::SimilarityTerms.
struct SumsWithB {
  double b = 0;
  Four products{};  ///< bb, ab, gxb, gyb, the gradients without the division by 2
  struct Region {
    double blocks = 0, detail_aa = 0;
    Two details{};  ///< bb, ab
  } regions[RegistrationFit::max_regions];

  template <int N>
  void put_into(double count, NormalEquations<N>& n) const {
    constexpr Two units{1 / (value_unit * value_unit), 1 / value_unit};
    double blocks = 0;
    Two all{};
    for (std::size_t i = 0; i < RegistrationFit::max_regions; ++i) {
      const Two details = regions[i].details * units;
      n.regions[i] = {regions[i].blocks, regions[i].detail_aa, details[0], details[1]};
      blocks += regions[i].blocks;
      all += details;
    }
    n.count = count * blocks;
    n.blocks = blocks;
    n.detail_bb = all[0];
    n.detail_ab = all[1];
    n.sum_b = b / value_unit;
    n.sum_bb = products[0] * units[0];
    n.sum_ab = products[1] * units[1];
  }
};

/// The details of b and of a and b in one block.
Two details_of(const BlockProducts& p, std::int32_t a, double count) {
  const double b = p.b;
  return Two{static_cast<double>(p.with_b[0]), static_cast<double>(p.with_b[1])} -
         Two{b, static_cast<double>(a)} * b / count;
}

constexpr std::int32_t max_columns = RegistrationTemplate::max_columns;

/// A row of blocks of a in b. Those that b covers stand side by side.
template <std::int32_t Side>
struct BlockRow {
  static constexpr std::int32_t at_once = 4;
  double x[max_columns];  ///< of the centres, in a
  FixedCoordinate left[max_columns], top[max_columns];
  std::int32_t begin = 0, end = 0;

  BlockRow(const RegistrationTemplate::Block& first, std::int32_t columns, const RegistrationImage& b,
           const CentredSimilarity& warp, const LocalWarp& local, const Inside& inside) {
    double in_b_x[max_columns], in_b_y[max_columns];
    std::int64_t is_inside[max_columns];
    const double first_column = first.x, y = first.y;
    // Whole vectors; what lies beyond the last column is not used.
    const std::int32_t whole = (columns + at_once - 1) / at_once * at_once;
    for (std::int32_t i = 0; i < whole; ++i) {
      x[i] = first_column + i * Side;
      warp.apply(x[i], y, in_b_x[i], in_b_y[i]);
      is_inside[i] = inside.has(in_b_x[i], in_b_y[i]) ? 1 : 0;
    }
    end = columns;
    while (begin < end && is_inside[begin] == 0) ++begin;
    while (end > begin && is_inside[end - 1] == 0) --end;
    const std::int32_t last = (end + at_once - 1) / at_once * at_once;
    for (std::int32_t i = begin / at_once * at_once; i < last; ++i) {
      left[i] = first_x<Side>(b, in_b_x[i], local);
      top[i] = first_y<Side>(b, in_b_y[i], local);
    }
  }
};
static_assert(max_columns % BlockRow<1>::at_once == 0);

template <typename Width, std::int32_t Side>
void sum_blocks(const RegistrationTemplate& a, const RegistrationImage& b, const CentredSimilarity& warp,
                NormalEquations<4>& n) {
  constexpr std::int32_t count = Side * Side;
  const LocalWarp local = SimilarityModel::local(warp, 0, 0);
  const BlockSteps<Width, Side> steps(local);
  const Inside inside(b, local, half_side<Side>);
  const RegionColumns columns(a.block_columns);
  SimilarityTerms own{};
  SumsWithB with_b;
  double rhs[4] = {};
  for (std::int32_t row = 0; row < a.block_rows; ++row) {
    const std::int32_t first = row * a.block_columns;
    const RegistrationTemplate::Block* const blocks = &a.blocks[static_cast<std::size_t>(first)];
    const SimilarityTerms* const own_sums = a.similarity_sums.data() + first + row;
    const BlockRow<Side> line(blocks[0], a.block_columns, b, warp, local, inside);
    if (line.begin == line.end) continue;
    add_difference(own_sums[line.end], own_sums[line.begin], own);
    Four products_of_row{}, along_x{};
    std::int32_t b_of_row = 0;
    SumsWithB::Region* region = with_b.regions + std::ptrdiff_t{row} * region_columns / a.block_rows * region_columns;
    for (std::int32_t k = 0; k < region_columns; ++k, ++region) {
      const std::int32_t begin = std::max(line.begin, columns.begin[k]), end = std::min(line.end, columns.begin[k + 1]);
      if (begin >= end) continue;
      Two details{};
      for (std::int32_t i = begin; i < end; ++i) {
        const std::size_t start = static_cast<std::size_t>(first + i) * static_cast<std::size_t>(count);
        const BlockProducts p = multiply_block<Width, Side>(a, start, b, line.left[i], line.top[i], steps);
        const Four with_block = __builtin_convertvector(p.with_b, Four);
        products_of_row += with_block;
        along_x += with_block * line.x[i];
        b_of_row += p.b;
        details += details_of(p, blocks[i].a, count);
      }
      region->blocks += end - begin;
      region->detail_aa += own_sums[end].detail_aa - own_sums[begin].detail_aa;
      region->details += details;
    }
    with_b.b += b_of_row;
    with_b.products += products_of_row;
    const double y = blocks[0].y, gxb = products_of_row[2], gyb = products_of_row[3];
    rhs[0] += along_x[2] + gyb * y;
    rhs[1] += along_x[3] - gxb * y;
    rhs[2] += gxb;
    rhs[3] += gyb;
  }
  for (int i = 0; i < 4; ++i) n.rhs[i] = rhs[i] * (0.5 / value_unit);
  with_b.put_into(count, n);
  put_into(own, n);
}

template <typename Width, std::int32_t Side>
void sum_blocks(const RegistrationTemplate& a, const RegistrationImage& b, const CentredProjectivity& warp,
                NormalEquations<8>& n) {
  constexpr std::int32_t count = Side * Side;
  const RegionColumns columns(a.block_columns);
  SumsWithB with_b;
  n = {};
  for (std::int32_t row = 0, at = 0; row < a.block_rows; ++row) {
    SumsWithB::Region* region = with_b.regions + std::ptrdiff_t{row} * region_columns / a.block_rows * region_columns;
    for (std::int32_t k = 0; k < region_columns; ++k, ++region) {
      for (std::int32_t i = columns.begin[k]; i < columns.begin[k + 1]; ++i, ++at) {
        const auto& block = a.blocks[static_cast<std::size_t>(at)];
        const LocalWarp local = ProjectiveModel::local(warp, block.x, block.y);
        if (!Inside(b, local, half_side<Side>).has(local.x, local.y)) continue;
        const std::size_t start = static_cast<std::size_t>(at) * static_cast<std::size_t>(count);
        const BlockProducts p =
            multiply_block<Width, Side>(a, start, b, first_x<Side>(b, local.x, local), first_y<Side>(b, local.y, local),
                                        BlockSteps<Width, Side>(local));
        const auto motion = ProjectiveModel::motion(block.x, block.y);
        const double own_before = n.detail_aa;
        add_own<8>(block, count, motion, n);
        const Four with_block = __builtin_convertvector(p.with_b, Four);
        const double gxb = 0.5 / value_unit * with_block[2], gyb = 0.5 / value_unit * with_block[3];
        for (int j = 0; j < 8; ++j) n.rhs[j] += gxb * motion.along_x[j] + gyb * motion.along_y[j];
        with_b.b += p.b;
        with_b.products += with_block;
        region->blocks += 1;
        region->detail_aa += n.detail_aa - own_before;
        region->details += details_of(p, block.a, count);
      }
    }
  }
  with_b.put_into(count, n);
}

template <typename Model>
void build_equations(const RegistrationTemplate& a, const RegistrationImage& b, const typename Model::Warp& warp,
                     NormalEquations<Model::freedom>& n) {
  constexpr int N = Model::freedom;
  with_known_vectors([&](auto width) {
    if (a.block_px == registration_block_px) {
      sum_blocks<decltype(width), registration_block_px>(a, b, warp, n);
    } else {
      sum_blocks<decltype(width), registration_block_px / 2>(a, b, warp, n);
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

/// One step; see step_similarity().
template <typename Model>
Result<bool> step_model(const RegistrationTemplate& a, const RegistrationImage& b, bool wanted,
                        typename Model::Warp& warp, RegistrationFit& fit) {
  constexpr int N = Model::freedom;
  if (b.width() != a.width || b.height() != a.height)
    return Status{StatusCode::image_size_changed, b.width(), b.height()};
  const double radius = 0.5 * std::max(a.width, a.height);
  const double all_blocks = std::max(a.block_columns * a.block_rows, 1);
  NormalEquations<N> n;
  build_equations<Model>(a, b, warp, n);
  fit.covered = n.blocks / all_blocks;
  fit.ncc = fit.detail_ncc = 0;
  fit.converged = false;
  if (n.blocks < min_blocks) return false;
  fit.ncc = correlation(n.count, n.sum_aa - n.sum_a * n.sum_a / n.count, n.sum_bb - n.sum_b * n.sum_b / n.count,
                        n.sum_ab - n.sum_a * n.sum_b / n.count);
  fit.detail_ncc = correlation(n.count, n.detail_aa, n.detail_bb, n.detail_ab);
  const auto finish = [&] { compare_regions(n, all_blocks, a.block_px * a.block_px, fit); };
  if (!(fit.ncc > 0)) {
    finish();
    return false;
  }

  double solution[N + 2];
  for (int k = 0; k < N + 2; ++k) solution[k] = n.rhs[k];
  const bool solvable = factor_positive_definite<N + 2>(n.a, 1e-10);
  if (solvable) solve_factored<N + 2>(n.a, solution);
  if (!solvable || !(solution[N] > 0)) {
    finish();
    return false;
  }
  const double gain = solution[N];
  double step[N];
  for (int k = 0; k < N; ++k) step[k] = solution[k] / gain;
  const double moved =
      motion_length<N>(Model::motion(radius, 0), step) + motion_length<N>(Model::motion(0, radius), step);
  // A step of more than that is far outside the range of the gradients.
  const bool stepped = wanted && moved < 0.5 * radius && Model::compose_inverse(step, warp);
  fit.converged = stepped && moved < step_done_px;
  if (stepped && !fit.converged) return true;
  double explained = 0;
  for (int k = 0; k < N + 2; ++k) explained += n.rhs[k] * solution[k];
  const double variance = std::max(n.sum_bb - explained, 0.0) / n.count * correlated_px;
  fit.sigma_px =
      std::sqrt(0.5 * variance *
                (inverse_diagonal<N + 2>(n.a, Model::shift_x) + inverse_diagonal<N + 2>(n.a, Model::shift_y))) /
      gain;
  finish();
  return false;
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
  std::size_t sums_at = 0;
  for (std::int32_t row = 0; row < out.block_rows; ++row) {
    SimilarityTerms own{};
    out.similarity_sums[sums_at++] = own;
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
      add_difference(similarity_terms(sums, bs * bs), {}, own);
      out.similarity_sums[sums_at++] = own;
    }
  }
  return {};
}

Result<bool> step_similarity(const RegistrationTemplate& a, const RegistrationImage& b, bool wanted,
                             CentredSimilarity& b_from_a, RegistrationFit& fit) {
  return step_model<SimilarityModel>(a, b, wanted, b_from_a, fit);
}

Status register_projectivity(const RegistrationTemplate& a, const RegistrationImage& b, int max_iterations,
                             CentredProjectivity& b_from_a, RegistrationFit& fit) {
  fit = {};
  bool goes_on = true;
  for (int iteration = 0; goes_on && iteration <= max_iterations; ++iteration) {
    ILP_TAKE(goes_on, step_model<ProjectiveModel>(a, b, iteration < max_iterations, b_from_a, fit));
  }
  return {};
}

}  // namespace ilp
