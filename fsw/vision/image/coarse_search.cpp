#include "fsw/vision/image/coarse_search.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/image/box_sums.hpp"
#include "fsw/vision/image/sampling.hpp"

namespace ilp {
namespace {

constexpr std::int32_t canvas_side = CoarseWorkspace::canvas_side;
constexpr std::int32_t padded_side = CoarseWorkspace::padded_side;
constexpr std::int32_t pad = canvas_side;
constexpr std::int32_t vector_px = 8;
// b's widest row, begun and ended in the middle of a vector.
constexpr std::int32_t max_vectors = (coarse_max_side + 2 * vector_px - 2) / vector_px;
static_assert(max_vectors == 7);
constexpr float no_score = -2.0F;

// A shift off by one pixel at the corners still correlates: neighbouring rotations and scales may differ by twice that.
constexpr double grid_step_px = 3.2;

struct Moments {
  std::int32_t mean = 0;
  double stddev = 0;
};

Moments moments(GrayView image) {
  std::int64_t sum = 0, squares = 0;
  for (std::int32_t y = 0; y < image.height; ++y) {
    const std::uint8_t* const row = image.row(y);
    for (std::int32_t x = 0; x < image.width; ++x) {
      sum += row[x];
      squares += row[x] * row[x];
    }
  }
  const double n = static_cast<double>(image.area());
  const double mean = static_cast<double>(sum) / n;
  return {static_cast<std::int32_t>(mean + 0.5), std::sqrt(static_cast<double>(squares) / n - mean * mean)};
}

/// One turned and scaled template, where it may slide, and what it is compared with.
struct Template {
  std::int32_t width = 0, height = 0;     ///< of the canvas, the width a multiple of vector_px
  std::int32_t shift_x = 0, shift_y = 0;  ///< largest shift on both sides
  std::int32_t min_covered = 0;           ///< canvas pixels
};

// Absolute differences are fastest on bytes; what is far from the mean is cut, which a sum of absolute values can bear.
std::uint8_t to_byte(std::int32_t centred) {
  return static_cast<std::uint8_t>(std::clamp(centred + 128, 0, 255));
}

// b with zeros around, and its sums along rows, which outside of b continue with the last value.
void prepare_b(GrayView b, std::int32_t mean, double gain, CoarseWorkspace& w) {
  std::fill(w.padded.begin(), w.padded.end(), std::int16_t{0});
  for (std::int32_t y = 0; y < b.height; ++y) {
    std::int16_t* const out = w.padded.data() + y * padded_side;
    std::uint8_t* const bytes = w.padded_bytes.data() + y * padded_side;
    std::int32_t* const sums = w.prefix.data() + y * (padded_side + 1);
    std::int32_t* const squares = w.prefix_squares.data() + y * (padded_side + 1);
    sums[0] = squares[0] = 0;
    for (std::int32_t x = 0; x < padded_side; ++x) {
      const bool inside = x >= pad && x < pad + b.width;
      const double value = inside ? gain * (b.at(x - pad, y) - mean) : 0.0;
      out[x] = static_cast<std::int16_t>(std::floor(value + 0.5));
      sums[x + 1] = sums[x] + out[x];
      squares[x + 1] = squares[x] + out[x] * out[x];
      bytes[x] = to_byte(out[x]);
    }
  }
}

// Draws a, turned and scaled about its centre, and the sums over the boxes of what is inside.
void draw_template(GrayView a, std::int32_t mean, double scale, double rotation_rad, Template& t, CoarseWorkspace& w) {
  const double c = det_cos(rotation_rad), s = det_sin(rotation_rad);
  const double half_w = 0.5 * scale * (std::fabs(c) * a.width + std::fabs(s) * a.height);
  const double half_h = 0.5 * scale * (std::fabs(s) * a.width + std::fabs(c) * a.height);
  t.width =
      std::min((static_cast<std::int32_t>(std::ceil(2 * half_w)) + vector_px - 1) / vector_px * vector_px, canvas_side);
  t.height = std::min(static_cast<std::int32_t>(std::ceil(2 * half_h)), canvas_side);

  // The way back: a = R^T (canvas) / scale, along a row in fixed steps.
  const FixedCoordinate step_x = to_fixed(c / scale), step_y = to_fixed(-s / scale);
  const auto end_x = static_cast<std::uint32_t>((a.width - 1) << 16);
  const auto end_y = static_cast<std::uint32_t>((a.height - 1) << 16);
  for (std::int32_t y = 0; y < t.height; ++y) {
    std::int16_t* const out = w.canvas.data() + y * canvas_side;
    std::uint8_t* const bytes = w.canvas_bytes.data() + y * canvas_side;
    std::int32_t* const inside = w.canvas_inside.data() + y * canvas_side;
    std::int32_t* const squares = w.canvas_squares.data() + y * canvas_side;
    const double u = -0.5 * (t.width - 1), v = y - 0.5 * (t.height - 1);
    FixedCoordinate ax = to_fixed((c * u + s * v) / scale + 0.5 * (a.width - 1));
    FixedCoordinate ay = to_fixed((-s * u + c * v) / scale + 0.5 * (a.height - 1));
    std::int32_t begin = t.width, end = 0;
    for (std::int32_t x = 0; x < t.width; ++x, ax += step_x, ay += step_y) {
      const bool is_inside = static_cast<std::uint32_t>(ax) < end_x && static_cast<std::uint32_t>(ay) < end_y;
      const std::int32_t value = is_inside ? sample_bilinear<0>(a, ax, ay) - mean : 0;
      out[x] = static_cast<std::int16_t>(value);
      inside[x] = is_inside ? 1 : 0;
      squares[x] = value * value;
      bytes[x] = to_byte(value);
      if (is_inside) {
        begin = std::min(begin, x);
        end = x + 1;
      }
    }
    w.span_begin[static_cast<std::size_t>(y)] = static_cast<std::int16_t>(std::min(begin, end));
    w.span_end[static_cast<std::size_t>(y)] = static_cast<std::int16_t>(end);
  }
  const auto box = [&](auto& in, auto& out) {
    using Value = std::remove_reference_t<decltype(in[0])>;
    integrate<Value, std::int32_t>({in.data(), t.width, t.height, canvas_side},
                                   {out.data(), t.width + 1, t.height + 1, canvas_side + 1});
  };
  box(w.canvas_inside, w.inside_sums);
  box(w.canvas, w.value_sums);
  box(w.canvas_squares, w.square_sums);
}

// Sums of b and b^2 under the inside part of the template, for all dx of one dy at once.
void sum_b_under_template(GrayView b, const Template& t, std::int32_t left, std::int32_t top, CoarseWorkspace& w) {
  const std::int32_t shifts = 2 * t.shift_x + 1;
  std::fill_n(w.sum_b.begin(), shifts, 0);
  std::fill_n(w.sum_bb.begin(), shifts, 0);
  for (std::int32_t y = std::max(0, -top); y < std::min(t.height, b.height - top); ++y) {
    const std::size_t row = static_cast<std::size_t>(y);
    const std::int32_t start = (y + top) * (padded_side + 1) + pad + left;
    const std::int32_t* const from = w.prefix.data() + start + w.span_begin[row];
    const std::int32_t* const to = w.prefix.data() + start + w.span_end[row];
    const std::int32_t* const squares_from = w.prefix_squares.data() + start + w.span_begin[row];
    const std::int32_t* const squares_to = w.prefix_squares.data() + start + w.span_end[row];
    for (std::int32_t i = 0; i < shifts; ++i) {
      w.sum_b[static_cast<std::size_t>(i)] += to[i] - from[i];
      w.sum_bb[static_cast<std::size_t>(i)] += squares_to[i] - squares_from[i];
    }
  }
}

/// The part of the canvas that lies on b; columns widened to whole vectors, for both images are zero outside.
struct Covered {
  std::int32_t x0, y0, x1, y1;
};

// The number of vectors per row is a constant, so that the compiler needs no loop for what is left over.
template <std::int32_t Vectors>
std::int32_t dot_rows(const std::int16_t* p, const std::int16_t* q, std::int32_t rows) {
  std::int32_t sum = 0;
  for (std::int32_t y = 0; y < rows; ++y, p += canvas_side, q += padded_side) {
    std::int32_t row = 0;
    for (std::int32_t x = 0; x < Vectors * vector_px; ++x) row += p[x] * q[x];
    sum += row;
  }
  return sum;
}

// Columns beyond b or the template cost nothing but time: one of the factors is zero there.
std::int32_t dot_product(const CoarseWorkspace& w, const Covered& c, std::int32_t left, std::int32_t top) {
  const std::int32_t x0 = c.x0 / vector_px * vector_px;
  const std::int16_t* const p = w.canvas.data() + c.y0 * canvas_side + x0;
  const std::int16_t* const q = w.padded.data() + (c.y0 + top) * padded_side + left + pad + x0;
  const std::int32_t rows = c.y1 - c.y0;
  switch ((c.x1 - x0 + vector_px - 1) / vector_px) {
    case 1:
      return dot_rows<1>(p, q, rows);
    case 2:
      return dot_rows<2>(p, q, rows);
    case 3:
      return dot_rows<3>(p, q, rows);
    case 4:
      return dot_rows<4>(p, q, rows);
    case 5:
      return dot_rows<5>(p, q, rows);
    case 6:
      return dot_rows<6>(p, q, rows);
    default:
      return dot_rows<max_vectors>(p, q, rows);
  }
}

std::int32_t absolute_difference(const CoarseWorkspace& w, const Covered& c, std::int32_t left, std::int32_t top) {
  std::int32_t sum = 0;
  for (std::int32_t y = c.y0; y < c.y1; ++y) {
    const std::uint8_t* const p = w.canvas_bytes.data() + y * canvas_side;
    const std::uint8_t* const q = w.padded_bytes.data() + (y + top) * padded_side + left + pad;
    const std::int32_t end = std::min<std::int32_t>(c.x1, w.span_end[static_cast<std::size_t>(y)]);
    for (std::int32_t x = std::max<std::int32_t>(c.x0, w.span_begin[static_cast<std::size_t>(y)]); x < end; ++x) {
      sum += std::abs(p[x] - q[x]);
    }
  }
  return sum;
}

float ncc(double n, double sum_a, double sum_aa, double sum_b, double sum_bb, double sum_ab) {
  const double var_a = n * sum_aa - sum_a * sum_a;
  const double var_b = n * sum_bb - sum_b * sum_b;
  // Below one grey level of standard deviation the correlation is that of the quantisation.
  if (var_a < n * n || var_b < n * n) return no_score;
  return static_cast<float>((n * sum_ab - sum_a * sum_b) / std::sqrt(var_a * var_b));
}

// Beyond it less than the smallest overlap is covered, even when the other axis is covered in full.
std::int32_t largest_shift(std::int32_t template_px, std::int32_t b_px, double min_overlap) {
  const double touching = 0.5 * (template_px + b_px);
  const double covered = 0.9 * min_overlap * std::min(template_px, b_px);
  return static_cast<std::int32_t>(std::min(touching - covered + 2, touching));
}

// Scores of all shifts of one template.
void score_shifts(GrayView b, const Template& t, OverlapMethod method, double stddev, CoarseWorkspace& w) {
  const std::int32_t shifts = 2 * t.shift_x + 1;
  const std::int32_t left = (b.width - t.width) / 2 - t.shift_x;
  const ImageView<std::int32_t> inside(w.inside_sums.data(), t.width + 1, t.height + 1, canvas_side + 1);
  const ImageView<std::int32_t> values(w.value_sums.data(), t.width + 1, t.height + 1, canvas_side + 1);
  const ImageView<std::int32_t> squares(w.square_sums.data(), t.width + 1, t.height + 1, canvas_side + 1);
  for (std::int32_t j = 0; j <= 2 * t.shift_y; ++j) {
    const std::int32_t top = (b.height - t.height) / 2 + j - t.shift_y;
    float* const scores = w.scores.data() + j * shifts;
    if (method == OverlapMethod::ncc) sum_b_under_template(b, t, left, top, w);
    for (std::int32_t i = 0; i < shifts; ++i) {
      const std::int32_t x = left + i;
      const Covered c{std::clamp(-x, 0, t.width), std::clamp(-top, 0, t.height), std::clamp(b.width - x, 0, t.width),
                      std::clamp(b.height - top, 0, t.height)};
      scores[i] = no_score;
      const std::int32_t n = box_sum(inside, c.x0, c.y0, c.x1, c.y1);
      if (n < t.min_covered) continue;
      if (method == OverlapMethod::ncc) {
        scores[i] =
            ncc(n, box_sum(values, c.x0, c.y0, c.x1, c.y1), box_sum(squares, c.x0, c.y0, c.x1, c.y1),
                w.sum_b[static_cast<std::size_t>(i)], w.sum_bb[static_cast<std::size_t>(i)], dot_product(w, c, x, top));
      } else {
        const double mean = static_cast<double>(absolute_difference(w, c, x, top)) / n;
        scores[i] = static_cast<float>(1 - pi * mean * mean / (4 * stddev * stddev));
      }
    }
  }
}

bool same_peak(const CoarseCandidate& p, const CoarseCandidate& q, double rotation_step, double scale_step) {
  constexpr double reach_px = 3;
  const double turn = std::fabs(p.rotation_rad - q.rotation_rad);
  return std::min(turn, 2 * pi - turn) < 2.5 * rotation_step &&
         std::max(p.scale / q.scale, q.scale / p.scale) < scale_step * scale_step * 1.01 &&
         std::fabs(p.b_from_a.d_x - q.b_from_a.d_x) <= reach_px &&
         std::fabs(p.b_from_a.d_y - q.b_from_a.d_y) <= reach_px;
}

// Keeps the list sorted, best first, with one entry per peak.
void insert(const CoarseCandidate& candidate, double rotation_step, double scale_step, CoarseCandidates& list) {
  std::size_t last = list.size();
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (!same_peak(list[i], candidate, rotation_step, scale_step)) continue;
    if (list[i].score >= candidate.score) return;
    last = i;
    break;
  }
  if (last == list.size() && !list.push_back(candidate)) {
    if (list.back().score >= candidate.score) return;
    last = list.size() - 1;
  }
  for (; last > 0 && list[last - 1].score < candidate.score; --last) list[last] = list[last - 1];
  list[last] = candidate;
}

void collect_peaks(const Template& t, double scale, double rotation_rad, double offset_x, double offset_y,
                   double rotation_step, double scale_step, const CoarseWorkspace& w, CoarseCandidates& candidates) {
  const std::int32_t shifts = 2 * t.shift_x + 1;
  for (std::int32_t j = 1; j < 2 * t.shift_y; ++j) {
    for (std::int32_t i = 1; i < shifts - 1; ++i) {
      const float* const p = w.scores.data() + j * shifts + i;
      if (*p <= 0 || (candidates.full() && *p <= candidates.back().score)) continue;
      if (p[-1] > *p || p[1] > *p || p[-shifts] > *p || p[shifts] > *p) continue;
      CoarseCandidate candidate;
      candidate.b_from_a = centred_similarity(scale, rotation_rad, i - t.shift_x + offset_x, j - t.shift_y + offset_y);
      candidate.rotation_rad = rotation_rad;
      candidate.scale = scale;
      candidate.score = *p;
      insert(candidate, rotation_step, scale_step, candidates);
    }
  }
}

}  // namespace

