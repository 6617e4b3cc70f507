#include "sim/host/picture.hpp"

#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/host/statistics.hpp"

namespace ilp::host {
namespace {

std::vector<std::uint8_t> encode(std::int32_t width, std::int32_t height, const void* pixels, png_uint_32 format) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = format;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::vector<std::uint8_t> bytes(size);
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels, 0, nullptr) == 0) {
    throw std::runtime_error(std::string("cannot encode a PNG: ") + image.message);
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace

static_assert(std::endian::native == std::endian::little, "pages carry little-endian arrays");

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = (group << 8U) | (i + k < bytes.size() ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? digits[(group >> (18 - 6 * k)) & 63U] : '=';
    }
  }
  return text;
}

std::vector<std::uint8_t> png_bytes(const Raster<std::uint8_t>& grey) {
  return encode(grey.width, grey.height, grey.samples.data(), PNG_FORMAT_GRAY);
}

std::vector<std::uint8_t> png_bytes_where_seen(const Raster<std::uint8_t>& grey) {
  std::vector<std::uint8_t> bytes = png_bytes(grey);
  // PNG 11.3.2.1: tRNS with the grey value 0, behind the signature and IHDR.
  constexpr std::ptrdiff_t behind_header = 8 + 25;
  constexpr std::array<std::uint8_t, 6> named = {'t', 'R', 'N', 'S', 0, 0};
  std::vector<std::uint8_t> chunk = {0, 0, 0, 2};
  chunk.insert(chunk.end(), named.begin(), named.end());
  const auto crc = static_cast<std::uint32_t>(crc32(0, named.data(), named.size()));
  for (const int shift : {24, 16, 8, 0}) chunk.push_back(static_cast<std::uint8_t>(crc >> shift));
  bytes.insert(bytes.begin() + behind_header, chunk.begin(), chunk.end());
  return bytes;
}

std::vector<std::uint8_t> png_bytes(const Raster<Rgba>& picture) {
  return encode(picture.width, picture.height, picture.samples.data(), PNG_FORMAT_RGBA);
}

std::string data_uri(const std::vector<std::uint8_t>& png) {
  return "data:image/png;base64," + base64(png);
}

namespace {

template <std::size_t count>
Rgb between(const Rgb (&table)[count], double t) {
  constexpr int last = static_cast<int>(count) - 1;
  const double at = std::clamp(t, 0.0, 1.0) * last;
  const int i = std::min(static_cast<int>(at), last - 1);
  const double u = at - i;
  const auto mix = [u](std::uint8_t a, std::uint8_t b) { return static_cast<std::uint8_t>(a + u * (b - a) + 0.5); };
  const Rgb &a = table[i], &b = table[i + 1];
  return {mix(a.r, b.r), mix(a.g, b.g), mix(a.b, b.b)};
}

}  // namespace

Rgb viridis(double t) {
  static constexpr Rgb table[] = {{68, 1, 84},    {72, 26, 108},  {71, 47, 125},  {65, 68, 135},
                                  {57, 86, 140},  {49, 104, 142}, {42, 120, 142}, {35, 136, 142},
                                  {31, 152, 139}, {34, 168, 132}, {53, 183, 121}, {84, 197, 104},
                                  {122, 209, 81}, {165, 219, 54}, {210, 226, 27}, {253, 231, 37}};
  return between(table, t);
}

Rgb diverging(double t) {
  static constexpr Rgb table[] = {{5, 48, 97},     {33, 102, 172},  {67, 147, 195},  {146, 197, 222},
                                  {209, 229, 240}, {247, 247, 247}, {253, 219, 199}, {244, 165, 130},
                                  {214, 96, 77},   {178, 24, 43},   {103, 0, 31}};
  return between(table, t);
}

ValueRange display_range(const Raster<float>& values) {
  std::vector<double> finite;
  for (const float v : values.samples) {
    if (std::isfinite(v)) finite.push_back(v);
  }
  if (finite.empty()) return {};
  const ValueRange range{percentile(finite, 0.02), percentile(finite, 0.98)};
  return range.high > range.low ? range : ValueRange{range.low - 0.5, range.low + 0.5};
}

Raster<Rgba> colour_mapped(const Raster<float>& values, const ValueRange& range, ColourMap colours) {
  Raster<Rgba> picture(values.width, values.height);
  for (std::size_t i = 0; i < values.samples.size(); ++i) {
    if (!std::isfinite(values.samples[i])) continue;
    const Rgb c = colours((values.samples[i] - range.low) / (range.high - range.low));
    picture.samples[i] = {c.r, c.g, c.b, 255};
  }
  return picture;
}

std::uint8_t mean_grey(const Raster<std::uint8_t>& image, std::int32_t x0, std::int32_t y0, std::int32_t factor) {
  std::uint32_t sum = 0, count = 0;
  for (std::int32_t y = y0; y < std::min(y0 + factor, image.height); ++y) {
    for (std::int32_t x = x0; x < std::min(x0 + factor, image.width); ++x, ++count) sum += image.at(x, y);
  }
  return static_cast<std::uint8_t>((sum + count / 2) / std::max(count, 1U));
}

float mean_depth(const Raster<float>& inverse, std::int32_t x0, std::int32_t y0, std::int32_t factor) {
  double sum = 0;
  int count = 0;
  for (std::int32_t y = y0; y < std::min(y0 + factor, inverse.height); ++y) {
    for (std::int32_t x = x0; x < std::min(x0 + factor, inverse.width); ++x) {
      if (!(inverse.at(x, y) > 0)) continue;
      sum += inverse.at(x, y);
      ++count;
    }
  }
  return count == 0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(count / sum);
}

}  // namespace ilp::host
