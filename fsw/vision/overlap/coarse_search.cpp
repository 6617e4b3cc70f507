#include "fsw/vision/overlap/coarse_search.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/image/sampling.hpp"

namespace ilp {
namespace {

constexpr std::int32_t canvas_side = CoarseWorkspace::canvas_side;
constexpr std::int32_t padded_side = CoarseWorkspace::padded_side;
constexpr std::int32_t sums_stride = canvas_side + 1;
constexpr std::int32_t prefix_stride = padded_side + 1;
constexpr std::int32_t pad = canvas_side;
constexpr std::int32_t vector_px = 8;
constexpr std::int32_t byte_vector_px = 16;
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

// Absolute differences are fastest on bytes. Values far from the mean are clipped, which does little harm to a sum of
// absolute values.
std::uint8_t to_byte(std::int32_t centred) {
  return static_cast<std::uint8_t>(std::clamp(centred + 128, 0, 255));
}

// b with zeros around it, and its sums along rows, which outside of b continue with the last value.
void prepare_b(CoarseView b, std::int32_t mean, double byte_gain, CoarseWorkspace& w) {
  for (std::int32_t y = 0; y < b.height; ++y) {
    std::int16_t* const out = w.padded.data() + std::ptrdiff_t{y} * padded_side;
    std::uint8_t* const bytes = w.padded_bytes.data() + std::ptrdiff_t{y} * padded_side;
    std::uint8_t* const mask = w.padded_mask.data() + std::ptrdiff_t{y} * padded_side;
    std::int32_t* const sums = w.prefix.data() + std::ptrdiff_t{y} * prefix_stride;
    std::int32_t* const squares = w.prefix_squares.data() + std::ptrdiff_t{y} * prefix_stride;
    sums[0] = squares[0] = 0;
    for (std::int32_t x = 0; x < padded_side; ++x) {
      const bool inside = x >= pad && x < pad + b.width;
      out[x] = static_cast<std::int16_t>(inside ? b.at(x - pad, y) - mean : 0);
      bytes[x] = inside ? to_byte(static_cast<std::int32_t>(std::floor(byte_gain * out[x] + 0.5))) : std::uint8_t{0};
      mask[x] = inside ? std::uint8_t{255} : std::uint8_t{0};
      sums[x + 1] = sums[x] + out[x];
      squares[x + 1] = squares[x] + out[x] * out[x];
    }
  }
}

std::int32_t sample(CoarseView image, FixedCoordinate x, FixedCoordinate y) {
  const std::int16_t* const upper = image.row(y >> 16) + (x >> 16);
  const std::int16_t* const lower = upper + image.stride;
  const std::int32_t fx = (x >> 8) & 255, fy = (y >> 8) & 255;
  const std::int32_t top = (upper[0] << 8) + fx * (upper[1] - upper[0]);
  const std::int32_t bottom = (lower[0] << 8) + fx * (lower[1] - lower[0]);
  return ((top << 8) + fy * (bottom - top) + 0x8000) >> 16;
}

// One row of the turned and scaled image, and its sums on top of those of the rows above.
void draw_row(CoarseView a, std::int32_t mean, double byte_gain, FixedCoordinate ax, FixedCoordinate ay,
              FixedCoordinate step_x, FixedCoordinate step_y, std::int32_t width, std::int32_t y, CoarseWorkspace& w) {
  const auto end_x = static_cast<std::uint32_t>((a.width - 1) << 16);
  const auto end_y = static_cast<std::uint32_t>((a.height - 1) << 16);
  const std::ptrdiff_t at = std::ptrdiff_t{y} * canvas_side;
  const std::ptrdiff_t above = std::ptrdiff_t{y} * sums_stride, below = above + sums_stride;
  std::int32_t begin = width, end = 0, inside_sum = 0, value_sum = 0, square_sum = 0;
  const auto put = [&](std::int32_t x, std::int32_t value, bool is_inside) {
    const auto i = static_cast<std::size_t>(at + x);
    w.canvas[i] = static_cast<std::int16_t>(value);
    w.canvas_mask[i] = is_inside ? std::uint8_t{255} : std::uint8_t{0};
    w.canvas_bytes[i] =
        is_inside ? to_byte(static_cast<std::int32_t>(std::floor(byte_gain * value + 0.5))) : std::uint8_t{0};
  };
  w.inside_sums[static_cast<std::size_t>(below)] = 0;
  w.value_sums[static_cast<std::size_t>(below)] = 0;
  w.square_sums[static_cast<std::size_t>(below)] = 0;
  for (std::int32_t x = 0; x < width; ++x, ax += step_x, ay += step_y) {
    const bool is_inside = static_cast<std::uint32_t>(ax) < end_x && static_cast<std::uint32_t>(ay) < end_y;
    const std::int32_t value = is_inside ? sample(a, ax, ay) - mean : 0;
    put(x, value, is_inside);
    if (is_inside) {
      begin = std::min(begin, x);
      end = x + 1;
    }
    inside_sum += is_inside ? 1 : 0;
    value_sum += value;
    square_sum += value * value;
    const auto from = static_cast<std::size_t>(above + x + 1), to = static_cast<std::size_t>(below + x + 1);
    w.inside_sums[to] = w.inside_sums[from] + inside_sum;
    w.value_sums[to] = w.value_sums[from] + value_sum;
    w.square_sums[to] = w.square_sums[from] + square_sum;
  }
  for (std::int32_t x = width; x < std::min(width + byte_vector_px, canvas_side); ++x) put(x, 0, false);
  w.span_begin[static_cast<std::size_t>(y)] = static_cast<std::int16_t>(std::min(begin, end));
  w.span_end[static_cast<std::size_t>(y)] = static_cast<std::int16_t>(end);
}

// Draws a, turned and scaled about its centre.
void draw_template(CoarseView a, std::int32_t mean, double scale, double rotation_rad, Template& t,
                   CoarseWorkspace& w) {
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
    draw_row(a, mean, t.gain_a, to_fixed((c * u + s * v) / scale + 0.5 * (a.width - 1)),
             to_fixed((-s * u + c * v) / scale + 0.5 * (a.height - 1)), step_x, step_y, t.width, y, w);
  }
}

/// The part of the canvas that covers b.
struct Covered {
  std::int32_t x0, y0, x1, y1;
};

// Sums over the covered part of the template, for all shifts along x of one along y.
void sum_template(CoarseView b, const Template& t, std::int32_t left, const Covered& rows, CoarseWorkspace& w) {
  const std::ptrdiff_t upper = std::ptrdiff_t{rows.y0} * sums_stride;
  const std::ptrdiff_t lower = std::ptrdiff_t{rows.y1} * sums_stride;
  const auto column = [&](const auto& sums, std::int32_t x) {
    return sums[static_cast<std::size_t>(lower + x)] - sums[static_cast<std::size_t>(upper + x)];
  };
  for (std::int32_t i = 0; i <= 2 * t.shift_x; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const std::int32_t x0 = std::clamp(-left - i, 0, t.width), x1 = std::clamp(b.width - left - i, 0, t.width);
    w.count[k] = column(w.inside_sums, x1) - column(w.inside_sums, x0);
    w.sum_a[k] = column(w.value_sums, x1) - column(w.value_sums, x0);
    w.sum_aa[k] = column(w.square_sums, x1) - column(w.square_sums, x0);
  }
}

// Sums of b and b^2 under the inside part of the template, for all shifts along x of one along y.
void sum_b_under_template(const Template& t, std::int32_t left, std::int32_t top, const Covered& rows,
                          CoarseWorkspace& w) {
  const std::int32_t shifts = 2 * t.shift_x + 1;
  std::int32_t* const sum_b = w.sum_b.data();
  std::int32_t* const sum_bb = w.sum_bb.data();
  std::fill_n(sum_b, shifts, 0);
  std::fill_n(sum_bb, shifts, 0);
  for (std::int32_t y = rows.y0; y < rows.y1; ++y) {
    const std::size_t row = static_cast<std::size_t>(y);
    const std::int32_t start = (y + top) * prefix_stride + pad + left;
    const std::int32_t* const from = w.prefix.data() + start + w.span_begin[row];
    const std::int32_t* const to = w.prefix.data() + start + w.span_end[row];
    const std::int32_t* const squares_from = w.prefix_squares.data() + start + w.span_begin[row];
    const std::int32_t* const squares_to = w.prefix_squares.data() + start + w.span_end[row];
    for (std::int32_t i = 0; i < shifts; ++i) {
      sum_b[i] += to[i] - from[i];
      sum_bb[i] += squares_to[i] - squares_from[i];
    }
  }
}

// The number of vectors per row is a constant, so that the compiler needs no remainder loop.
template <std::int32_t Vectors>
std::int32_t dot_rows(const std::int16_t* p, const std::int16_t* q, std::int32_t rows) {
  std::int32_t sum = 0;
  for (std::int32_t y = 0; y < rows; ++y, p += canvas_side, q += padded_side) {
    for (std::int32_t x = 0; x < Vectors * vector_px; ++x) sum += p[x] * q[x];
  }
  return sum;
}

// Columns beyond b or the template add nothing, because one of the factors is zero there.
std::int32_t dot_product(const CoarseWorkspace& w, const Covered& c, std::int32_t left, std::int32_t top) {
  const std::int16_t* const p = w.canvas.data() + std::ptrdiff_t{c.y0} * canvas_side + c.x0;
  const std::int16_t* const q = w.padded.data() + std::ptrdiff_t{c.y0 + top} * padded_side + left + pad + c.x0;
  const std::int32_t rows = c.y1 - c.y0;
  static_assert(coarse_max_side <= 4 * vector_px);
  switch ((c.x1 - c.x0 + vector_px - 1) / vector_px) {
    case 1:
      return dot_rows<1>(p, q, rows);
    case 2:
      return dot_rows<2>(p, q, rows);
    case 3:
      return dot_rows<3>(p, q, rows);
    default:
      return dot_rows<4>(p, q, rows);
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
void correlate(std::int32_t shifts, std::int32_t min_covered, const CoarseWorkspace& w, float* scores) {
  for (std::int32_t i = 0; i < shifts; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double n = w.count[k], a = w.sum_a[k], b = w.sum_b[k];
    const double var_a = n * w.sum_aa[k] - a * a, var_b = n * w.sum_bb[k] - b * b;
    const double floor = n * n * (0.25 * grey_level * grey_level);
    const bool valid = (w.count[k] >= min_covered) & (var_a >= floor) & (var_b >= floor);
    const double score = (n * w.sum_ab[k] - a * b) / std::sqrt(valid ? var_a * var_b : 1.0);
    scores[i] = valid ? static_cast<float>(score) : no_score;
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
void correlate_differences(std::int32_t shifts, std::int32_t min_covered, double gain_a, double gain_b,
                           const CoarseWorkspace& w, float* scores) {
  for (std::int32_t i = 0; i < shifts; ++i) {
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
void score_shifts(CoarseView b, const Template& t, OverlapMethod method, CoarseWorkspace& w) {
  const std::int32_t shifts = 2 * t.shift_x + 1;
  const std::int32_t left = (b.width - t.width) / 2 - t.shift_x;
  for (std::int32_t j = 0; j <= 2 * t.shift_y; ++j) {
    const std::int32_t top = (b.height - t.height) / 2 + j - t.shift_y;
    float* const scores = w.scores.data() + std::ptrdiff_t{j} * shifts;
    Covered c{0, std::clamp(-top, 0, t.height), 0, std::clamp(b.height - top, 0, t.height)};
    sum_template(b, t, left, c, w);
    for (std::int32_t i = 0; i < shifts; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const std::int32_t x = left + i;
      w.sum_ab[k] = 0;
      if (w.count[k] < t.min_covered) continue;
      c.x0 = std::clamp(-x, 0, t.width);
      c.x1 = std::clamp(b.width - x, 0, t.width);
      w.sum_ab[k] = method == OverlapMethod::ncc ? dot_product(w, c, x, top) : absolute_difference(w, c, x, top);
    }
    sum_b_under_template(t, left, top, c, w);
    if (method == OverlapMethod::ncc) {
      correlate(shifts, t.min_covered, w, scores);
    } else {
      correlate_differences(shifts, t.min_covered, t.gain_a, t.gain_b, w, scores);
    }
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

void search(CoarseView a, CoarseView b, const OverlapParams& params, CoarseWorkspace& w, CoarseCandidates& candidates) {
  const Grid grid = plan_grid(0.5 * std::sqrt(static_cast<double>(a.width * a.width + a.height * a.height)), params);
  const Moments of_a = moments(a), of_b = moments(b);
  const double gain_a = byte_stddev / std::max(of_a.stddev, 1.0), gain_b = byte_stddev / std::max(of_b.stddev, 1.0);
  prepare_b(b, of_b.mean, gain_b, w);
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
        draw_template(a, of_a.mean, like.scale, like.rotation_rad, t, w);
        // A tenth of tolerance: the grid of rotations and scales misses the true overlap by about that.
        const double needed = 0.9 * params.min_overlap * like.scale * like.scale;
        t.min_covered = static_cast<std::int32_t>(needed * (a.width - 1) * (a.height - 1));
        t.shift_x = largest_shift(t.width, b.width, params.min_overlap);
        t.shift_y = largest_shift(t.height, b.height, params.min_overlap);
        score_shifts(b, t, params.method, w);
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
  if (std::max(a.width, a.height) > coarse_max_side) return {StatusCode::invalid_argument, 1, a.width};
  if (b.width != a.width || b.height != a.height) return {StatusCode::image_size_changed, b.width, b.height};
  with_widest_vectors([&] { search(a, b, params, w, candidates); });
  return {};
}

}  // namespace ilp
