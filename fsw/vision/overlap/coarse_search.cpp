#include "fsw/vision/overlap/coarse_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "fsw/base/argument.hpp"
#include "fsw/base/word_lanes.hpp"
#include "fsw/vision/image/sampling.hpp"

namespace ilp {
namespace {

constexpr std::int32_t canvas_side = CoarseWorkspace::canvas_side;
constexpr std::int32_t padded_side = CoarseWorkspace::padded_side;
constexpr std::int32_t sums_stride = CoarseWorkspace::sums_stride;
constexpr std::int32_t prefix_stride = padded_side + 1;
constexpr std::int32_t pad = canvas_side;
constexpr std::int32_t byte_vector_px = CoarseWorkspace::byte_vector_px;
constexpr float no_score = -2.0F;
constexpr std::int32_t grey_level = 1 << coarse_value_bits;

// Neighbouring rotations and scales differ by this much at the corners: half of it is the largest misfit.
constexpr double grid_step_px = 2.6;

// With only the shift unknown, the right peak is distinct.
constexpr std::size_t single_cell_candidates = 10;

struct Moments {
  std::int32_t mean = 0;
  double stddev = 0;
};

Moments moments(CoarseView image) {
  std::int64_t sum = 0, squares = 0;
  for (std::int32_t y = 0; y < image.height; ++y) {
    const std::int16_t* const row = image.row(y);
    for (std::int32_t x = 0; x < image.width; ++x) {
      sum += row[x];
      const std::int32_t square = row[x] * row[x];
      squares += square;
    }
  }
  const double n = static_cast<double>(image.area());
  const double mean = static_cast<double>(sum) / n;
  return {static_cast<std::int32_t>(std::floor(mean + 0.5)),
          std::sqrt(std::max(static_cast<double>(squares) / n - mean * mean, 0.0))};
}

/// One turned and scaled template, its range of shifts, and its counterpart.
struct Template {
  std::int32_t width = 0, height = 0;     ///< of the canvas
  std::int32_t shift_x = 0, shift_y = 0;  ///< largest shift on both sides
  std::int32_t min_covered = 0;           ///< canvas pixels
  double gain_a = 1, gain_b = 1;          ///< from values to bytes
  double phase_x = 0, phase_y = 0;        ///< px by which a is drawn off the centre of the canvas
};

/// Of shifts or pixels along x.
struct Shifts {
  std::int32_t begin, end;
};

// Absolute differences are fastest on bytes. Values far from the mean are clipped, which does little harm to a sum of
// absolute values.
std::uint8_t to_byte(std::int32_t centred) {
  return static_cast<std::uint8_t>(std::clamp(centred + 128, 0, 255));
}

std::uint32_t word_of(std::int32_t lower, std::int32_t upper) {
  return (static_cast<std::uint32_t>(lower) & 0xFFFFU) | static_cast<std::uint32_t>(upper) << 16U;
}

// b with zeros around it, and its sums along rows, which outside of b continue with the last value.
void prepare_b(CoarseView b, std::int32_t mean, double byte_gain, OverlapMethod method, CoarseWorkspace& w) {
  for (std::int32_t y = 0; y < b.height; ++y) {
    std::uint32_t* const words = w.padded.data() + std::ptrdiff_t{y} * padded_side;
    std::int32_t* const sums = w.prefix.data() + std::ptrdiff_t{y} * prefix_stride;
    std::int32_t* const squares = w.prefix_squares.data() + std::ptrdiff_t{y} * prefix_stride;
    const std::int16_t* const from = b.row(y);
    std::fill_n(words, padded_side, 0U);
    std::fill_n(sums, pad + 1, 0);
    std::fill_n(squares, pad + 1, 0);
    std::int32_t sum = 0, square_sum = 0;
    for (std::int32_t x = 0; x < b.width; ++x) {
      const std::int32_t value = from[x] - mean;
      words[pad + x] = word_of(value, x + 1 < b.width ? from[x + 1] - mean : 0);
      sums[pad + x + 1] = sum += value;
      squares[pad + x + 1] = square_sum += value * value;
    }
    words[pad - 1] = word_of(0, from[0] - mean);
    std::fill_n(sums + pad + b.width + 1, padded_side - pad - b.width, sum);
    std::fill_n(squares + pad + b.width + 1, padded_side - pad - b.width, square_sum);
    if (method == OverlapMethod::ncc) continue;
    std::uint8_t* const bytes = w.padded_bytes.data() + std::ptrdiff_t{y} * padded_side;
    std::uint8_t* const mask = w.padded_mask.data() + std::ptrdiff_t{y} * padded_side;
    std::fill_n(bytes, padded_side, std::uint8_t{0});
    std::fill_n(mask, padded_side, std::uint8_t{0});
    std::fill_n(mask + pad, b.width, std::uint8_t{255});
    for (std::int32_t x = 0; x < b.width; ++x) {
      bytes[pad + x] = to_byte(static_cast<std::int32_t>(std::floor(byte_gain * (from[x] - mean) + 0.5)));
    }
  }
}

void join_neighbours(CoarseView a, CoarseWorkspace& w) {
  for (std::int32_t y = 0; y < a.height; ++y) {
    const std::int16_t* const from = a.row(y);
    std::uint32_t* const pairs = w.pairs.data() + std::ptrdiff_t{y} * coarse_max_side;
    for (std::int32_t x = 0; x + 1 < a.width; ++x) pairs[x] = word_of(from[x], from[x + 1]);
    pairs[a.width - 1] = word_of(from[a.width - 1], 0);
  }
}

/// One row of the turned and scaled image: the place of its first pixel in a, and the way to the next one.
struct CanvasRow {
  FixedCoordinate x, y, step_x, step_y;
  std::int32_t width;
};

// Bilinear, minus the mean, and 0 outside. Returns which pixels are inside: they stand side by side.
template <typename Width>
Shifts sample_row(CoarseView a, std::int32_t mean, const CanvasRow& row, CoarseWorkspace& w) {
  using Lanes = WordLanes<Width>;
  using Sums = typename Lanes::Sums;
  using Places = typename Lanes::UnsignedSums;
  using Words = typename Lanes::Words;
  const auto end_x = static_cast<std::uint32_t>((a.width - 1) << 16);
  const auto end_y = static_cast<std::uint32_t>((a.height - 1) << 16);
  Sums number{};
  for (std::int32_t i = 0; i < Lanes::sum_count; ++i) number[i] = i;
  Sums x = row.step_x * number + row.x, y = row.step_y * number + row.y;
  Sums first = Sums{} + row.width, count{};
  for (std::int32_t i = 0; i < row.width; i += Lanes::sum_count) {
    const Sums inside =
        (reinterpret_cast<Places>(x) < end_x) & (reinterpret_cast<Places>(y) < end_y) & (number < row.width);
    const Sums at = ((y >> 16) * coarse_max_side + (x >> 16)) & inside;
    Sums upper, lower;
    Lanes::gather(w.pairs.data(), at, upper);
    Lanes::gather(w.pairs.data() + coarse_max_side, at, lower);
    const Sums share_x = (x >> 8) & 255, share_y = (y >> 8) & 255;
    const Words shares = reinterpret_cast<Words>((share_x << 16) + 256 - share_x);
    Sums top{}, bottom{};
    Lanes::add_products(reinterpret_cast<Words>(upper), shares, top);
    Lanes::add_products(reinterpret_cast<Words>(lower), shares, bottom);
    const Sums value = ((((top << 8) + share_y * (bottom - top) + 0x8000) >> 16) - mean) & inside;
    std::memcpy(w.row.data() + i, &value, sizeof value);
    first = (inside & (number < first)) != 0 ? number : first;
    count += inside;
    number += Lanes::sum_count;
    x += Lanes::sum_count * row.step_x;
    y += Lanes::sum_count * row.step_y;
  }
  const std::int32_t pixels = -Lanes::sum_of(count);
  std::int32_t begin = row.width;
  for (std::int32_t i = 0; i < Lanes::sum_count; ++i) begin = std::min(begin, first[i]);
  return pixels == 0 ? Shifts{0, 0} : Shifts{begin, begin + pixels};
}

// One row of the turned and scaled image, and its sums on top of those of the rows above.
template <typename Width>
void draw_row(CoarseView a, std::int32_t mean, double byte_gain, OverlapMethod method, const CanvasRow& row,
              std::int32_t y, CoarseWorkspace& w) {
  const Shifts inside = sample_row<Width>(a, mean, row, w);
  w.span_begin[static_cast<std::size_t>(y)] = static_cast<std::int16_t>(inside.begin);
  w.span_end[static_cast<std::size_t>(y)] = static_cast<std::int16_t>(inside.end);
  const std::int32_t width = row.width;
  std::fill_n(w.row.data() + width, byte_vector_px, 0);
  const std::int32_t* const values = w.row.data();
  const std::ptrdiff_t at = std::ptrdiff_t{y} * canvas_side;
  std::int16_t* const __restrict canvas = w.canvas.data() + at;
  for (std::int32_t x = 0; x < width + byte_vector_px; ++x) canvas[x] = static_cast<std::int16_t>(values[x]);

  const std::ptrdiff_t above = std::ptrdiff_t{y} * sums_stride + width, below = above + sums_stride;
  const std::int32_t* const inside_above = w.inside_sums.data() + above - width;
  std::int32_t* const __restrict inside_sums = w.inside_sums.data() + below - width;
  for (std::int32_t x = 0; x <= width; ++x) {
    inside_sums[x] = inside_above[x] + std::clamp(width - x - inside.begin, 0, inside.end - inside.begin);
  }
  std::int32_t value_sum = 0, square_sum = 0;
  w.value_sums[static_cast<std::size_t>(below)] = 0;
  w.square_sums[static_cast<std::size_t>(below)] = 0;
  for (std::int32_t x = 0; x < width; ++x) {
    value_sum += values[x];
    square_sum += values[x] * values[x];
    const auto from = static_cast<std::size_t>(above - x - 1), to = static_cast<std::size_t>(below - x - 1);
    w.value_sums[to] = w.value_sums[from] + value_sum;
    w.square_sums[to] = w.square_sums[from] + square_sum;
  }
  if (method == OverlapMethod::ncc) return;
  for (std::int32_t x = 0; x < std::min(width + byte_vector_px, canvas_side); ++x) {
    const auto i = static_cast<std::size_t>(at + x);
    const bool is_inside = x >= inside.begin && x < inside.end;
    w.canvas_mask[i] = is_inside ? std::uint8_t{255} : std::uint8_t{0};
    w.canvas_bytes[i] =
        is_inside ? to_byte(static_cast<std::int32_t>(std::floor(byte_gain * values[x] + 0.5))) : std::uint8_t{0};
  }
}

// Draws a, turned and scaled about its centre.
template <typename Width>
void draw_template(CoarseView a, std::int32_t mean, double scale, double rotation_rad, OverlapMethod method,
                   Template& t, CoarseWorkspace& w) {
  const double c = det_cos(rotation_rad), s = det_sin(rotation_rad);
  const double full_w = scale * (std::fabs(c) * a.width + std::fabs(s) * a.height);
  const double full_h = scale * (std::fabs(s) * a.width + std::fabs(c) * a.height);
  t.width = std::min(static_cast<std::int32_t>(std::ceil(full_w)), canvas_side);
  t.height = std::min(static_cast<std::int32_t>(std::ceil(full_h)), canvas_side);
  std::fill_n(w.inside_sums.begin(), t.width + 1, 0);
  std::fill_n(w.value_sums.begin(), t.width + 1, 0);
  std::fill_n(w.square_sums.begin(), t.width + 1, 0);
  // The inverse mapping: a = R^T (canvas) / scale, along a row in fixed steps.
  const FixedCoordinate step_x = to_fixed(c / scale), step_y = to_fixed(-s / scale);
  for (std::int32_t y = 0; y < t.height; ++y) {
    const double u = -0.5 * (t.width - 1) - t.phase_x, v = y - 0.5 * (t.height - 1) - t.phase_y;
    const CanvasRow row{to_fixed((c * u + s * v) / scale + 0.5 * (a.width - 1)),
                        to_fixed((-s * u + c * v) / scale + 0.5 * (a.height - 1)), step_x, step_y, t.width};
    draw_row<Width>(a, mean, t.gain_a, method, row, y, w);
  }
}

/// The part of the canvas that covers b.
struct Covered {
  std::int32_t x0, y0, x1, y1;
};

// Differences of two rows of sums, from the right end of the columns to the left one; columns outside of the template
// have what its ends have. Whole vectors, the end of each of the three parts under the beginning of the next one.
template <typename Width>
void sum_columns(const std::int32_t* lower, const std::int32_t* upper, std::int32_t width, std::int32_t first,
                 std::int32_t count, std::int32_t* out) {
  using Sums = typename WordLanes<Width>::Sums;
  constexpr std::int32_t lanes = WordLanes<Width>::sum_count;
  const std::int32_t right = std::clamp(first - width, 0, count), left = std::clamp(first + 1, right, count);
  const Sums whole = Sums{} + (lower[0] - upper[0]), none{};
  for (std::int32_t k = 0; k < right; k += lanes) std::memcpy(out + k, &whole, sizeof whole);
  for (std::int32_t k = right, x = width - first + right; k < left; k += lanes, x += lanes) {
    Sums sums, above;
    load_lanes(lower + x, sums);
    load_lanes(upper + x, above);
    sums -= above;
    std::memcpy(out + k, &sums, sizeof sums);
  }
  for (std::int32_t k = left; k < count; k += lanes) std::memcpy(out + k, &none, sizeof none);
}

// Sums over the covered part of the template, for all shifts along x of one along y.
template <typename Width>
void sum_template(CoarseView b, const Template& t, std::int32_t left, const Covered& rows, CoarseWorkspace& w) {
  const std::ptrdiff_t upper = std::ptrdiff_t{rows.y0} * sums_stride;
  const std::ptrdiff_t lower = std::ptrdiff_t{rows.y1} * sums_stride;
  const std::int32_t shifts = 2 * t.shift_x + 1, first = b.width - left;
  const auto sum = [&](const auto& sums, auto& columns, std::int32_t* out) {
    sum_columns<Width>(sums.data() + lower, sums.data() + upper, t.width, first, shifts + b.width, columns.data());
    const std::int32_t* const ends = columns.data();
    const std::int32_t* const begins = ends + b.width;
    for (std::int32_t i = 0; i < shifts; i += WordLanes<Width>::sum_count) {
      typename WordLanes<Width>::Sums end, begin;
      load_lanes(ends + i, end);
      load_lanes(begins + i, begin);
      end -= begin;
      std::memcpy(out + i, &end, sizeof end);
    }
  };
  sum(w.inside_sums, w.column_sums.inside, w.count.data());
  sum(w.value_sums, w.column_sums.value, w.sum_a.data());
  sum(w.square_sums, w.column_sums.square, w.sum_aa.data());
}

/// From the first shift with enough of the template covered to the last one.
Shifts covering(std::int32_t shifts, std::int32_t min_covered, const CoarseWorkspace& w) {
  Shifts s{0, shifts};
  while (s.begin < s.end && w.count[static_cast<std::size_t>(s.begin)] < min_covered) ++s.begin;
  while (s.end > s.begin && w.count[static_cast<std::size_t>(s.end - 1)] < min_covered) --s.end;
  return s;
}

// Whole vectors of shifts need no loop for the rest; what lies beyond the last shift is not read.
constexpr std::int32_t shifts_at_once = 16;
static_assert(sizeof(CoarseWorkspace::sum_ab) / sizeof(std::int32_t) >= CoarseWorkspace::max_shifts + shifts_at_once);
static_assert(sizeof(CoarseWorkspace::scores) / sizeof(float) >=
              CoarseWorkspace::max_shifts * CoarseWorkspace::max_shifts + shifts_at_once);
static_assert(pad + coarse_max_side + canvas_side + shifts_at_once <= prefix_stride);

// Sums of b and b^2 under the inside part of the template.
void sum_b_under_template(const Shifts& s, std::int32_t left, std::int32_t top, const Covered& rows,
                          CoarseWorkspace& w) {
  for (std::int32_t i = s.begin; i < s.end; i += shifts_at_once) {
    constexpr std::int32_t vectors = 2, lanes = shifts_at_once / vectors;
    using Lanes [[gnu::vector_size(lanes * sizeof(std::int32_t))]] = std::int32_t;
    Lanes sum[vectors] = {}, squares[vectors] = {};
    const auto add_differences = [](const std::int32_t* ends, const std::int32_t* begins, Lanes* sums) {
      for (std::int32_t k = 0; k < vectors; ++k) {
        Lanes end, begin;
        std::memcpy(&end, ends + std::ptrdiff_t{k} * lanes, sizeof end);
        std::memcpy(&begin, begins + std::ptrdiff_t{k} * lanes, sizeof begin);
        sums[k] += end - begin;
      }
    };
    for (std::int32_t y = rows.y0; y < rows.y1; ++y) {
      const std::size_t row = static_cast<std::size_t>(y);
      const std::int32_t start = (y + top) * prefix_stride + pad + left + i;
      const std::int32_t from = start + w.span_begin[row], to = start + w.span_end[row];
      add_differences(w.prefix.data() + to, w.prefix.data() + from, sum);
      add_differences(w.prefix_squares.data() + to, w.prefix_squares.data() + from, squares);
    }
    std::memcpy(w.sum_b.data() + i, sum, sizeof sum);
    std::memcpy(w.sum_bb.data() + i, squares, sizeof squares);
  }
}

// Sums of the products of the template and b. Columns beyond b or the template add nothing, because one of the factors
// is zero there.
template <typename Width>
void multiply_template(const Template& t, CoarseView b, const Shifts& s, std::int32_t left, std::int32_t top,
                       const Covered& rows, CoarseWorkspace& w) {
  using Lanes = WordLanes<Width>;
  using Words = typename Lanes::Words;
  constexpr std::int32_t vectors = shifts_at_once / Lanes::sum_count;
  for (std::int32_t i = s.begin; i < s.end; i += shifts_at_once) {
    const std::int32_t last = std::min(i + shifts_at_once, s.end) - 1;
    const std::int32_t x0 = std::clamp(-left - last, 0, t.width), x1 = std::clamp(b.width - left - i, 0, t.width);
    typename Lanes::Sums sums[vectors] = {};
    for (std::int32_t y = rows.y0; y < rows.y1; ++y) {
      const std::int16_t* const p = w.canvas.data() + std::ptrdiff_t{y} * canvas_side;
      const std::uint32_t* const q = w.padded.data() + std::ptrdiff_t{y + top} * padded_side + left + pad + i;
#pragma GCC unroll 2
      for (std::int32_t x = x0; x < x1; x += 2) {
        std::int32_t pair;
        std::memcpy(&pair, p + x, sizeof pair);
        const typename Lanes::Sums pairs = typename Lanes::Sums{} + pair;
        for (std::int32_t k = 0; k < vectors; ++k) {
          Words words;
          load_lanes(q + x + k * Lanes::sum_count, words);
          Lanes::add_products(words, reinterpret_cast<Words>(pairs), sums[k]);
        }
      }
    }
    std::memcpy(w.sum_ab.data() + i, sums, sizeof sums);
  }
}

// Each image masks the other: pixels outside of either add nothing.
template <std::int32_t Vectors>
std::int32_t absolute_rows(const std::uint8_t* p, const std::uint8_t* mask_p, const std::uint8_t* q,
                           const std::uint8_t* mask_q, std::int32_t rows) {
  std::int32_t sum = 0;
  for (std::int32_t y = 0; y < rows; ++y) {
    for (std::int32_t x = 0; x < Vectors * byte_vector_px; ++x) {
      const auto masked_p = static_cast<std::uint8_t>(p[x] & mask_q[x]);
      const auto masked_q = static_cast<std::uint8_t>(q[x] & mask_p[x]);
      sum += std::abs(static_cast<std::int32_t>(masked_p) - static_cast<std::int32_t>(masked_q));
    }
    p += canvas_side;
    mask_p += canvas_side;
    q += padded_side;
    mask_q += padded_side;
  }
  return sum;
}

std::int32_t absolute_difference(const CoarseWorkspace& w, const Covered& c, std::int32_t left, std::int32_t top) {
  const std::int32_t in_p = c.y0 * canvas_side + c.x0, in_q = (c.y0 + top) * padded_side + left + pad + c.x0;
  const std::uint8_t* const p = w.canvas_bytes.data() + in_p;
  const std::uint8_t* const mask_p = w.canvas_mask.data() + in_p;
  const std::uint8_t* const q = w.padded_bytes.data() + in_q;
  const std::uint8_t* const mask_q = w.padded_mask.data() + in_q;
  static_assert(coarse_max_side <= 2 * byte_vector_px);
  return c.x1 - c.x0 <= byte_vector_px ? absolute_rows<1>(p, mask_p, q, mask_q, c.y1 - c.y0)
                                       : absolute_rows<2>(p, mask_p, q, mask_q, c.y1 - c.y0);
}

// There is no score if less than `min_covered` is covered, or if the contrast is below one grey level.
void correlate(const Shifts& s, std::int32_t min_covered, const CoarseWorkspace& w, float* scores) {
  for (std::int32_t at = s.begin; at < s.end; at += shifts_at_once) {
    const auto first = static_cast<std::size_t>(at);
    for (std::size_t i = first; i < first + shifts_at_once; ++i) {
      const double n = w.count[i], a = w.sum_a[i], b = w.sum_b[i];
      const double var_a = n * w.sum_aa[i] - a * a, var_b = n * w.sum_bb[i] - b * b;
      const double floor = n * n * (0.25 * grey_level * grey_level);
      const bool valid = (w.count[i] >= min_covered) & (var_a >= floor) & (var_b >= floor);
      const double score = (n * w.sum_ab[i] - a * b) / std::sqrt(valid ? var_a * var_b : 1.0);
      scores[i] = valid ? static_cast<float>(score) : no_score;
    }
  }
}

// Beyond it less than the smallest overlap is covered, even if the other axis is covered in full.
std::int32_t largest_shift(std::int32_t template_px, std::int32_t b_px, double min_overlap) {
  const double touching = 0.5 * (template_px + b_px);
  const double covered = 0.9 * min_overlap * std::min(template_px, b_px);
  return static_cast<std::int32_t>(std::min(touching - covered + 2, touching));
}

constexpr double byte_stddev = 32;  // both images are brought to this contrast before differences are taken

// The correlation that Gaussian grey values with this mean absolute difference would have: E |d| = sqrt(2 / pi) sigma.
// Contrast and mean are those of the covered part, or flat ground would match flat ground best.
void correlate_differences(const Shifts& s, std::int32_t min_covered, double gain_a, double gain_b,
                           const CoarseWorkspace& w, float* scores) {
  for (std::int32_t i = s.begin; i < s.end; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double n = std::max(w.count[k], 1);
    const double mean_a = gain_a * w.sum_a[k] / n, mean_b = gain_b * w.sum_b[k] / n;
    const double var_a = gain_a * gain_a * w.sum_aa[k] / n - mean_a * mean_a;
    const double var_b = gain_b * gain_b * w.sum_bb[k] / n - mean_b * mean_b;
    const double floor = 0.25 * grey_level * grey_level;
    const bool valid =
        (w.count[k] >= min_covered) & (var_a >= gain_a * gain_a * floor) & (var_b >= gain_b * gain_b * floor);
    const double difference = w.sum_ab[k] / n, shade = mean_a - mean_b;
    const double var_d = 0.5 * pi * difference * difference - shade * shade;
    const double score = 0.5 * (var_a + var_b - var_d) / std::sqrt(valid ? var_a * var_b : 1.0);
    scores[i] = valid ? static_cast<float>(score) : no_score;
  }
}

// Scores of all shifts of one template.
template <typename Width>
void score_shifts(CoarseView b, const Template& t, OverlapMethod method, CoarseWorkspace& w) {
  const std::int32_t shifts = 2 * t.shift_x + 1;
  const std::int32_t left = (b.width - t.width) / 2 - t.shift_x;
  for (std::int32_t j = 0; j <= 2 * t.shift_y; ++j) {
    const std::int32_t top = (b.height - t.height) / 2 + j - t.shift_y;
    float* const scores = w.scores.data() + std::ptrdiff_t{j} * shifts;
    Covered c{0, std::clamp(-top, 0, t.height), 0, std::clamp(b.height - top, 0, t.height)};
    sum_template<Width>(b, t, left, c, w);
    const Shifts s = covering(shifts, t.min_covered, w);
    std::fill_n(scores, shifts, no_score);
    if (s.begin == s.end) continue;
    sum_b_under_template(s, left, top, c, w);
    if (method == OverlapMethod::ncc) {
      multiply_template<Width>(t, b, s, left, top, c, w);
      correlate(s, t.min_covered, w, scores);
      continue;
    }
    for (std::int32_t i = s.begin; i < s.end; ++i) {
      const std::int32_t x = left + i;
      c.x0 = std::clamp(-x, 0, t.width);
      c.x1 = std::clamp(b.width - x, 0, t.width);
      w.sum_ab[static_cast<std::size_t>(i)] = absolute_difference(w, c, x, top);
    }
    correlate_differences(s, t.min_covered, t.gain_a, t.gain_b, w, scores);
  }
}

/// The rotations and scales searched: the middles of equal cells, so that no point is farther than half a step.
struct Grid {
  int rotations = 1, scales = 1;
  double rotation_step = 0, log_scale_step = 0;
};

Grid plan_grid(double radius, const OverlapParams& params) {
  Grid g;
  const double turn = 2 * params.max_rotation_rad, log_scale = 2 * det_log(params.max_scale);
  g.rotations = std::max(static_cast<int>(std::ceil(turn * radius / grid_step_px)), 1);
  g.scales = std::max(static_cast<int>(std::ceil(log_scale * radius / grid_step_px)), 1);
  g.rotation_step = turn / g.rotations;
  g.log_scale_step = log_scale / g.scales;
  return g;
}

bool same_peak(const CoarseCandidate& p, const CoarseCandidate& q, const Grid& grid) {
  constexpr double reach_px = 1.1;
  const double turn = std::fabs(p.rotation_rad - q.rotation_rad);
  return std::min(turn, 2 * pi - turn) < 1.5 * grid.rotation_step + 1e-9 &&
         std::max(p.scale / q.scale, q.scale / p.scale) < 1 + 1.5 * grid.log_scale_step + 1e-9 &&
         std::fabs(p.b_from_a.d_x - q.b_from_a.d_x) <= reach_px &&
         std::fabs(p.b_from_a.d_y - q.b_from_a.d_y) <= reach_px;
}

// `like` has the rotation and scale; canvas and b are centred on each other up to `offset`.
void collect_peaks(const Template& t, const CoarseCandidate& like, double offset_x, double offset_y, const Grid& grid,
                   const CoarseWorkspace& w, CoarseCandidates& candidates) {
  const std::int32_t shifts = 2 * t.shift_x + 1;
  for (std::int32_t j = 1; j < 2 * t.shift_y; ++j) {
    for (std::int32_t i = 1; i < shifts - 1; ++i) {
      const float* const p = w.scores.data() + std::ptrdiff_t{j} * shifts + i;
      if (*p <= 0 || (candidates.full() && *p <= candidates.back().score)) continue;
      if (p[-1] > *p || p[1] > *p || p[-shifts] > *p || p[shifts] > *p) continue;
      CoarseCandidate candidate = like;
      candidate.b_from_a.d_x = i - t.shift_x + offset_x;
      candidate.b_from_a.d_y = j - t.shift_y + offset_y;
      candidate.score = *p;
      insert_peak(
          candidate, [&](const CoarseCandidate& known) { return same_peak(known, candidate, grid); }, candidates);
    }
  }
}

template <typename Width>
void search(CoarseView a, CoarseView b, const OverlapParams& params, CoarseWorkspace& w, CoarseCandidates& candidates) {
  const Grid grid = plan_grid(0.5 * std::sqrt(static_cast<double>(a.width * a.width + a.height * a.height)), params);
  const Moments of_a = moments(a), of_b = moments(b);
  const double gain_a = byte_stddev / std::max(of_a.stddev, 1.0), gain_b = byte_stddev / std::max(of_b.stddev, 1.0);
  join_neighbours(a, w);
  prepare_b(b, of_b.mean, gain_b, params.method, w);
  // Turned templates also sample the ground between b's pixels; a single template must be moved there.
  const int phases = grid.rotations * grid.scales == 1 ? 2 : 1;
  for (int k = 0; k < grid.scales; ++k) {
    CoarseCandidate like;
    like.scale = params.predicted_scale * det_exp((k - 0.5 * (grid.scales - 1)) * grid.log_scale_step);
    for (int r = 0; r < grid.rotations; ++r) {
      like.rotation_rad = params.predicted_rotation_rad + (r - 0.5 * (grid.rotations - 1)) * grid.rotation_step;
      like.b_from_a = centred_similarity(like.scale, like.rotation_rad, 0, 0);
      for (int phase = 0; phase < phases * phases; ++phase) {
        Template t;
        t.gain_a = gain_a;
        t.gain_b = gain_b;
        t.phase_x = 0.5 * (phase % phases);
        const int phase_row = phase / phases;
        t.phase_y = 0.5 * phase_row;
        draw_template<Width>(a, of_a.mean, like.scale, like.rotation_rad, params.method, t, w);
        // A tenth of tolerance: the grid of rotations and scales misses the true overlap by about that.
        const double needed = 0.9 * params.min_overlap * like.scale * like.scale;
        t.min_covered = static_cast<std::int32_t>(needed * (a.width - 1) * (a.height - 1));
        t.shift_x = largest_shift(t.width, b.width, params.min_overlap);
        t.shift_y = largest_shift(t.height, b.height, params.min_overlap);
        score_shifts<Width>(b, t, params.method, w);
        // The first place of the template is a whole pixel; half a pixel remains if the difference is odd.
        const std::int32_t left = (b.width - t.width) / 2, top = (b.height - t.height) / 2;
        collect_peaks(t, like, left - 0.5 * (b.width - t.width) + t.phase_x,
                      top - 0.5 * (b.height - t.height) + t.phase_y, grid, w, candidates);
      }
    }
  }
  while (phases > 1 && candidates.size() > single_cell_candidates) candidates.pop_back();
}

}  // namespace

Status search_coarse(CoarseView a, CoarseView b, const OverlapParams& params, CoarseWorkspace& w,
                     CoarseCandidates& candidates) {
  candidates.clear();
  if (std::max(a.width, a.height) > coarse_max_side) return out_of_range(Argument::image_size, a.width);
  if (b.width != a.width || b.height != a.height) return {StatusCode::image_size_changed, b.width, b.height};
  with_known_vectors([&](auto width) { search<decltype(width)>(a, b, params, w, candidates); });
  return {};
}

}  // namespace ilp
