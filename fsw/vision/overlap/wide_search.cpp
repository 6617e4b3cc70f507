#include "fsw/vision/overlap/wide_search.hpp"

#include <algorithm>
#include <cmath>

#include "cfg/limits.hpp"
#include "fsw/base/argument.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/vision/image/sampling.hpp"

namespace ilp {
namespace {

// Neighbouring rotations and scales differ by this much at the corners: half of it is the largest misfit.
constexpr double wide_step_px = 5.2;
// Around each pixel the mean and the contrast are taken over a square of 2 reach + 1 px.
constexpr std::int32_t reach_px = 12;
constexpr double target_mean = 128, target_stddev = 32;
// A pixel in a square of less contrast, in grey levels, is blank.
constexpr double blank_stddev = 0.75;
// Peaks nearer to each other than this share of the longer side are one peak.
constexpr double wide_peak_share = 0.06;
constexpr std::int32_t wide_vector_px = 16;

static_assert(wide_canvas_stride % wide_vector_px == 0 && wide_canvas_stride >= wide_canvas_side + wide_vector_px);
static_assert(wide_plane_stride >= wide_max_side / wide_sample_px + wide_vector_px);
static_assert(wide_max_shifts <= (1 << wide_shift_bits));
// (36 n)^2 fits 32 bits, and the score with the shift does too.
static_assert(wide_unrelated * wide_plane_rows * wide_plane_rows < 65536);
static_assert((wide_unrelated * wide_unrelated * wide_plane_rows * wide_plane_rows) < (1 << (31 - wide_shift_bits)));

/// Sums of grey values and squares of every column, over the rows around the present one.
class ColumnSums {
 public:
  explicit ColumnSums(GrayView image) : image_(image) {
    for (std::int32_t y = 0; y < std::min(reach_px, image.height); ++y) add(y, 1);
  }
  /// Goes on to row `y`; rows are taken in their order.
  void move_to(std::int32_t y) {
    if (y + reach_px < image_.height) add(y + reach_px, 1);
    if (y - reach_px - 1 >= 0) add(y - reach_px - 1, -1);
    rows_ = std::min(y + reach_px, image_.height - 1) - std::max(y - reach_px, 0) + 1;
  }
  [[nodiscard]] std::int32_t sum(std::int32_t x) const { return sums_[static_cast<std::size_t>(x)]; }
  [[nodiscard]] std::int32_t squares(std::int32_t x) const { return squares_[static_cast<std::size_t>(x)]; }
  [[nodiscard]] std::int32_t rows() const { return rows_; }

 private:
  void add(std::int32_t y, std::int32_t sign) {
    const std::uint8_t* const row = image_.row(y);
    for (std::int32_t x = 0; x < image_.width; ++x) {
      sums_[static_cast<std::size_t>(x)] += sign * row[x];
      squares_[static_cast<std::size_t>(x)] += sign * row[x] * row[x];
    }
  }

