#include "fsw/vision/stereo/cost/ncc_cost.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/stereo/cost/lanes.hpp"

namespace ilp {
namespace {

// Centred on zero the sums of products are exact as float.
constexpr int grey_centre = 128;

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
void load_left(const NccRows& rows, std::int32_t y, float* __restrict out) {
  const std::uint8_t* __restrict row = rows.left.row(clamped(y, rows.left.height));
  const std::int32_t width = rows.left.width;
  std::fill_n(out, rows.radius, static_cast<float>(row[0] - grey_centre));
  for (std::int32_t x = 0; x < width; ++x) out[rows.radius + x] = static_cast<float>(row[x] - grey_centre);
  std::fill_n(out + rows.radius + width, rows.radius, static_cast<float>(row[width - 1] - grey_centre));
}

/// Row y of the right image mirrored, its border repeated as far as any disparity reaches.
void load_right(const NccRows& rows, std::int32_t y, float* __restrict out) {
  const std::uint8_t* __restrict row = rows.right.row(clamped(y, rows.right.height));
  const std::int32_t width = rows.right.width;
  const std::int32_t length = mirrored_length(rows);
  const std::int32_t first = first_mirrored(rows);
  const std::int32_t begin = std::clamp(first - (width - 1), 0, length);
  const std::int32_t end = std::clamp(first + 1, begin, length);
  std::fill_n(out, begin, static_cast<float>(row[width - 1] - grey_centre));
  for (std::int32_t i = begin; i < end; ++i) out[i] = static_cast<float>(row[first - i] - grey_centre);
  std::fill_n(out + end, length - end, static_cast<float>(row[0] - grey_centre));
}

/// Moves the column sums of grey and its square one row down: row y_new in, row y_old out. Both rows are padded.
void update_columns(const float* __restrict row_new, const float* __restrict row_old, std::int32_t columns,
                    std::int32_t* __restrict sums, std::int32_t* __restrict squares) {
  for (std::int32_t i = 0; i < columns; ++i) {
    const float added = row_new[i] - row_old[i];
    sums[i] += static_cast<std::int32_t>(added);
    squares[i] += static_cast<std::int32_t>(added * (row_new[i] + row_old[i]));
  }
}

/// `out[i]` = columns[i] + ... + columns[i + 2 radius].
void sum_windows(const std::int32_t* __restrict columns, std::int32_t count, std::int32_t radius,
                 std::int32_t* __restrict out) {
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

/// Of a multiple of disparity_block the compiler knows it then.
std::int32_t whole(std::int32_t count) {
  return count / disparity_block * disparity_block;
}

void add_products(float left, const float* __restrict right, std::int32_t count, float* __restrict products) {
  for (std::int32_t d = 0; d < count; ++d) products[d] += left * right[d];
}

/// The update of a window's column for the next row: the row that enters below and the row that leaves above.
struct ColumnUpdate {
  float left_new, left_old;
  const float* right_new;
  const float* right_old;
  float* products;
};

template <typename Count>
void enter(const ColumnUpdate& column, Count blocks, float* __restrict window) {
  const std::int32_t count = whole(blocks);
  const float left_new = column.left_new;
  const float left_old = column.left_old;
  const float* __restrict right_new = column.right_new;
  const float* __restrict right_old = column.right_old;
  float* __restrict products = column.products;
  for (std::int32_t d = 0; d < count; ++d) {
    const float updated = products[d] + (left_new * right_new[d] - left_old * right_old[d]);
    products[d] = updated;
    window[d] += updated;
  }
}

/// Adds `column` to the window, computes its correlations, and removes `products_out`.
template <typename Count>
void enter_and_correlate(const ColumnUpdate& column, const float* __restrict products_out, Count blocks, float left_sum,
                         float left_inverse_norm, const float* __restrict right_mean,
                         const float* __restrict right_inverse_norm, float* __restrict window,
                         std::int16_t* __restrict ncc) {
  const std::int32_t count = whole(blocks);
  const float left_new = column.left_new;
  const float left_old = column.left_old;
  const float* __restrict right_new = column.right_new;
  const float* __restrict right_old = column.right_old;
  float* __restrict products = column.products;
  const float scale = left_inverse_norm * static_cast<float>(ncc_one);
  for (std::int32_t d = 0; d < count; ++d) {
    const float updated = products[d] + (left_new * right_new[d] - left_old * right_old[d]);
    products[d] = updated;
    const float sum = window[d] + updated;
    const float covariance = sum - left_sum * right_mean[d];
    ncc[d] = static_cast<std::int16_t>(static_cast<std::int32_t>(covariance * (scale * right_inverse_norm[d])));
    window[d] = sum - products_out[d];
  }
}

/// Costs of eight correlations.
[[gnu::always_inline]] inline lanes::I16 costs_of(lanes::I16 ncc) {
  constexpr int unit_bits = 8;
  static_assert(ncc_one == max_matching_cost << unit_bits);
  const lanes::I16 positive = ncc > 0 ? ncc : lanes::I16{};
  const lanes::I16 lost = std::int16_t{ncc_one + (1 << (unit_bits - 1))} - positive;
  return lost >> unit_bits;
}

template <typename Count>
void cost_of(const std::int16_t* ncc, const std::uint8_t* discount, Count count, std::uint8_t* cost) {
  static_assert(disparity_block == lanes::bytes);
  for (std::int32_t d = 0; d < count; d += lanes::bytes) {
    const lanes::I16 first = costs_of(lanes::load<lanes::I16>(ncc + d));
    const lanes::I16 second = costs_of(lanes::load<lanes::I16>(ncc + d + lanes::words));
    lanes::store(cost + d, lanes::bytes_of_words(first, second) - lanes::load<lanes::U8>(discount + d));
  }
}

/// The sums of the row above the first: the first update then adds row `radius`.
void start_columns(const NccRows& rows, NccWorkspace& w) {
  const std::int32_t radius = rows.radius;
  const std::int32_t columns = rows.left.width + 2 * radius;
  for (auto* sums : {&w.left_sums, &w.left_squares}) std::fill_n(sums->begin(), columns, 0);
  for (auto* sums : {&w.right_sums, &w.right_squares}) std::fill_n(sums->begin(), mirrored_length(rows), 0);
  w.left_old.fill(0.0F);
  w.right_old.fill(0.0F);
  for (std::int32_t y = -1 - radius; y < radius; ++y) {
    load_left(rows, y, w.left_new.data());
    load_right(rows, y, w.right_new.data());
    update_columns(w.left_new.data(), w.left_old.data(), columns, w.left_sums.data(), w.left_squares.data());
    update_columns(w.right_new.data(), w.right_old.data(), mirrored_length(rows), w.right_sums.data(),
                   w.right_squares.data());
  }
}

/// The products of the window above row `next_row`, of every run.
void start_products(const NccRows& rows, NccWorkspace& w) {
  const std::int32_t radius = rows.radius;
  const std::int32_t last_column = rows.left.width + 2 * radius - 1;
  float* products = w.column_products.data();
  for (const SearchRun& run : rows.search) {
    const std::int32_t entries = (run.end - run.begin + 2 * radius) * run.count;
    std::fill_n(products, entries, 0.0F);
    products += entries;
  }
  for (std::int32_t y = rows.next_row - 1 - radius; y < rows.next_row + radius; ++y) {
    load_left(rows, y, w.left_new.data());
    load_right(rows, y, w.right_new.data());
    products = w.column_products.data();
    for (const SearchRun& run : rows.search) {
      for (std::int32_t i = run.begin; i < run.end + 2 * radius; ++i, products += run.count) {
        add_products(w.left_new[static_cast<std::size_t>(i)], w.right_new.data() + (last_column - i + run.first),
                     run.count, products);
      }
    }
  }
}

/// A window moves along the columns of a run; `products` are the run's, those of the row above.
template <typename Count>
void correlate_run(const NccRows& rows, const SearchRun& run, Count count, float* products, NccWorkspace& w,
                   std::int16_t* ncc, std::uint8_t* cost) {
  const std::int32_t radius = rows.radius;
  const std::int32_t last_column = rows.left.width + 2 * radius - 1;
  float* window = w.window_products.data();
  std::fill_n(window, std::int32_t{count}, 0.0F);
  const auto column = [&](std::int32_t i) {
    const auto k = static_cast<std::size_t>(i);
    // Left column i - radius at disparity index 0 meets right column i - radius - min_disparity.
    const std::int32_t offset = last_column - i + run.first;
    return ColumnUpdate{w.left_new[k], w.left_old[k], w.right_new.data() + offset, w.right_old.data() + offset,
                        products + static_cast<std::ptrdiff_t>(i - run.begin) * count};
  };
  for (std::int32_t i = run.begin; i < run.begin + 2 * radius; ++i) enter(column(i), count, window);
  for (std::int32_t x = run.begin; x < run.end; ++x) {
    const auto k = static_cast<std::size_t>(x);
    const std::ptrdiff_t entry = static_cast<std::ptrdiff_t>(x) * rows.padded_disparities + run.first;
    const std::int32_t centre = last_column - radius - x + run.first;
    enter_and_correlate(column(x + 2 * radius), products + static_cast<std::ptrdiff_t>(x - run.begin) * count, count,
                        w.left_sum[k], w.left_inverse_norm[k], w.right_mean.data() + centre,
                        w.right_inverse_norm.data() + centre, window, ncc + entry);
    if (cost == nullptr) continue;
    if (w.left_inverse_norm[k] > 0) {
      cost_of(ncc + entry, w.right_discount.data() + centre, count, cost + entry);
    } else {
      // Nothing is known about a pixel outside the left image, so all disparities are equal.
      std::fill_n(cost + entry, std::int32_t{count}, std::uint8_t{0});
    }
  }
}

void correlate_row(NccRows& rows, const SearchRow& search, NccWorkspace& w, std::int16_t* ncc, std::uint8_t* cost,
                   float* variance) {
  if (rows.next_row == 0) start_columns(rows, w);
  if (rows.next_row == 0 || !(search == rows.search)) {
    rows.search = search;
    start_products(rows, w);
  }
  const std::int32_t radius = rows.radius;
  const std::int32_t columns = rows.left.width + 2 * radius;
  const std::int32_t y_new = rows.next_row + radius;
  const std::int32_t y_old = rows.next_row - radius - 1;
  load_left(rows, y_new, w.left_new.data());
  load_left(rows, y_old, w.left_old.data());
  load_right(rows, y_new, w.right_new.data());
  load_right(rows, y_old, w.right_old.data());
  update_columns(w.left_new.data(), w.left_old.data(), columns, w.left_sums.data(), w.left_squares.data());
  update_columns(w.right_new.data(), w.right_old.data(), mirrored_length(rows), w.right_sums.data(),
                 w.right_squares.data());
  compute_moments(rows, w, variance);

  float* products = w.column_products.data();
  for (const SearchRun& run : rows.search) {
    with_known_count(run.count, [&](auto count) { correlate_run(rows, run, count, products, w, ncc, cost); });
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
