#include "fsw/vision/terrain/mask_coding.hpp"

#include <algorithm>
#include <cstring>

#include "fsw/vision/terrain/bit_coder.hpp"

namespace ilp {
namespace {

constexpr std::uint8_t form_bits = 0;
constexpr std::uint8_t form_runs = 1;
constexpr std::uint8_t form_contexts = 2;

std::uint32_t bit_of(std::uint8_t pixel) {
  return pixel != 0 ? 1U : 0U;
}

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
    while (more) {
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

constexpr std::size_t mask_contexts = 1024;
/// Pixels that are coded together where all that is known about them is alike.
constexpr std::int32_t together = 8;

std::uint64_t load_pixels(const std::uint8_t* pixels) {
  static_assert(together == sizeof(std::uint64_t));
  std::uint64_t word = 0;
  std::memcpy(&word, pixels, sizeof(word));
  return word;
}

/// The ten pixels that are known before a pixel: two to the left, five in the row above, three in the row above that
/// (the template of JBIG2, ITU-T T.88, figure 6). Pixels outside the image count as outside the mask.
struct Context {
  std::uint32_t upper = 0;  ///< x - 1 .. x + 1, two rows above
  std::uint32_t above = 0;  ///< x - 2 .. x + 2
  std::uint32_t left = 0;   ///< x - 2, x - 1

  /// Goes on by a pixel; `upper_bit` and `above_bit` are those that come in from the right.
  void advance(std::uint32_t upper_bit, std::uint32_t above_bit) {
    upper = ((upper << 1U) | upper_bit) & 7U;
    above = ((above << 1U) | above_bit) & 31U;
  }
  void take(std::uint32_t bit) { left = ((left << 1U) | bit) & 3U; }
  [[nodiscard]] std::uint32_t number() const { return (upper << 7U) | (above << 2U) | left; }
};

/// One row whose context may leave the image.
template <typename Pixels>
void code_row_at_border(std::int32_t width, std::int32_t y, const Pixels& pixel) {
  const auto known = [&](std::int32_t x, std::int32_t row) {
    return x < width && row >= 0 ? bit_of(pixel.row(row)[x]) : 0U;
  };
  Context context{known(0, y - 2), (known(0, y - 1) << 1U) | known(1, y - 1), 0};
  for (std::int32_t x = 0; x < width; ++x) {
    context.advance(known(x + 1, y - 2), known(x + 2, y - 1));
    context.take(pixel.code(context.number(), x, y));
  }
}

/// Codes the next pixels of a row if everything known about all of them is `bit`. Returns how many.
template <typename Pixels>
std::int32_t code_together(const std::uint8_t* upper, const std::uint8_t* above, std::uint32_t bit, std::int32_t x,
                           std::int32_t y, const Pixels& pixel) {
  const std::uint64_t alike = bit != 0 ? ~std::uint64_t{0} : 0;
  const bool all = load_pixels(upper + x - 1) == alike && load_pixels(upper + x + 1) == alike &&
                   load_pixels(above + x - 2) == alike && load_pixels(above + x + 2) == alike;
  return all ? pixel.code_alike(bit, x, y) : 0;
}

template <typename Pixels>
void code_row(std::int32_t width, std::int32_t y, const Pixels& pixel) {
  constexpr std::uint32_t all_inside = mask_contexts - 1;
  const std::uint8_t* const upper = pixel.row(y - 2);
  const std::uint8_t* const above = pixel.row(y - 1);
  Context context{bit_of(upper[0]), (bit_of(above[0]) << 1U) | (width > 1 ? bit_of(above[1]) : 0U), 0};
  std::int32_t x = 0;
  const std::int32_t last_together = width - together - 2;
  while (x < width) {
    const std::uint32_t before = context.number();
    if ((before == 0 || before == all_inside) && x >= 2 && x <= last_together) {
      const std::int32_t coded = code_together(upper, above, before & 1U, x, y, pixel);
      x += coded;
      if (coded == together) continue;
    }
    context.advance(x + 1 < width ? bit_of(upper[x + 1]) : 0U, x + 2 < width ? bit_of(above[x + 2]) : 0U);
    context.take(pixel.code(context.number(), x, y));
    ++x;
  }
}

/// Codes every pixel in raster order.
template <typename Pixels>
void code_pixels(std::int32_t width, std::int32_t height, const Pixels& pixel) {
  for (std::int32_t y = 0; y < std::min(height, 2); ++y) code_row_at_border(width, y, pixel);
  for (std::int32_t y = 2; y < height; ++y) code_row(width, y, pixel);
}

std::uint32_t context_of_alike(std::uint32_t bit) {
  return bit != 0 ? mask_contexts - 1 : 0;
}

struct EncodedPixels {
  MaskView mask;
  BitEncoder<mask_contexts>& coder;

  [[nodiscard]] const std::uint8_t* row(std::int32_t y) const { return mask.row(y); }
  [[nodiscard]] std::uint32_t code(std::uint32_t context, std::int32_t x, std::int32_t y) const {
    const std::uint32_t bit = bit_of(mask.at(x, y));
    coder.encode(context, bit);
    return bit;
  }
  [[nodiscard]] std::int32_t code_alike(std::uint32_t bit, std::int32_t x, std::int32_t y) const {
    const std::uint32_t context = context_of_alike(bit);
    if (load_pixels(mask.row(y) + x) != (bit != 0 ? ~std::uint64_t{0} : 0) || !coder.settled(context, bit)) return 0;
    coder.encode_settled(context, bit, static_cast<std::size_t>(together));
    return together;
  }
};

struct DecodedPixels {
  const ImageView<std::uint8_t>& mask;
  BitDecoder<mask_contexts>& coder;

  [[nodiscard]] const std::uint8_t* row(std::int32_t y) const { return mask.row(y); }
  [[nodiscard]] std::uint32_t code(std::uint32_t context, std::int32_t x, std::int32_t y) const {
    const std::uint32_t bit = coder.decode(context);
    mask.at(x, y) = bit != 0 ? 255 : 0;
    return bit;
  }
  [[nodiscard]] std::int32_t code_alike(std::uint32_t bit, std::int32_t x, std::int32_t y) const {
    const std::uint32_t context = context_of_alike(bit);
    if (!coder.settled(context, bit)) return 0;
    const std::size_t coded = coder.decode_settled(context, bit, static_cast<std::size_t>(together));
    std::fill_n(mask.row(y) + x, coded, static_cast<std::uint8_t>(bit != 0 ? 255 : 0));
    return static_cast<std::int32_t>(coded);
  }
};

/// Bytes written after the first, or more than `capacity`.
std::size_t write_contexts(MaskView mask, std::uint8_t* out, std::size_t capacity) {
  BitEncoder<mask_contexts> coder(out, capacity);
  code_pixels(mask.width, mask.height, EncodedPixels{mask, coder});
  return coder.finish();
}

Status read_contexts(const std::uint8_t* bytes, std::size_t size, const ImageView<std::uint8_t>& mask) {
  BitDecoder<mask_contexts> coder(bytes + 1, size - 1);
  code_pixels(mask.width, mask.height, DecodedPixels{mask, coder});
  const std::size_t used = 1 + coder.used();
  if (used > size) return {StatusCode::truncated, static_cast<std::int64_t>(size), static_cast<std::int64_t>(used)};
  if (used < size) return {StatusCode::parse_error, static_cast<std::int64_t>(used)};
  return {};
}

}  // namespace

Status encode_mask(MaskView mask, std::uint8_t* bytes, std::size_t capacity, std::size_t& size) {
  size = 0;
  if (mask.empty()) return {StatusCode::invalid_argument, 1};
  std::size_t run_bytes = 1;
  for_each_run(mask, [&](std::uint32_t length) { run_bytes += digits_of(length); });
  const std::size_t bit_bytes = max_mask_bytes(mask.area());
  const std::size_t plain_bytes = std::min(run_bytes, bit_bytes);
  const std::size_t room = std::min(capacity, plain_bytes);
  if (room > 1) {
    const std::size_t context_bytes = 1 + write_contexts(mask, bytes + 1, room - 1);
    if (context_bytes <= room) {
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
  if (mask.empty()) return {StatusCode::invalid_argument, 1};
  if (size < 1) return {StatusCode::truncated, 0, 1};
  if (bytes[0] == form_bits) return read_bits(bytes, size, mask);
  if (bytes[0] == form_runs) return read_runs(bytes, size, mask);
  if (bytes[0] == form_contexts) return read_contexts(bytes, size, mask);
  return {StatusCode::parse_error, 0};
}

}  // namespace ilp
