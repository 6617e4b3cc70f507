#include "fsw/vision/stereo/cost/ncc_cost.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/stereo/cost/lanes.hpp"

namespace ilp {
namespace {

// Centred on zero the sums of products are exact as float.
constexpr std::uint8_t grey_centre = 128;

std::int32_t clamped(std::int32_t i, std::int32_t size) {
  return std::clamp(i, 0, size - 1);
}

std::int32_t mirrored_length(const NccRows& rows) {
  return rows.left.width + 2 * rows.radius + rows.padded_disparities;
}

/// First right column in the mirrored arrays: the counterpart of the last left column at the smallest disparity.
std::int32_t first_mirrored(const NccRows& rows) {
  return rows.left.width - 1 + rows.radius - rows.min_disparity;
}

/// Row y of the left image, its border repeated `radius` times.
void load_left(const NccRows& rows, std::int32_t y, std::uint8_t* out) {
  const std::uint8_t* row = rows.left.row(clamped(y, rows.left.height));
  const std::int32_t width = rows.left.width;
  std::fill_n(out, rows.radius, row[0]);
  std::copy_n(row, width, out + rows.radius);
  std::fill_n(out + rows.radius + width, rows.radius, row[width - 1]);
}

/// Row y of the right image mirrored, its border repeated as far as any disparity reaches.
void load_right(const NccRows& rows, std::int32_t y, std::uint8_t* __restrict out) {
  const std::uint8_t* __restrict row = rows.right.row(clamped(y, rows.right.height));
  const std::int32_t width = rows.right.width;
  const std::int32_t length = mirrored_length(rows);
  const std::int32_t first = first_mirrored(rows);
  const std::int32_t begin = std::clamp(first - (width - 1), 0, length);
  const std::int32_t end = std::clamp(first + 1, begin, length);
  std::fill_n(out, begin, row[width - 1]);
  for (std::int32_t i = begin; i < end; ++i) out[i] = row[first - i];
  std::fill_n(out + end, length - end, row[0]);
}

/// Two centred grey values as 16 bits each.
std::int32_t pair_of(std::int32_t low, std::int32_t high) {
  return static_cast<std::int32_t>((static_cast<std::uint32_t>(low) & 0xFFFFU) | static_cast<std::uint32_t>(high)
                                                                                     << 16U);
}

/// `pairs` of two rows; the second is multiplied by `sign`.
template <int sign>
void make_pairs(const std::uint8_t* __restrict first, const std::uint8_t* __restrict second, std::int32_t count,
                std::int32_t* __restrict pairs) {
  for (std::int32_t i = 0; i < count; ++i) {
    pairs[i] = pair_of(first[i] - grey_centre, sign * (second[i] - grey_centre));
  }
}

/// Moves the column sums of centred grey and its square one row down: row y_new in, row y_old out. All are padded.
void update_columns(const std::uint8_t* __restrict row_new, const std::uint8_t* __restrict row_old,
                    std::int32_t columns, std::int32_t* __restrict sums, std::int32_t* __restrict squares) {
  for (std::int32_t i = 0; i < columns; ++i) {
    const std::int32_t added = row_new[i] - row_old[i];
    sums[i] += added;
    squares[i] += added * (row_new[i] + row_old[i] - 2 * grey_centre);
  }
}

/// `out[i]` = columns[i] + ... + columns[i + 2 radius].
void sum_windows(const std::int32_t* __restrict columns, std::int32_t count, std::int32_t radius,
                 std::int32_t* __restrict out) {
  if (radius == 2) {
    for (std::int32_t i = 0; i < count; ++i) {
      out[i] = columns[i] + columns[i + 1] + columns[i + 2] + columns[i + 3] + columns[i + 4];
    }
    return;
  }
  for (std::int32_t i = 0; i < count; ++i) out[i] = columns[i] + columns[i + 1] + columns[i + 2];
  for (std::int32_t k = 3; k <= 2 * radius; ++k) {
    for (std::int32_t i = 0; i < count; ++i) out[i] += columns[i + k];
  }
}

struct Window {
  float inverse_area;
  float damping;
};

float deviation_of(float sum, std::int32_t squares, float inverse_area) {
  const float deviation = static_cast<float>(squares) - sum * sum * inverse_area;
  return deviation > 0 ? deviation : 0;
}

void left_moments(const std::int32_t* __restrict sums, const std::int32_t* __restrict squares,
                  const std::uint8_t* __restrict valid, std::int32_t count, Window window, float* __restrict sum,
                  float* __restrict inverse_norm, float* __restrict variance) {
  for (std::int32_t x = 0; x < count; ++x) {
    sum[x] = static_cast<float>(sums[x]);
    const float deviation = deviation_of(sum[x], squares[x], window.inverse_area);
    const float inverse = 1.0F / std::sqrt(deviation + window.damping);
    // A zero norm makes the correlation zero: invalid pixels need no branch later.
    inverse_norm[x] = valid[x] != 0 ? inverse : 0.0F;
    variance[x] = deviation * window.inverse_area;
  }
}

void right_moments(const std::int32_t* __restrict sums, const std::int32_t* __restrict squares,
                   const std::uint8_t* __restrict usable, std::int32_t count, Window window, float* __restrict mean,
                   float* __restrict inverse_norm) {
  for (std::int32_t i = 0; i < count; ++i) {
    const auto sum = static_cast<float>(sums[i]);
    mean[i] = sum * window.inverse_area;
    const float inverse = 1.0F / std::sqrt(deviation_of(sum, squares[i], window.inverse_area) + window.damping);
    inverse_norm[i] = usable[i] != 0 ? inverse : 0.0F;
  }
}

/// 1 where the mirrored pixel is in the right image and its mask, for `count` pixels from mirrored index `radius`.
void find_usable(const NccRows& rows, std::int32_t count, std::uint8_t* __restrict usable) {
  const std::uint8_t* valid = rows.right_valid.row(rows.next_row);
  const std::int32_t first = first_mirrored(rows) - rows.radius;
  const std::int32_t begin = std::clamp(first - (rows.right.width - 1), 0, count);
  const std::int32_t end = std::clamp(first + 1, begin, count);
  std::fill_n(usable, begin, std::uint8_t{0});
  for (std::int32_t i = begin; i < end; ++i) usable[i] = valid[first - i] != 0 ? 1 : 0;
  std::fill_n(usable + end, count - end, std::uint8_t{0});
}

void compute_moments(const NccRows& rows, NccWorkspace& w, float* variance) {
  const std::int32_t radius = rows.radius;
  const Window window{1.0F / static_cast<float>((2 * radius + 1) * (2 * radius + 1)), rows.damping};
  const std::int32_t width = rows.left.width;
  sum_windows(w.left_sums.data(), width, radius, w.window_sums.data());
  sum_windows(w.left_squares.data(), width, radius, w.window_squares.data());
  left_moments(w.window_sums.data(), w.window_squares.data(), rows.left_valid.row(rows.next_row), width, window,
               w.left_sum.data(), w.left_inverse_norm.data(), variance);
  const std::int32_t count = mirrored_length(rows) - 2 * radius;
  sum_windows(w.right_sums.data(), count, radius, w.window_sums.data());
  sum_windows(w.right_squares.data(), count, radius, w.window_squares.data());
  find_usable(rows, count, w.right_usable.data());
  right_moments(w.window_sums.data(), w.window_squares.data(), w.right_usable.data(), count, window,
                w.right_mean.data() + radius, w.right_inverse_norm.data() + radius);
  const auto discount = static_cast<std::uint8_t>(max_matching_cost - rows.out_of_view_cost);
  const auto margin = static_cast<std::size_t>(radius);
  for (std::int32_t i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    w.right_discount[k + margin] = w.right_usable[k] != 0 ? std::uint8_t{0} : discount;
  }
}

/// What the correlations of a run of a row are made of; pointers are for the run's first column and disparity.
struct RunOfRow {
  std::int32_t columns, count, radius;
  std::int32_t first_seen;  ///< column whose counterpart at the first disparity is the right image's first column
  std::ptrdiff_t padded;
  // Left columns count from the window's border; right ones fall while they grow, and grow with disparity.
  const std::int32_t *left, *right;
  std::int32_t* products;  ///< of the row above
  const float *left_sum, *left_inverse_norm, *right_mean, *right_inverse_norm;
  const std::uint8_t* right_discount;
  std::int16_t* ncc;
  std::uint8_t* cost;  ///< may be null
};

RunOfRow run_of_row(const NccRows& rows, const SearchRun& run, std::int32_t* products, NccWorkspace& w,
                    std::int16_t* ncc, std::uint8_t* cost) {
  // Left column i - radius at disparity index 0 meets right column i - radius - min_disparity.
  const std::int32_t right = rows.left.width + 2 * rows.radius - 1 - run.begin + run.first;
  const std::int32_t centre = right - rows.radius;
  const std::ptrdiff_t entry = static_cast<std::ptrdiff_t>(run.begin) * rows.padded_disparities + run.first;
  return {run.end - run.begin,
          run.count,
          rows.radius,
          rows.min_disparity + run.first - run.begin,
          rows.padded_disparities,
          w.left_pairs.data() + run.begin,
          w.right_pairs.data() + right,
          products,
          w.left_sum.data() + run.begin,
          w.left_inverse_norm.data() + run.begin,
          w.right_mean.data() + centre,
          w.right_inverse_norm.data() + centre,
          w.right_discount.data() + centre,
          ncc == nullptr ? nullptr : ncc + entry,
          cost == nullptr ? nullptr : cost + entry};
}

namespace with_16_bytes {
#define ILP_NCC_BYTES 16
#include "fsw/vision/stereo/cost/correlation_steps.inc"
#undef ILP_NCC_BYTES
}  // namespace with_16_bytes

#if defined(__x86_64__) && !defined(__clang__) && !defined(__AVX2__)
#define ILP_NCC_WITH_32_BYTES
#pragma GCC push_options
#pragma GCC target("avx2")
namespace with_32_bytes {
#define ILP_NCC_BYTES 32
#include "fsw/vision/stereo/cost/correlation_steps.inc"
#undef ILP_NCC_BYTES
}  // namespace with_32_bytes
#pragma GCC pop_options
#endif

void correlate(const RunOfRow& run) {
#ifdef ILP_NCC_WITH_32_BYTES
  if (vectors_in_use() == VectorWidth::bytes32) return with_32_bytes::correlate(run);
#endif
  with_16_bytes::correlate(run);
}

void add_products(const RunOfRow& run, bool is_first) {
#ifdef ILP_NCC_WITH_32_BYTES
  if (vectors_in_use() == VectorWidth::bytes32) return with_32_bytes::add_products(run, is_first);
#endif
  with_16_bytes::add_products(run, is_first);
}

/// The sums of the window above row `next_row`.
void start_columns(const NccRows& rows, NccWorkspace& w) {
  const std::int32_t radius = rows.radius;
  const std::int32_t columns = rows.left.width + 2 * radius;
  for (auto* sums : {&w.left_sums, &w.left_squares}) std::fill_n(sums->begin(), columns, 0);
  for (auto* sums : {&w.right_sums, &w.right_squares}) std::fill_n(sums->begin(), mirrored_length(rows), 0);
  w.left_old.fill(grey_centre);
  w.right_old.fill(grey_centre);
  for (std::int32_t y = rows.next_row - 1 - radius; y < rows.next_row + radius; ++y) {
    load_left(rows, y, w.left_new.data());
    load_right(rows, y, w.right_new.data());
    update_columns(w.left_new.data(), w.left_old.data(), columns, w.left_sums.data(), w.left_squares.data());
    update_columns(w.right_new.data(), w.right_old.data(), mirrored_length(rows), w.right_sums.data(),
                   w.right_squares.data());
  }
}

/// The products of the window above row `next_row`, of every run. Rows are added in pairs.
void start_products(const NccRows& rows, NccWorkspace& w) {
  const std::int32_t columns = rows.left.width + 2 * rows.radius;
  const std::int32_t end = rows.next_row + rows.radius;
  const std::int32_t begin = end - 1 - 2 * rows.radius;
  for (std::int32_t y = begin; y < end; y += 2) {
    load_left(rows, y, w.left_new.data());
    load_right(rows, y, w.right_new.data());
    if (y + 1 < end) {
      load_left(rows, y + 1, w.left_old.data());
      load_right(rows, y + 1, w.right_old.data());
    } else {
      w.left_old.fill(grey_centre);
    }
    make_pairs<1>(w.left_new.data(), w.left_old.data(), columns, w.left_pairs.data());
    make_pairs<1>(w.right_new.data(), w.right_old.data(), mirrored_length(rows), w.right_pairs.data());
    std::int32_t* products = w.column_products.data();
    for (const SearchRun& run : rows.search) {
      add_products(run_of_row(rows, run, products, w, nullptr, nullptr), y == begin);
      products += static_cast<std::ptrdiff_t>(run.end - run.begin + 2 * rows.radius) * run.count;
    }
  }
}

/// Whether the sums had to begin again.
bool begin_columns(NccRows& rows, NccWorkspace& w) {
  const bool begins = rows.next_row == 0 || !rows.begun;
  if (begins) start_columns(rows, w);
  rows.begun = true;
  return begins;
}

/// The grey rows that enter the window of row `next_row` and leave it, and the sums of its columns.
void advance_columns(const NccRows& rows, NccWorkspace& w) {
  const std::int32_t y_new = rows.next_row + rows.radius;
  const std::int32_t y_old = rows.next_row - rows.radius - 1;
  load_left(rows, y_new, w.left_new.data());
  load_left(rows, y_old, w.left_old.data());
  load_right(rows, y_new, w.right_new.data());
  load_right(rows, y_old, w.right_old.data());
  update_columns(w.left_new.data(), w.left_old.data(), rows.left.width + 2 * rows.radius, w.left_sums.data(),
                 w.left_squares.data());
  update_columns(w.right_new.data(), w.right_old.data(), mirrored_length(rows), w.right_sums.data(),
                 w.right_squares.data());
}

void correlate_row(NccRows& rows, const SearchRow& search, NccWorkspace& w, std::int16_t* ncc, std::uint8_t* cost,
                   float* variance) {
  if (begin_columns(rows, w) || !(search == rows.search)) {
    rows.search = search;
    start_products(rows, w);
  }
  const std::int32_t radius = rows.radius;
  advance_columns(rows, w);
  make_pairs<-1>(w.left_new.data(), w.left_old.data(), rows.left.width + 2 * radius, w.left_pairs.data());
  make_pairs<1>(w.right_new.data(), w.right_old.data(), mirrored_length(rows), w.right_pairs.data());
  compute_moments(rows, w, variance);

  std::int32_t* products = w.column_products.data();
  for (const SearchRun& run : rows.search) {
    correlate(run_of_row(rows, run, products, w, ncc, cost));
    products += static_cast<std::ptrdiff_t>(run.end - run.begin + 2 * radius) * run.count;
  }
  ++rows.next_row;
}

}  // namespace

void compute_ncc_row(NccRows& rows, const SearchRow& search, NccWorkspace& w, std::int16_t* ncc, std::uint8_t* cost,
                     float* variance) {
  with_widest_vectors([&] { correlate_row(rows, search, w, ncc, cost, variance); });
}

}  // namespace ilp
