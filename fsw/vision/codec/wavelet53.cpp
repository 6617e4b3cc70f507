#include "fsw/vision/codec/wavelet53.hpp"

#include <cstddef>
#include <cstring>

#include "fsw/base/vector_width.hpp"

// Lifting (T.800, F.4.8.2), with x the interleaved signal, d = x[2k+1] and s = x[2k] its high and low part:
//   d[k] = x[2k+1] - floor((x[2k] + x[2k+2]) / 2)
//   s[k] = x[2k] + floor((d[k-1] + d[k] + 2) / 4)
// Symmetric extension makes x[n] = x[n-2] and d[-1] = d[0]; a single sample is its own low band.

namespace ilp {
namespace {

using Image = ImageView<std::int32_t>;
using Mask = ImageView<std::uint8_t>;

void predict(const std::int32_t* odd, const std::int32_t* left, const std::int32_t* right, std::int32_t* high,
             std::int32_t n) {
  for (std::int32_t i = 0; i < n; ++i) high[i] = odd[i] - ((left[i] + right[i]) >> 1);
}

void update(const std::int32_t* even, const std::int32_t* before, const std::int32_t* after, std::int32_t* low,
            std::int32_t n) {
  for (std::int32_t i = 0; i < n; ++i) low[i] = even[i] + ((before[i] + after[i] + 2) >> 2);
}

/// The rows that a column's wavelet works on: low-pass rows come first in the transform, high-pass rows after them. At
/// the ends the nearest row replaces the missing one.
struct ColumnRows {
  std::int32_t count, lows, highs;

  explicit ColumnRows(std::int32_t n) : count(n), lows((n + 1) / 2), highs(n / 2) {}

