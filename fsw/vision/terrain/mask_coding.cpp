#include "fsw/vision/terrain/mask_coding.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "fsw/base/argument.hpp"
#include "fsw/vision/terrain/bit_coder.hpp"

namespace ilp {
namespace {

constexpr std::uint8_t form_bits = 0;
constexpr std::uint8_t form_runs = 1;
constexpr std::uint8_t form_contexts = 2;

std::size_t digits_of(std::uint32_t value) {
  std::size_t digits = 1;
  for (; value >= 128; value >>= 7U) ++digits;
  return digits;
}

/// Calls `use(length)` for every run in raster order; the first, of outside, may be empty.
template <typename Use>
void for_each_run(MaskView mask, Use use) {
  bool inside = false;
  std::uint32_t length = 0;
  for (std::int32_t y = 0; y < mask.height; ++y) {
    const std::uint8_t* row = mask.row(y);
    for (std::int32_t x = 0; x < mask.width; ++x) {
      if ((row[x] != 0) != inside) {
        use(length);
        length = 0;
        inside = !inside;
      }
      ++length;
    }
  }
  use(length);
}

void write_runs(MaskView mask, std::uint8_t* out) {
  for_each_run(mask, [&](std::uint32_t length) {
    for (; length >= 128; length >>= 7U) *out++ = static_cast<std::uint8_t>(length | 128U);
    *out++ = static_cast<std::uint8_t>(length);
  });
}

void write_bits(MaskView mask, std::uint8_t* out) {
  std::size_t pixel = 0;
  for (std::int32_t y = 0; y < mask.height; ++y) {
    for (std::int32_t x = 0; x < mask.width; ++x, ++pixel) {
      if (mask.at(x, y) != 0) out[pixel >> 3U] = static_cast<std::uint8_t>(out[pixel >> 3U] | (1U << (pixel & 7U)));
    }
  }
}

Status read_bits(const std::uint8_t* bytes, std::size_t size, const ImageView<std::uint8_t>& mask) {
  const std::size_t needed = max_mask_bytes(mask.area());
  if (size < needed) return {StatusCode::truncated, static_cast<std::int64_t>(size), static_cast<std::int64_t>(needed)};
  if (size > needed) return {StatusCode::parse_error, static_cast<std::int64_t>(needed)};
  std::size_t pixel = 0;
  for (std::int32_t y = 0; y < mask.height; ++y) {
    for (std::int32_t x = 0; x < mask.width; ++x, ++pixel) {
      mask.at(x, y) = (bytes[1 + (pixel >> 3U)] >> (pixel & 7U) & 1U) != 0 ? 255 : 0;
    }
  }
  const std::size_t spare = 8 * (needed - 1) - pixel;
  if (spare > 0 && bytes[needed - 1] >> (8 - spare) != 0) {
    return {StatusCode::parse_error, static_cast<std::int64_t>(needed - 1)};
  }
  return {};
}

/// Fills `length` pixels from raster index `first`, which the caller keeps inside.
void fill_run(const ImageView<std::uint8_t>& mask, std::size_t first, std::size_t length, std::uint8_t value) {
  const auto width = static_cast<std::size_t>(mask.width);
  while (length > 0) {
    const std::size_t x = first % width;
    const std::size_t here = std::min(length, width - x);
    std::fill_n(mask.row(static_cast<std::int32_t>(first / width)) + x, here, value);
    first += here;
    length -= here;
  }
}

Status read_runs(const std::uint8_t* bytes, std::size_t size, const ImageView<std::uint8_t>& mask) {
  const std::size_t area = mask.area();
  std::size_t at = 1;
  std::size_t pixel = 0;
  std::uint8_t value = 0;
  bool first_run = true;
  while (pixel < area) {
    std::uint64_t length = 0;
    std::uint32_t shift = 0;
    bool more = true;
    while (more) {  // bound: five octets
      if (at >= size)
        return {StatusCode::truncated, static_cast<std::int64_t>(size), static_cast<std::int64_t>(size + 1)};
      if (shift > 28) return {StatusCode::parse_error, static_cast<std::int64_t>(at)};
      length |= static_cast<std::uint64_t>(bytes[at] & 127U) << shift;
      more = (bytes[at] & 128U) != 0;
      shift += 7;
      ++at;
    }
    const bool empty = length == 0 && !first_run;
    if (empty || length > area - pixel) return {StatusCode::parse_error, static_cast<std::int64_t>(at - 1)};
    fill_run(mask, pixel, static_cast<std::size_t>(length), value);
    pixel += static_cast<std::size_t>(length);
    value = value == 0 ? 255 : 0;
    first_run = false;
  }
  if (at != size) return {StatusCode::parse_error, static_cast<std::int64_t>(at)};
  return {};
}

/// Where a row of the mask is inside or outside for the next pixels.
class RowScan {
 public:
  /// Without `row` all pixels are outside, as those to the right of it.
  RowScan(const std::uint8_t* row, std::int32_t width) : row_(row), width_(width) {}

