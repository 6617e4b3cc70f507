#include "fsw/vision/terrain/sigma_map.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/base/vector_width.hpp"

namespace ilp {
namespace {

constexpr std::array<double, sigma_map_levels + 1> make_levels() {
  constexpr double eighth_of_an_octave = 1.0905077326652577;
  std::array<double, sigma_map_levels + 1> levels{};
  levels[1] = 1;
  for (std::size_t k = 2; k < levels.size(); ++k) {
    // Whole octaves are exact, so that rounding errors do not accumulate.
    levels[k] = k % 8 == 1 ? 2 * levels[k - 8] : levels[k - 1] * eighth_of_an_octave;
  }
  return levels;
}
constexpr std::array<double, sigma_map_levels + 1> levels = make_levels();

using Histogram = std::array<std::uint16_t, sigma_code_largest + 1>;
static_assert(sigma_block_px * sigma_block_px <= 65535);

int median_code(const Histogram& histogram) {
  int count = 0;
  for (std::size_t code = 1; code < histogram.size(); ++code) count += histogram[code];
  if (count == 0) return 0;
  int below = 0;
  for (std::size_t code = 1; code < histogram.size(); ++code) {
    below += histogram[code];
    if (2 * below >= count) return static_cast<int>(code);
  }
  return 0;
}

char character_of(int code) {
  if (code == 0) return sigma_map_none;
  int k = 1;
  while (k < sigma_map_levels && levels[static_cast<std::size_t>(k)] < code) ++k;
  return static_cast<char>(sigma_map_none + k);
}

char block_character(ImageView<const std::uint8_t> codes, MaskView mask, std::int32_t column, std::int32_t row) {
  Histogram histogram{};
  const std::int32_t bottom = std::min(row + sigma_block_px, codes.height);
  const std::int32_t right = std::min(column + sigma_block_px, codes.width);
  for (std::int32_t y = row; y < bottom; ++y) {
    const std::uint8_t* code = codes.row(y);
    const std::uint8_t* inside = mask.row(y);
    for (std::int32_t x = column; x < right; ++x) {
      if (inside[x] != 0) ++histogram[code[x] & sigma_code_largest];
    }
  }
  return character_of(median_code(histogram));
}

}  // namespace

std::uint32_t code_sigma(const DepthView& depth, double disparity_per_inverse_depth_px, std::uint8_t* codes) {
  const double factor = disparity_per_inverse_depth_px * sigma_codes_per_px;
  with_widest_vectors([&] {
    const float* __restrict from = depth.sigma.data;
    std::uint8_t* __restrict to = codes;
    for (std::size_t i = 0; i < depth.sigma.area(); ++i) {
      const double value = std::ceil(static_cast<double>(from[i]) * factor);
      const auto code = static_cast<std::int32_t>(value > sigma_code_largest ? sigma_code_largest : value);
      to[i] = static_cast<std::uint8_t>(code);
    }
  });
  std::uint32_t count = 0;
  for (std::int32_t y = 0; y < depth.sigma.height; ++y, codes += depth.sigma.width) {
    for (std::int32_t word = 0; word < depth.supported.width; ++word) {
      for (std::uint64_t left = depth.supported.at(word, y); left != 0;
           left &= left - 1) {  // bound: the bits of a word
        std::uint8_t& code = codes[word * supported_bits + std::countr_zero(left)];
        if (code == 0) continue;
        code |= sigma_code_supported;
        ++count;
      }
    }
  }
  return count;
}

Status encode_sigma_map(ImageView<const std::uint8_t> codes, MaskView mask, std::span<char> out, std::size_t& size) {
  size = 0;
  if (codes.width != mask.width || codes.height != mask.height) return out_of_range(Argument::mask_size, mask.width);
  const std::size_t needed =
      static_cast<std::size_t>(sigma_map_side(codes.width)) * static_cast<std::size_t>(sigma_map_side(codes.height));
  if (needed > out.size()) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(needed), static_cast<std::int64_t>(out.size())};
  }
  for (std::int32_t row = 0; row < codes.height; row += sigma_block_px) {
    for (std::int32_t column = 0; column < codes.width; column += sigma_block_px) {
      out[size++] = block_character(codes, mask, column, row);
    }
  }
  return {};
}

double sigma_of_character(char character) {
  const int k = character - sigma_map_none;
  return k >= 1 && k <= sigma_map_levels ? levels[static_cast<std::size_t>(k)] : 0;
}

}  // namespace ilp