  [[nodiscard]] std::int32_t even_below(std::int32_t k) const { return 2 * k + 2 < count ? 2 * k + 2 : 2 * k; }
  [[nodiscard]] std::int32_t high_before(std::int32_t k) const { return lows + (k > 0 ? k - 1 : 0); }
  [[nodiscard]] std::int32_t high_after(std::int32_t k) const { return lows + (k < highs ? k : highs - 1); }
};

void copy_row(Image from, Image to) {
  std::memcpy(to.row(0), from.row(0), static_cast<std::size_t>(from.width) * sizeof(std::int32_t));
}

// Whole rows at a time, so that the inner loops access contiguous memory.
void forward_columns(Image from, Image to) {
  const ColumnRows rows(from.height);
  const std::int32_t w = from.width;
  if (rows.highs == 0) return copy_row(from, to);
  for (std::int32_t k = 0; k < rows.highs; ++k) {
    predict(from.row(2 * k + 1), from.row(2 * k), from.row(rows.even_below(k)), to.row(rows.lows + k), w);
  }
  for (std::int32_t k = 0; k < rows.lows; ++k) {
    update(from.row(2 * k), to.row(rows.high_before(k)), to.row(rows.high_after(k)), to.row(k), w);
  }
}

void forward_row(const std::int32_t* x, std::int32_t* out, std::ptrdiff_t n) {
  const std::ptrdiff_t lows = (n + 1) / 2;
  const std::ptrdiff_t highs = n - lows;
  if (highs == 0) {
    out[0] = x[0];
    return;
  }
  std::int32_t* high = out + lows;
  const std::ptrdiff_t inner = n % 2 == 0 ? highs - 1 : highs;  // predictions with a right neighbour
  for (std::ptrdiff_t k = 0; k < inner; ++k) high[k] = x[2 * k + 1] - ((x[2 * k] + x[2 * k + 2]) >> 1);
  if (inner < highs) high[inner] = x[2 * inner + 1] - x[2 * inner];
  out[0] = x[0] + ((2 * high[0] + 2) >> 2);
  for (std::ptrdiff_t k = 1; k < highs; ++k) out[k] = x[2 * k] + ((high[k - 1] + high[k] + 2) >> 2);
  if (highs < lows && highs > 0) out[highs] = x[2 * highs] + ((2 * high[highs - 1] + 2) >> 2);
}

void undo_update(const std::int32_t* low, const std::int32_t* before, const std::int32_t* after, std::int32_t* even,
                 std::int32_t n) {
  for (std::int32_t i = 0; i < n; ++i) even[i] = low[i] - ((before[i] + after[i] + 2) >> 2);
}

void undo_predict(const std::int32_t* high, const std::int32_t* left, const std::int32_t* right, std::int32_t* odd,
                  std::int32_t n) {
  for (std::int32_t i = 0; i < n; ++i) odd[i] = high[i] + ((left[i] + right[i]) >> 1);
}

void inverse_columns(Image from, Image to) {
  const ColumnRows rows(from.height);
  const std::int32_t w = from.width;
  if (rows.highs == 0) return copy_row(from, to);
  for (std::int32_t k = 0; k < rows.lows; ++k) {
    undo_update(from.row(k), from.row(rows.high_before(k)), from.row(rows.high_after(k)), to.row(2 * k), w);
  }
  for (std::int32_t k = 0; k < rows.highs; ++k) {
    undo_predict(from.row(rows.lows + k), to.row(2 * k), to.row(rows.even_below(k)), to.row(2 * k + 1), w);
  }
}

void inverse_row(const std::int32_t* in, std::int32_t* x, std::ptrdiff_t n) {
  const std::ptrdiff_t lows = (n + 1) / 2;
  const std::ptrdiff_t highs = n - lows;
  if (highs == 0) {
    x[0] = in[0];
    return;
  }
  const std::int32_t* const high = in + lows;
  x[0] = in[0] - ((2 * high[0] + 2) >> 2);
  for (std::ptrdiff_t k = 1; k < highs; ++k) x[2 * k] = in[k] - ((high[k - 1] + high[k] + 2) >> 2);
  if (highs < lows) x[2 * highs] = in[highs] - ((2 * high[highs - 1] + 2) >> 2);
  const std::ptrdiff_t inner = n % 2 == 0 ? highs - 1 : highs;  // odd samples with a right neighbour
  for (std::ptrdiff_t k = 0; k < inner; ++k) x[2 * k + 1] = high[k] + ((x[2 * k] + x[2 * k + 2]) >> 1);
  if (inner < highs) x[2 * inner + 1] = high[inner] + x[2 * inner];
}

void mark_row(std::uint8_t* to, const std::uint8_t* from, std::int32_t n) {
  for (std::int32_t i = 0; i < n; ++i) to[i] |= from[i];
}

// Sample 2k is rebuilt from s[k], d[k-1], d[k]; sample 2k+1 from d[k] and the samples 2k and 2k+2. So s[k] is needed by
// 2k-1 ... 2k+1 and d[k] by 2k-1 ... 2k+3.
void mask_columns(Mask from, Mask to) {
  const std::int32_t n = from.height;
  const std::int32_t lows = (n + 1) / 2;
  for (std::int32_t band_row = 0; band_row < n; ++band_row) {
    const bool is_low = band_row < lows;
    const std::int32_t first = is_low ? 2 * band_row - 1 : 2 * (band_row - lows) - 1;
    const std::int32_t last = is_low ? first + 2 : first + 4;
    std::uint8_t* out = to.row(band_row);
    std::memset(out, 0, static_cast<std::size_t>(from.width));
    for (std::int32_t y = first < 0 ? 0 : first; y <= last && y < n; ++y) mark_row(out, from.row(y), from.width);
  }
}

std::uint8_t any_of(const std::uint8_t* m, std::ptrdiff_t first, std::ptrdiff_t last, std::ptrdiff_t n) {
  unsigned any = 0;
  for (std::ptrdiff_t i = first < 0 ? 0 : first; i <= last && i < n; ++i) any |= m[i];
  return static_cast<std::uint8_t>(any);
}

void mask_row(const std::uint8_t* m, std::uint8_t* out, std::ptrdiff_t n) {
  const std::ptrdiff_t lows = (n + 1) / 2;
  const std::ptrdiff_t highs = n - lows;
  std::uint8_t* high = out + lows;
  // All neighbours of a sample k exist for 0 < k < inner.
  const std::ptrdiff_t inner = (n - 3) / 2;
  const auto at_end = [&](std::ptrdiff_t k) {
    if (k < lows) out[k] = any_of(m, 2 * k - 1, 2 * k + 1, n);
    if (k < highs) high[k] = any_of(m, 2 * k - 1, 2 * k + 3, n);
  };
  at_end(0);
  for (std::ptrdiff_t k = 1; k < inner; ++k) {
    const auto near = static_cast<std::uint8_t>(m[2 * k - 1] | m[2 * k] | m[2 * k + 1]);
    out[k] = near;
    high[k] = static_cast<std::uint8_t>(near | m[2 * k + 2] | m[2 * k + 3]);
  }
  for (std::ptrdiff_t k = inner < 1 ? 1 : inner; k < lows; ++k) at_end(k);
}

}  // namespace

void forward_wavelet53(Image image, int levels, std::int32_t* scratch) {
  for (int level = 0; level < levels; ++level) {
    const Image band(image.data, low_band_side(image.width, level), low_band_side(image.height, level), image.stride);
    const Image columns(scratch, band.width, band.height);
    with_widest_vectors([&] {
      forward_columns(band, columns);
      for (std::int32_t y = 0; y < band.height; ++y) forward_row(columns.row(y), band.row(y), band.width);
    });
  }
}

void inverse_wavelet53(Image image, int levels, std::int32_t* scratch) {
  for (int level = levels; level-- > 0;) {
    const Image band(image.data, low_band_side(image.width, level), low_band_side(image.height, level), image.stride);
    const Image rows(scratch, band.width, band.height);
    with_widest_vectors([&] {
      for (std::int32_t y = 0; y < band.height; ++y) inverse_row(band.row(y), rows.row(y), band.width);
      inverse_columns(rows, band);
    });
  }
}

void propagate_mask53(Mask mask, int levels, std::uint8_t* scratch) {
  for (std::int32_t y = 0; y < mask.height; ++y) {
    std::uint8_t* row = mask.row(y);
    for (std::int32_t x = 0; x < mask.width; ++x) row[x] = row[x] != 0 ? 1 : 0;
  }
  for (int level = 0; level < levels; ++level) {
    const Mask band(mask.data, low_band_side(mask.width, level), low_band_side(mask.height, level), mask.stride);
    const Mask columns(scratch, band.width, band.height);
    with_widest_vectors([&] {
      mask_columns(band, columns);
      for (std::int32_t y = 0; y < band.height; ++y) mask_row(columns.row(y), band.row(y), band.width);
    });
  }
}

}  // namespace ilp