  /// The first pixel at or after `x` that is not like `bit`; `endless` if there is none.
  std::int32_t other_after(std::int32_t x, std::uint32_t bit) {
    if (bit == bit_ && x >= from_ && x <= other_) return other_;
    from_ = x;
    bit_ = bit;
    other_ = find(x, bit);
    return other_;
  }

  static constexpr std::int32_t endless = std::numeric_limits<std::int32_t>::max();

 private:
  [[nodiscard]] std::int32_t find(std::int32_t x, std::uint32_t bit) const {
    if (bit != 0) {
      while (row_ != nullptr && x < width_ && row_[x] != 0) ++x;
      return x;
    }
    if (row_ == nullptr) return endless;
    constexpr std::int32_t step = sizeof(std::uint64_t);
    for (std::uint64_t eight = 0; x + step <= width_; x += step) {
      std::memcpy(&eight, row_ + x, sizeof(eight));
      if (eight != 0) break;
    }
    while (x < width_ && row_[x] == 0) ++x;
    return x < width_ ? x : endless;
  }

  const std::uint8_t* row_;
  std::int32_t width_;
  std::int32_t from_ = 0, other_ = -1;  ///< what was found last
  std::uint32_t bit_ = 0;
};

constexpr std::uint32_t all_inside = 1023;
constexpr std::size_t mask_contexts = all_inside + 1;

/// Codes every pixel in raster order. The context consists of ten pixels that are already known: two to the left, five
/// in the row above, three in the row above that (the template of JBIG2, ITU-T T.88, figure 6). Pixels outside the
/// image count as outside the mask. `pixel.code(context, x, y)` codes one; `pixel.code_run(context, bit, most, x, y)`
/// up to `most` of the same context, all like `bit` but perhaps the last one, and returns their number.
template <typename Pixels>
void for_each_context(std::int32_t width, std::int32_t height, const Pixels& pixel) {
  const auto known = [&](std::int32_t x, std::int32_t y) {
    return x >= 0 && x < width && y >= 0 ? pixel.known(x, y) : 0U;
  };
  for (std::int32_t y = 0; y < height; ++y) {
    RowScan scan_upper(y >= 2 ? pixel.row(y - 2) : nullptr, width),
        scan_above(y >= 1 ? pixel.row(y - 1) : nullptr, width);
    std::uint32_t upper = known(0, y - 2);                            // x - 1 .. x + 1, two rows above
    std::uint32_t above = (known(0, y - 1) << 1U) | known(1, y - 1);  // x - 2 .. x + 2
    std::uint32_t left = 0;                                           // x - 2, x - 1
    for (std::int32_t x = 0; x < width;) {
      upper = ((upper << 1U) | known(x + 1, y - 2)) & 7U;
      above = ((above << 1U) | known(x + 2, y - 1)) & 31U;
      const std::uint32_t context = (upper << 7U) | (above << 2U) | left;
      if (context != 0 && context != all_inside) {
        left = ((left << 1U) | pixel.code(context, x, y)) & 3U;
        ++x;
        continue;
      }
      // The context stays the same up to the first pixel that is not like the others.
      const std::uint32_t bit = context & 1U;
      const std::int32_t same = std::min(scan_upper.other_after(x, bit) - 1, scan_above.other_after(x, bit) - 2);
      const std::int32_t most = std::min(same, width) - x;
      const std::int32_t done = pixel.code_run(context, bit, most, x, y);
      x += done;
      left = (known(x - 2, y) << 1U) | known(x - 1, y);
      upper = (known(x - 1, y - 2) << 1U) | known(x, y - 2);
      above = (known(x - 2, y - 1) << 3U) | (known(x - 1, y - 1) << 2U) | (known(x, y - 1) << 1U) | known(x + 1, y - 1);
    }
  }
}

struct EncodedPixels {
  MaskView mask;
  BitEncoder<mask_contexts>& coder;