  GrayView image_;
  std::int32_t rows_ = 0;
  std::array<std::int32_t, wide_max_side> sums_{}, squares_{};
};

std::uint8_t normalised(std::int32_t value, double count, double sum, double squares) {
  const double mean = sum / count;
  const double stddev = std::sqrt(std::max(squares / count - mean * mean, 0.0));
  if (stddev < blank_stddev) return 0;
  const double scaled = std::floor(target_mean + target_stddev * (value - mean) / stddev + 0.5);
  return static_cast<std::uint8_t>(std::clamp(scaled, 1.0, 255.0));
}

/// Calls `put(x, y, value)` for every pixel of the image, brought to one local mean and contrast.
template <typename Put>
void normalise(GrayView image, const Put& put) {
  ColumnSums columns(image);
  for (std::int32_t y = 0; y < image.height; ++y) {
    columns.move_to(y);
    std::int32_t sum = 0, squares = 0;
    for (std::int32_t x = 0; x < std::min(reach_px, image.width); ++x) {
      sum += columns.sum(x);
      squares += columns.squares(x);
    }
    for (std::int32_t x = 0; x < image.width; ++x) {
      const std::int32_t last = x + reach_px, gone = x - reach_px - 1;
      if (last < image.width) {
        sum += columns.sum(last);
        squares += columns.squares(last);
      }
      if (gone >= 0) {
        sum -= columns.sum(gone);
        squares -= columns.squares(gone);
      }
      const std::int32_t wide = std::min(last, image.width - 1) - std::max(gone + 1, 0) + 1;
      put(x, y, normalised(image.at(x, y), wide * columns.rows(), sum, squares));
    }
  }
}

std::size_t place_in_a(std::int32_t x, std::int32_t y, std::int32_t stride) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(stride) + static_cast<std::size_t>(x);
}

std::size_t place_in_planes(std::int32_t x, std::int32_t y) {
  const std::int32_t plane = (y & 3) * wide_sample_px + (x & 3);
  const std::int32_t row = y >> 2, column = x >> 2;
  const std::size_t rows_before = static_cast<std::size_t>(plane) * wide_plane_rows + static_cast<std::size_t>(row);
  return rows_before * wide_plane_stride + static_cast<std::size_t>(column);
}

/// The middles of equal cells over a full turn, and over the scales in logarithms.
struct Attitude {
  double scale, rotation_rad;
};
Attitude attitude_of(const WidePlan& plan, std::int32_t pose) {
  const std::int32_t k = pose / plan.rotations, r = pose % plan.rotations;
  const double log_scale_step = 2 * det_log(coarse_max_scale) / plan.scales;
  return {det_exp((k - 0.5 * (plan.scales - 1)) * log_scale_step),
          (r - 0.5 * (plan.rotations - 1)) * (2 * pi / plan.rotations)};
}

// Beyond it less than the smallest overlap is covered, even if the other axis is covered in full.
std::int32_t widest_shift(double template_px, std::int32_t b_px, double min_overlap) {
  const double touching = 0.5 * (template_px + b_px);
  const double covered = 0.9 * min_overlap * std::min(template_px, static_cast<double>(b_px));
  return std::min(static_cast<std::int32_t>(std::min(touching - covered + 2, touching)),
                  wide_max_shifts / 2 * wide_shift_px - 2);
}

WidePose pose_of(const WidePlan& plan, std::int32_t number) {
  const Attitude attitude = attitude_of(plan, number);
  const double c = det_cos(attitude.rotation_rad), s = det_sin(attitude.rotation_rad);
  const double full_w = attitude.scale * (std::fabs(c) * plan.width + std::fabs(s) * plan.height);
  const double full_h = attitude.scale * (std::fabs(s) * plan.width + std::fabs(c) * plan.height);
  WidePose pose{};
  pose.columns = std::min(static_cast<std::int32_t>(std::ceil(full_w / wide_sample_px)), wide_canvas_side);
  pose.rows = std::min(static_cast<std::int32_t>(std::ceil(full_h / wide_sample_px)), wide_canvas_side);
  // From the canvas's centre to its first sample.
  const double u = -0.5 * wide_sample_px * (pose.columns - 1), v = -0.5 * wide_sample_px * (pose.rows - 1);
  pose.start_x = to_fixed((c * u + s * v) / attitude.scale + 0.5 * (plan.width - 1));
  pose.start_y = to_fixed((-s * u + c * v) / attitude.scale + 0.5 * (plan.height - 1));
  pose.step_x = to_fixed(wide_sample_px * c / attitude.scale);
  pose.step_y = to_fixed(-wide_sample_px * s / attitude.scale);
  const std::int32_t shift_x = widest_shift(full_w, plan.width, plan.min_overlap);
  const std::int32_t shift_y = widest_shift(full_h, plan.height, plan.min_overlap);
  pose.left = static_cast<std::int32_t>(std::floor(0.5 * (plan.width - 1) + u)) - shift_x;
  pose.top = static_cast<std::int32_t>(std::floor(0.5 * (plan.height - 1) + v)) - shift_y;
  pose.shifts_x = 2 * shift_x / wide_shift_px + 1;
  pose.shifts_y = 2 * shift_y / wide_shift_px + 1;
  // A tenth of tolerance: the grid of rotations and scales misses the true overlap by about that.
  const double needed = 0.9 * plan.min_overlap * attitude.scale * attitude.scale * (plan.width - 1) * (plan.height - 1);
  pose.min_count = std::max(static_cast<std::int32_t>(needed / (wide_sample_px * wide_sample_px)), 1);
  return pose;
}

/// Coordinates in a wrap around far outside of it, in the same way on every machine.
std::int32_t advanced(std::int32_t start, std::int32_t step, std::int32_t times) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(start) +
                                   static_cast<std::uint32_t>(step) * static_cast<std::uint32_t>(times));
}

