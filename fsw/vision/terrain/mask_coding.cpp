#include "fsw/vision/terrain/mask_coding.hpp"

#include <algorithm>

namespace ilp {
namespace {

constexpr std::uint8_t form_bits = 0;
constexpr std::uint8_t form_runs = 1;

std::size_t digits_of(std::uint32_t value) {
  std::size_t digits = 1;
  for (; value >= 128; value >>= 7U) ++digits;
  return digits;
}

/// `use(length)` for every run in raster order; the first, of outside, may be empty.
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

}  // namespace

Status encode_mask(MaskView mask, std::uint8_t* bytes, std::size_t capacity, std::size_t& size) {
  size = 0;
  if (mask.empty()) return {StatusCode::invalid_argument, 1};
  std::size_t run_bytes = 1;
  for_each_run(mask, [&](std::uint32_t length) { run_bytes += digits_of(length); });
  const std::size_t bit_bytes = max_mask_bytes(mask.area());
  const bool runs = run_bytes < bit_bytes;
  const std::size_t needed = runs ? run_bytes : bit_bytes;
  if (needed > capacity) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(needed), static_cast<std::int64_t>(capacity)};
  }
  bytes[0] = runs ? form_runs : form_bits;
  if (runs) {
    write_runs(mask, bytes + 1);
  } else {
    std::fill_n(bytes + 1, needed - 1, std::uint8_t{0});
    write_bits(mask, bytes + 1);
  }
  size = needed;
  return {};
}

Status decode_mask(const std::uint8_t* bytes, std::size_t size, const ImageView<std::uint8_t>& mask) {
  if (mask.empty()) return {StatusCode::invalid_argument, 1};
  if (size < 1) return {StatusCode::truncated, 0, 1};
  if (bytes[0] == form_bits) return read_bits(bytes, size, mask);
  if (bytes[0] == form_runs) return read_runs(bytes, size, mask);
  return {StatusCode::parse_error, 0};
}

}  // namespace ilp