  [[nodiscard]] const std::uint8_t* row(std::int32_t y) const { return mask.row(y); }
  [[nodiscard]] std::uint32_t known(std::int32_t x, std::int32_t y) const { return mask.at(x, y) != 0 ? 1U : 0U; }
  [[nodiscard]] std::uint32_t code(std::uint32_t context, std::int32_t x, std::int32_t y) const {
    const std::uint32_t bit = known(x, y);
    coder.encode(context, bit);
    return bit;
  }
  [[nodiscard]] std::int32_t code_run(std::uint32_t context, std::uint32_t bit, std::int32_t most, std::int32_t x,
                                      std::int32_t y) const {
    RowScan here(mask.row(y), x + most);
    const std::int32_t usual = std::min(here.other_after(x, bit) - x, most);
    coder.encode_run(context, bit, static_cast<std::size_t>(usual));
    if (usual == most) return most;
    coder.encode(context, bit ^ 1U);
    return usual + 1;
  }
};

struct DecodedPixels {
  const ImageView<std::uint8_t>& mask;
  BitDecoder<mask_contexts>& coder;

  [[nodiscard]] const std::uint8_t* row(std::int32_t y) const { return mask.row(y); }
  [[nodiscard]] std::uint32_t known(std::int32_t x, std::int32_t y) const { return mask.at(x, y) & 1U; }
  [[nodiscard]] std::uint32_t code(std::uint32_t context, std::int32_t x, std::int32_t y) const {
    const std::uint32_t bit = coder.decode(context);
    mask.at(x, y) = bit != 0 ? 255 : 0;
    return bit;
  }
  [[nodiscard]] std::int32_t code_run(std::uint32_t context, std::uint32_t bit, std::int32_t most, std::int32_t x,
                                      std::int32_t y) const {
    const std::uint8_t value = bit != 0 ? 255 : 0;
    const auto usual = static_cast<std::int32_t>(coder.decode_run(context, bit, static_cast<std::size_t>(most)));
    std::fill_n(mask.row(y) + x, usual, value);
    if (usual == most) return most;
    mask.at(x + usual, y) = value ^ 255U;
    return usual + 1;
  }
};

/// Bytes written after the first, or more than `capacity`.
std::size_t write_contexts(MaskView mask, std::uint8_t* out, std::size_t capacity) {
  BitEncoder<mask_contexts> coder(out, capacity);
  for_each_context(mask.width, mask.height, EncodedPixels{mask, coder});
  return coder.finish();
}

Status read_contexts(const std::uint8_t* bytes, std::size_t size, const ImageView<std::uint8_t>& mask) {
  BitDecoder<mask_contexts> coder(bytes + 1, size - 1);
  for_each_context(mask.width, mask.height, DecodedPixels{mask, coder});
  const std::size_t used = 1 + coder.used();
  if (used > size) return {StatusCode::truncated, static_cast<std::int64_t>(size), static_cast<std::int64_t>(used)};
  if (used < size) return {StatusCode::parse_error, static_cast<std::int64_t>(used)};
  return {};
}

}  // namespace

Status encode_mask(MaskView mask, std::uint8_t* bytes, std::size_t capacity, std::size_t& size) {
  size = 0;
  if (mask.empty()) return out_of_range(Argument::mask_size, 0);
  std::size_t run_bytes = 1;
  for_each_run(mask, [&](std::uint32_t length) { run_bytes += digits_of(length); });
  const std::size_t bit_bytes = max_mask_bytes(mask.area());
  const std::size_t plain_bytes = std::min(run_bytes, bit_bytes);
  const std::size_t usable = std::min(capacity, plain_bytes);
  if (usable > 1) {
    const std::size_t context_bytes = 1 + write_contexts(mask, bytes + 1, usable - 1);
    if (context_bytes <= usable) {
      bytes[0] = form_contexts;
      size = context_bytes;
      return {};
    }
  }
  if (plain_bytes > capacity) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(plain_bytes), static_cast<std::int64_t>(capacity)};
  }
  if (run_bytes < bit_bytes) {
    bytes[0] = form_runs;
    write_runs(mask, bytes + 1);
  } else {
    bytes[0] = form_bits;
    std::fill_n(bytes + 1, plain_bytes - 1, std::uint8_t{0});
    write_bits(mask, bytes + 1);
  }
  size = plain_bytes;
  return {};
}

Status decode_mask(const std::uint8_t* bytes, std::size_t size, const ImageView<std::uint8_t>& mask) {
  if (mask.empty()) return out_of_range(Argument::mask_size, 0);
  if (size < 1) return {StatusCode::truncated, 0, 1};
  if (bytes[0] == form_bits) return read_bits(bytes, size, mask);
  if (bytes[0] == form_runs) return read_runs(bytes, size, mask);
  if (bytes[0] == form_contexts) return read_contexts(bytes, size, mask);
  return {StatusCode::parse_error, 0};
}

}  // namespace ilp