std::uint8_t sample_of(GrayView a, std::int32_t x, std::int32_t y) {
  const bool inside = static_cast<std::uint32_t>(x) < static_cast<std::uint32_t>((a.width - 1) << 16) &&
                      static_cast<std::uint32_t>(y) < static_cast<std::uint32_t>((a.height - 1) << 16);
  if (!inside) return 0;
  const std::uint8_t* const upper = a.row(y >> 16) + (x >> 16);
  const std::uint8_t* const lower = upper + a.stride;
  if (upper[0] == 0 || upper[1] == 0 || lower[0] == 0 || lower[1] == 0) return 0;
  return sample_bilinear(a, x, y);
}

std::int32_t stride_of_a(std::int32_t width) {
  return (width + 3) / 4 * 4;
}

void mask_of_pixels(const std::uint8_t* pixels, std::size_t count, std::uint8_t* mask) {
  for (std::size_t i = 0; i < count; ++i) mask[i] = pixels[i] != 0 ? std::uint8_t{255} : std::uint8_t{0};
}

void draw(const WideInput& input, const WidePose& pose, WideWorkspace& w) {
  const GrayView a(input.a.data(), input.width, input.height, stride_of_a(input.width));
  for (std::int32_t j = 0; j < pose.rows; ++j) {
    std::uint8_t* const row = w.canvas.data() + std::ptrdiff_t{j} * wide_canvas_stride;
    const std::int32_t row_x = advanced(pose.start_x, -pose.step_y, j), row_y = advanced(pose.start_y, pose.step_x, j);
    for (std::int32_t i = 0; i < pose.columns; ++i) {
      row[i] = sample_of(a, advanced(row_x, pose.step_x, i), advanced(row_y, pose.step_y, i));
    }
    std::fill(row + pose.columns, row + wide_canvas_stride, std::uint8_t{0});
  }
  mask_of_pixels(w.canvas.data(), static_cast<std::size_t>(pose.rows) * wide_canvas_stride, w.canvas_mask.data());
}

/// The part of the canvas that lies over b, in samples.
struct Part {
  std::int32_t first_column, columns, first_row, rows;
};

struct Difference {
  std::int32_t sum = 0, count = 0;
};

struct Image {
  const std::uint8_t* pixels;
  const std::uint8_t* mask;
};

// The number of vectors per row is a constant, so that the compiler needs no remainder loop. Each image masks the
// other: where one has a pixel that does not count, neither adds anything.
template <std::int32_t Vectors>
Difference compare_rows(Image p, Image q, std::int32_t rows) {
  std::uint8_t counts[Vectors * wide_vector_px] = {};
  Difference result;
  for (std::int32_t y = 0; y < rows; ++y) {
    for (std::int32_t x = 0; x < Vectors * wide_vector_px; ++x) {
      const auto from_p = static_cast<std::uint8_t>(p.pixels[x] & q.mask[x]);
      const auto from_q = static_cast<std::uint8_t>(q.pixels[x] & p.mask[x]);
      result.sum += std::abs(static_cast<std::int32_t>(from_p) - static_cast<std::int32_t>(from_q));
    }
    for (std::int32_t x = 0; x < Vectors * wide_vector_px; ++x) {
      counts[x] = static_cast<std::uint8_t>(counts[x] + (p.mask[x] & q.mask[x] & 1));
    }
    p = {p.pixels + wide_canvas_stride, p.mask + wide_canvas_stride};
    q = {q.pixels + wide_plane_stride, q.mask + wide_plane_stride};
  }
  for (const std::uint8_t count : counts) result.count += count;
  return result;
}

Difference compare(Image canvas, Image plane, std::int32_t x, std::int32_t y, const Part& part) {
  const std::ptrdiff_t in_p = std::ptrdiff_t{part.first_row} * wide_canvas_stride + part.first_column;
  const std::ptrdiff_t in_q = std::ptrdiff_t{part.first_row + y} * wide_plane_stride + (part.first_column + x);
  const Image p{canvas.pixels + in_p, canvas.mask + in_p}, q{plane.pixels + in_q, plane.mask + in_q};
  switch ((part.columns + wide_vector_px - 1) / wide_vector_px) {
    case 1:
      return compare_rows<1>(p, q, part.rows);
    case 2:
      return compare_rows<2>(p, q, part.rows);
    default:
      return compare_rows<3>(p, q, part.rows);
  }
}