Status search_coarse(GrayView a, GrayView b, const OverlapParams& params, CoarseWorkspace& w,
                     CoarseCandidates& candidates) {
  candidates.clear();
  if (std::max(a.width, a.height) > coarse_max_side) return {StatusCode::invalid_argument, 1, a.width};
  if (b.width != a.width || b.height != a.height) return {StatusCode::image_size_changed, b.width, b.height};

  const double radius = 0.5 * std::sqrt(static_cast<double>(a.width * a.width + a.height * a.height));
  const int rotations = static_cast<int>(std::ceil(params.max_rotation_rad * radius / grid_step_px));
  const double rotation_step = rotations > 0 ? params.max_rotation_rad / rotations : 0;
  const int scales = static_cast<int>(std::ceil(det_log(params.max_scale) * radius / grid_step_px));
  const double scale_step = scales > 0 ? det_exp(det_log(params.max_scale) / scales) : 1;

  const Moments of_a = moments(a), of_b = moments(b);
  const bool sad = params.method == OverlapMethod::sad;
  prepare_b(b, of_b.mean, sad && of_b.stddev > 0 ? of_a.stddev / of_b.stddev : 1.0, w);
  double scale = params.predicted_scale;
  for (int k = 0; k < scales; ++k) scale /= scale_step;
  for (int k = -scales; k <= scales; ++k, scale *= scale_step) {
    for (int r = -rotations; r <= rotations; ++r) {
      const double rotation = params.predicted_rotation_rad + r * rotation_step;
      Template t;
      draw_template(a, of_a.mean, scale, rotation, t, w);
      // A tenth of slack: the grid of rotations and scales misses the true overlap by about that.
      const double needed = 0.9 * params.min_overlap * scale * scale;
      t.min_covered = static_cast<std::int32_t>(needed * (a.width - 1) * (a.height - 1));
      t.shift_x = largest_shift(t.width, b.width, params.min_overlap);
      t.shift_y = largest_shift(t.height, b.height, params.min_overlap);
      score_shifts(b, t, params.method, of_a.stddev, w);
      // Canvas and b are centred on each other up to half a pixel.
      const double offset_x = (b.width - t.width) / 2 - 0.5 * (b.width - t.width);
      const double offset_y = (b.height - t.height) / 2 - 0.5 * (b.height - t.height);
      collect_peaks(t, scale, rotation, offset_x, offset_y, rotation_step, scale_step, w, candidates);
    }
  }
  return {};
}

}  // namespace ilp
