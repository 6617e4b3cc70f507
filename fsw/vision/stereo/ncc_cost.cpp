#include "fsw/vision/stereo/ncc_cost.hpp"

#include <algorithm>
#include <cmath>

namespace ilp {
namespace {

// Centred on zero the products stay small enough for exact conversion to float.
constexpr int grey_centre = 128;

std::int32_t clamped(std::int32_t i, std::int32_t size) {
  return std::clamp(i, 0, size - 1);
}

std::int32_t mirrored_length(const NccRows& rows) {
  return rows.left.width + 2 * rows.radius + rows.padded_disparities;
}

/// Right column that stands first in the mirrored arrays: where the last left column looks for the smallest disparity.
std::int32_t first_mirrored(const NccRows& rows) {
  return rows.left.width - 1 + rows.radius - rows.min_disparity;
}

/// Row y of the left image, its border repeated `radius` times.
void load_left(const NccRows& rows, std::int32_t y, std::int16_t* __restrict out) {
  const std::uint8_t* __restrict row = rows.left.row(clamped(y, rows.left.height));
  const std::int32_t width = rows.left.width;
  std::fill_n(out, rows.radius, static_cast<std::int16_t>(row[0] - grey_centre));
  for (std::int32_t x = 0; x < width; ++x) out[rows.radius + x] = static_cast<std::int16_t>(row[x] - grey_centre);
  std::fill_n(out + rows.radius + width, rows.radius, static_cast<std::int16_t>(row[width - 1] - grey_centre));
}

/// Row y of the right image mirrored, its border repeated as far as any disparity reaches.
void load_right(const NccRows& rows, std::int32_t y, std::int16_t* __restrict out) {
  const std::uint8_t* __restrict row = rows.right.row(clamped(y, rows.right.height));
  const std::int32_t width = rows.right.width;
  const std::int32_t length = mirrored_length(rows);
  const std::int32_t first = first_mirrored(rows);
  const std::int32_t begin = std::clamp(first - (width - 1), 0, length);
  const std::int32_t end = std::clamp(first + 1, begin, length);
  std::fill_n(out, begin, static_cast<std::int16_t>(row[width - 1] - grey_centre));
  for (std::int32_t i = begin; i < end; ++i) out[i] = static_cast<std::int16_t>(row[first - i] - grey_centre);
  std::fill_n(out + end, length - end, static_cast<std::int16_t>(row[0] - grey_centre));
}

/// Moves the column sums of grey and its square one row down: row y_new in, row y_old out. Both rows are padded.
void update_columns(const std::int16_t* __restrict row_new, const std::int16_t* __restrict row_old,
                    std::int32_t columns, std::int32_t* __restrict sums, std::int32_t* __restrict squares) {
  for (std::int32_t i = 0; i < columns; ++i) {
    sums[i] += row_new[i] - row_old[i];
    squares[i] += row_new[i] * row_new[i] - row_old[i] * row_old[i];
  }
}

struct WindowMoments {
  float sum;
  float deviation;  ///< sum of squared deviations from the mean
};

/// Moves a window along the column sums; `use(x, moments)` for every pixel.
template <typename Use>
void for_each_window(std::int32_t width, std::int32_t radius, const std::int32_t* sums, const std::int32_t* squares,
                     Use use) {
  const float inverse_area = 1.0F / static_cast<float>((2 * radius + 1) * (2 * radius + 1));
  std::int32_t sum = 0;
  std::int32_t square = 0;
  for (std::int32_t i = 0; i < 2 * radius; ++i) {
    sum += sums[i];
    square += squares[i];
  }
  for (std::int32_t x = 0; x < width; ++x) {
    sum += sums[x + 2 * radius];
    square += squares[x + 2 * radius];
    const auto s = static_cast<float>(sum);
    use(x, WindowMoments{s, std::max(0.0F, static_cast<float>(square) - s * s * inverse_area)});
    sum -= sums[x];
    square -= squares[x];
  }
}

void compute_moments(const NccRows& rows, NccWorkspace& w, float* variance) {
  const std::int32_t radius = rows.radius;
  const float inverse_area = 1.0F / static_cast<float>((2 * radius + 1) * (2 * radius + 1));
  const std::uint8_t* left_valid = rows.left_valid.row(rows.next_row);
  const std::uint8_t* right_valid = rows.right_valid.row(rows.next_row);
  for_each_window(rows.left.width, radius, w.left_sums.data(), w.left_squares.data(),
                  [&](std::int32_t x, const WindowMoments& m) {
                    w.left_sum[static_cast<std::size_t>(x)] = m.sum;
                    // A zero norm makes the correlation zero: invalid pixels need no branch later.
                    w.left_inverse_norm[static_cast<std::size_t>(x)] =
                        left_valid[x] != 0 ? 1.0F / std::sqrt(m.deviation + rows.damping) : 0.0F;
                    variance[x] = m.deviation * inverse_area;
                  });
  const std::int32_t first = first_mirrored(rows);
  for_each_window(mirrored_length(rows) - 2 * radius, radius, w.right_sums.data(), w.right_squares.data(),
                  [&](std::int32_t i, const WindowMoments& m) {
                    const auto k = static_cast<std::size_t>(i + radius);
                    const std::int32_t p = first - i - radius;
                    const bool usable = p >= 0 && p < rows.right.width && right_valid[p] != 0;
                    w.right_mean[k] = m.sum * inverse_area;
                    w.right_inverse_norm[k] = usable ? 1.0F / std::sqrt(m.deviation + rows.damping) : 0.0F;
                    w.right_discount[k] =
                        usable ? std::uint8_t{0} : static_cast<std::uint8_t>(max_matching_cost - rows.out_of_view_cost);
                  });
}

void add_products(std::int16_t left, const std::int16_t* __restrict right, std::int32_t count,
                  std::int32_t* __restrict products) {
  for (std::int32_t d = 0; d < count; ++d) products[d] += left * right[d];
}

/// The window's right column comes in with its rows brought up to date, its left column goes out.
void slide(std::int16_t left_new, const std::int16_t* __restrict right_new, std::int16_t left_old,
           const std::int16_t* __restrict right_old, std::int32_t count, std::int32_t* __restrict column,
           std::int32_t* __restrict window) {
  for (std::int32_t d = 0; d < count; ++d) {
    const std::int32_t updated = column[d] + left_new * right_new[d] - left_old * right_old[d];
    column[d] = updated;
    window[d] += updated;
  }
}

void correlate(const std::int32_t* __restrict column_out, std::int32_t count, float left_sum, float left_inverse_norm,
               const float* __restrict right_mean, const float* __restrict right_inverse_norm,
               const std::uint8_t* __restrict discount, std::int32_t* __restrict window, std::int16_t* __restrict ncc,
               std::uint8_t* __restrict cost) {
  const float scale = left_inverse_norm * static_cast<float>(ncc_one);
  for (std::int32_t d = 0; d < count; ++d) {
    const float covariance = static_cast<float>(window[d]) - left_sum * right_mean[d];
    ncc[d] = static_cast<std::int16_t>(static_cast<std::int32_t>(covariance * (scale * right_inverse_norm[d])));
    window[d] -= column_out[d];
  }
  constexpr std::int16_t unit = ncc_one / max_matching_cost;
  for (std::int32_t d = 0; d < count; ++d) {
    const std::int16_t positive = std::max<std::int16_t>(ncc[d], 0);
    const auto lost = static_cast<std::int16_t>(ncc_one + unit / 2 - positive);
    const auto full = static_cast<std::uint8_t>(static_cast<std::uint16_t>(lost) / static_cast<std::uint16_t>(unit));
    cost[d] = static_cast<std::uint8_t>(full - discount[d]);
  }
}

/// The sums of the row above the first: the first update then brings in row `radius`.
void start_columns(const NccRows& rows, NccWorkspace& w) {
  const std::int32_t radius = rows.radius;
  const std::int32_t columns = rows.left.width + 2 * radius;
  for (auto* sums : {&w.left_sums, &w.left_squares}) std::fill_n(sums->begin(), columns, 0);
  for (auto* sums : {&w.right_sums, &w.right_squares}) std::fill_n(sums->begin(), mirrored_length(rows), 0);
  w.left_old.fill(0);
  w.right_old.fill(0);
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
  std::int32_t* products = w.column_products.data();
  for (const SearchRun& run : rows.search) {
    const std::int32_t entries = (run.end - run.begin + 2 * radius) * run.count;
    std::fill_n(products, entries, 0);
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
void correlate_run(const NccRows& rows, const SearchRun& run, std::int32_t* products, NccWorkspace& w,
                   std::int16_t* ncc, std::uint8_t* cost) {
  const std::int32_t radius = rows.radius;
  const std::int32_t last_column = rows.left.width + 2 * radius - 1;
  std::int32_t* window = w.window_products.data();
  std::fill_n(window, run.count, 0);
  const std::int32_t* column_out = products;
  for (std::int32_t i = run.begin; i < run.end + 2 * radius; ++i, products += run.count) {
    const auto k = static_cast<std::size_t>(i);
    // Left column i - radius at disparity index 0 meets right column i - radius - min_disparity.
    const std::int32_t offset = last_column - i + run.first;
    slide(w.left_new[k], w.right_new.data() + offset, w.left_old[k], w.right_old.data() + offset, run.count, products,
          window);
    const std::int32_t x = i - 2 * radius;
    if (x < run.begin) continue;
    const std::ptrdiff_t entry = static_cast<std::ptrdiff_t>(x) * rows.padded_disparities + run.first;
    const std::int32_t centre = offset + radius;
    correlate(column_out, run.count, w.left_sum[static_cast<std::size_t>(x)],
              w.left_inverse_norm[static_cast<std::size_t>(x)], w.right_mean.data() + centre,
              w.right_inverse_norm.data() + centre, w.right_discount.data() + centre, window, ncc + entry,
              cost + entry);
    column_out += run.count;
    // Nothing is known of a pixel outside the left image: no disparity is better than another.
    if (!(w.left_inverse_norm[static_cast<std::size_t>(x)] > 0)) std::fill_n(cost + entry, run.count, std::uint8_t{0});
  }
}

}  // namespace

void compute_ncc_row(NccRows& rows, const SearchRow& search, NccWorkspace& w, std::int16_t* ncc, std::uint8_t* cost,
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

  std::int32_t* products = w.column_products.data();
  for (const SearchRun& run : rows.search) {
    correlate_run(rows, run, products, w, ncc, cost);
    products += static_cast<std::ptrdiff_t>(run.end - run.begin + 2 * radius) * run.count;
  }
  ++rows.next_row;
}

}  // namespace ilp