std::uint32_t score(const Difference& difference, std::int32_t min_count) {
  const std::int32_t better = wide_unrelated * difference.count - difference.sum;
  if (difference.count < min_count || better <= 0) return 0;
  const auto root = static_cast<std::uint32_t>(better);
  return root * root / static_cast<std::uint32_t>(difference.count);
}

std::uint32_t best_of_row(const WideInput& input, const WidePose& pose, std::int32_t iy, const WideWorkspace& w) {
  const std::int32_t y = pose.top + wide_shift_px * iy, down = y >> 2;
  const std::int32_t plane_rows = (input.height - (y & 3) + 3) >> 2;
  Part part{};
  part.first_row = std::max(-down, 0);
  part.rows = std::min(pose.rows, plane_rows - down) - part.first_row;
  if (part.rows <= 0) return 0;
  std::uint32_t best = 0;
  for (std::int32_t ix = 0; ix < pose.shifts_x; ++ix) {
    const std::int32_t x = pose.left + wide_shift_px * ix, right = x >> 2;
    const std::int32_t plane_columns = (input.width - (x & 3) + 3) >> 2;
    part.first_column = std::max(-right, 0);
    part.columns = std::min(pose.columns, plane_columns - right) - part.first_column;
    if (part.columns <= 0 || part.columns * part.rows < pose.min_count) continue;
    const std::ptrdiff_t plane =
        std::ptrdiff_t{(y & 3) * wide_sample_px + (x & 3)} * wide_plane_rows * wide_plane_stride;
    const Image b{input.b.data() + plane, w.b_mask.data() + plane};
    const std::uint32_t found =
        score(compare({w.canvas.data(), w.canvas_mask.data()}, b, right, down, part), pose.min_count);
    if (found != 0) best = std::max(best, found << wide_shift_bits | static_cast<std::uint32_t>(ix));
  }
  return best;
}

double distance_px(const CentredSimilarity& p, const CentredSimilarity& q, double side_px) {
  const double turn = std::sqrt((p.m_re - q.m_re) * (p.m_re - q.m_re) + (p.m_im - q.m_im) * (p.m_im - q.m_im));
  const double shift = std::sqrt((p.d_x - q.d_x) * (p.d_x - q.d_x) + (p.d_y - q.d_y) * (p.d_y - q.d_y));
  return 0.5 * side_px * turn + shift;
}

}  // namespace

Status prepare_wide_search(GrayView a, GrayView b, double min_overlap, WideInput& input, WidePlan& plan) {
  if (std::min(a.width, a.height) < limits::min_image_side / 2 || std::max(a.width, a.height) > wide_max_side) {
    return out_of_range(Argument::image_size, a.width);
  }
  if (b.width != a.width || b.height != a.height) return {StatusCode::image_size_changed, b.width, b.height};
  input = {};
  input.width = a.width;
  input.height = a.height;
  const std::int32_t stride = stride_of_a(a.width);
  normalise(a, [&](std::int32_t x, std::int32_t y, std::uint8_t value) { input.a[place_in_a(x, y, stride)] = value; });
  normalise(b, [&](std::int32_t x, std::int32_t y, std::uint8_t value) { input.b[place_in_planes(x, y)] = value; });
  plan = plan_wide_search(a.width, a.height, min_overlap);
  return {};
}

WidePlan plan_wide_search(std::int32_t width, std::int32_t height, double min_overlap) {
  const double radius = 0.5 * std::sqrt(static_cast<double>(width * width + height * height));
  WidePlan plan;
  plan.width = width;
  plan.height = height;
  plan.min_overlap = min_overlap;
  plan.rotations = static_cast<std::int32_t>(std::ceil(2 * pi * radius / wide_step_px));
  plan.scales = static_cast<std::int32_t>(std::ceil(2 * det_log(coarse_max_scale) * radius / wide_step_px));
  return plan;
}

// Blobs of a few pixels, moved between the images by less than the shifts that are searched, with noise and blank
// spots.
void make_wide_example(std::uint32_t number, WideInput& input) {
  Rng rng(number, 1);
  input = {};
  input.width = 64 + static_cast<std::int32_t>(rng.below(97));
  input.height = 64 + static_cast<std::int32_t>(rng.below(97));
  const std::int32_t stride = stride_of_a(input.width);
  const auto shift = static_cast<std::int32_t>(rng.below(16));
  // In every other one unrelated places differ by more than what counts.
  const std::uint32_t contrast = number / 2 % 2 == 0 ? 64 : 128;
  const auto value = [&](std::int32_t x, std::int32_t y) {
    if (rng.below(64) == 0) return std::uint8_t{0};
    const std::uint64_t blob = mix64(std::uint64_t{number} << 32U | static_cast<std::uint64_t>(x / 5 * 64 + y / 5));
    return static_cast<std::uint8_t>(60 + blob % contrast + rng.below(32));
  };
  for (std::int32_t y = 0; y < input.height; ++y) {
    for (std::int32_t x = 0; x < input.width; ++x) {
      input.a[place_in_a(x, y, stride)] = value(x, y);
      input.b[place_in_planes(x, y)] = value(x + shift, y);
    }
  }
  const WidePlan plan = plan_wide_search(input.width, input.height, 0.2 + 0.6 * rng.uniform());
  // Every other one has the job with the smallest turns at the scale of one.
  const std::int32_t job = plan.poses() / 2 / static_cast<std::int32_t>(wide_job_poses);
  const auto other = static_cast<std::int32_t>(rng.below(static_cast<std::uint32_t>(plan.jobs())));
  fill_wide_job(plan, number % 2 == 0 ? job : other, input);
}

void fill_wide_job(const WidePlan& plan, std::int32_t job, WideInput& input) {
  const std::int32_t first = job * static_cast<std::int32_t>(wide_job_poses);
  input.pose_count = std::clamp(plan.poses() - first, 0, static_cast<std::int32_t>(wide_job_poses));
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(wide_job_poses); ++i) {
    input.poses[static_cast<std::size_t>(i)] = i < input.pose_count ? pose_of(plan, first + i) : WidePose{};
  }
}

void search_wide_pose(const WideInput& input, std::size_t pose, WideWorkspace& workspace,
                      std::array<std::uint32_t, wide_max_shifts>& best) {
  best.fill(0);
  if (pose >= static_cast<std::size_t>(input.pose_count)) return;
  const WidePose& at = input.poses[pose];
  draw(input, at, workspace);
  mask_of_pixels(input.b.data(), input.b.size(), workspace.b_mask.data());
  for (std::int32_t iy = 0; iy < at.shifts_y; ++iy) {
    best[static_cast<std::size_t>(iy)] = best_of_row(input, at, iy, workspace);
  }
}

void collect_wide_peaks(const WidePlan& plan, std::int32_t job, const WideInput& input, const WideOutput& output,
                        CoarseCandidates& candidates) {
  const double side = std::max(plan.width, plan.height);
  for (std::int32_t i = 0; i < input.pose_count; ++i) {
    const WidePose& pose = input.poses[static_cast<std::size_t>(i)];
    const auto& best = output.best[static_cast<std::size_t>(i)];
    const Attitude attitude = attitude_of(plan, job * static_cast<std::int32_t>(wide_job_poses) + i);
    CoarseCandidate candidate;
    candidate.rotation_rad = attitude.rotation_rad;
    candidate.scale = attitude.scale;
    candidate.b_from_a = centred_similarity(attitude.scale, attitude.rotation_rad, 0, 0);
    for (std::int32_t iy = 1; iy + 1 < pose.shifts_y; ++iy) {
      const auto at = static_cast<std::size_t>(iy);
      const std::uint32_t here = best[at] >> wide_shift_bits;
      if (here == 0 || (candidates.full() && here <= candidates.back().score)) continue;
      if (best[at - 1] >> wide_shift_bits > here || best[at + 1] >> wide_shift_bits > here) continue;
      const auto ix = static_cast<std::int32_t>(best[at] & ((1U << wide_shift_bits) - 1));
      if (ix >= pose.shifts_x) continue;
      candidate.b_from_a.d_x =
          pose.left + wide_shift_px * ix + 0.5 * wide_sample_px * (pose.columns - 1) - 0.5 * (plan.width - 1);
      candidate.b_from_a.d_y =
          pose.top + wide_shift_px * iy + 0.5 * wide_sample_px * (pose.rows - 1) - 0.5 * (plan.height - 1);
      candidate.score = here;
      const auto same_peak = [&](const CoarseCandidate& known) {
        return distance_px(known.b_from_a, candidate.b_from_a, side) < wide_peak_share * side;
      };
      insert_peak(candidate, same_peak, candidates);
    }
  }
}

}  // namespace ilp
