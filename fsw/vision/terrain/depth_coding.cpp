#include "fsw/vision/terrain/depth_coding.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/base/vector_width.hpp"

namespace ilp {
namespace {

bool positive(double v) {
  return std::isfinite(v) && v > 0;
}

/// The code is the integer below.
double above_code(float inverse_depth, const DepthCoding& coding) {
  return (static_cast<double>(inverse_depth) - coding.offset) / coding.step + 0.5;
}
/// Whether the integer below is a code.
bool has_code(double above) {
  return (above >= 1) & (above < max_depth_code + 1);
}

/// False if a value has no code.
bool encode_row(const float* inverse_depth, const float* sigma, const std::uint8_t* mask, std::int32_t width,
                const DepthCoding coding, std::uint16_t* __restrict codes) {
  std::int32_t wrong = 0;
  for (std::int32_t x = 0; x < width; ++x) {
    const bool known = (mask[x] != 0) & (sigma[x] > 0);
    const double above = above_code(inverse_depth[x], coding);
    const bool fits = has_code(above);
    wrong |= static_cast<std::int32_t>(known & !fits);
    codes[x] = static_cast<std::uint16_t>(static_cast<std::int32_t>((known & fits) ? above : 0.0));
  }
  return wrong == 0;
}

/// The largest code of the row; the values of a row with one above max_depth_code have no meaning.
std::uint16_t decode_row(const std::uint16_t* codes, std::int32_t width, const DepthCoding coding,
                         float* __restrict inverse_depth) {
  std::uint16_t largest = 0;
  for (std::int32_t x = 0; x < width; ++x) {
    largest = codes[x] > largest ? codes[x] : largest;
    const auto value = static_cast<float>(coding.offset + coding.step * static_cast<std::int32_t>(codes[x]));
    inverse_depth[x] = codes[x] == 0 ? 0.0F : value;
  }
  return largest;
}

}  // namespace

Status choose_depth_coding(ImageView<const float> inverse_depth, ImageView<const float> sigma, MaskView mask,
                           double focal_px, double baseline, double steps_per_px, DepthCoding& coding) {
  if (!same_size(inverse_depth, sigma) || !same_size(inverse_depth, mask))
    return out_of_range(Argument::depth_size, sigma.width);
  if (!positive(focal_px) || !positive(baseline) || !positive(steps_per_px))
    return out_of_range(Argument::depth_coding, steps_per_px);
  double lowest = 0;
  double highest = 0;
  bool any = false;
  for (std::int32_t y = 0; y < mask.height; ++y) {
    for (std::int32_t x = 0; x < mask.width; ++x) {
      if (mask.at(x, y) == 0 || !(sigma.at(x, y) > 0)) continue;
      const double v = static_cast<double>(inverse_depth.at(x, y));
      lowest = any ? std::min(lowest, v) : v;
      highest = any ? std::max(highest, v) : v;
      any = true;
    }
  }
  coding.step = 1 / (steps_per_px * focal_px * baseline);
  // The offset and the last value are rounded outwards, which costs two codes.
  for (int doubling = 0; doubling < 64 && highest - lowest > (max_depth_code - 2) * coding.step; ++doubling) {
    coding.step *= 2;
  }
  coding.offset = (std::floor(lowest / coding.step) - 1) * coding.step;
  return {};
}

Status encode_depth(ImageView<const float> inverse_depth, ImageView<const float> sigma, MaskView mask,
                    const DepthCoding& coding, const ImageView<std::uint16_t>& codes) {
  if (!same_size(inverse_depth, sigma) || !same_size(inverse_depth, mask) || !same_size(inverse_depth, codes)) {
    return out_of_range(Argument::depth_size, sigma.width);
  }
  if (!positive(coding.step) || !std::isfinite(coding.offset)) return out_of_range(Argument::depth_coding, coding.step);
  std::int32_t y = 0;
  with_widest_vectors([&] {
    while (y < mask.height &&
           encode_row(inverse_depth.row(y), sigma.row(y), mask.row(y), mask.width, coding, codes.row(y))) {
      ++y;
    }
  });
  if (y == mask.height) return {};
  for (std::int32_t x = 0; x < mask.width; ++x) {
    if (mask.at(x, y) == 0 || !(sigma.at(x, y) > 0)) continue;
    const double above = above_code(inverse_depth.at(x, y), coding);
    if (has_code(above)) continue;
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(std::clamp(std::floor(above), -1e9, 1e9)),
            max_depth_code};
  }
  return {};
}

Status decode_depth(ImageView<const std::uint16_t> codes, const DepthCoding& coding,
                    const ImageView<float>& inverse_depth) {
  if (!same_size(codes, inverse_depth)) return out_of_range(Argument::depth_size, codes.width);
  if (!positive(coding.step) || !std::isfinite(coding.offset)) return out_of_range(Argument::depth_coding, coding.step);
  std::int32_t y = 0;
  with_widest_vectors([&] {
    while (y < codes.height && decode_row(codes.row(y), codes.width, coding, inverse_depth.row(y)) <= max_depth_code) {
      ++y;
    }
  });
  if (y == codes.height) return {};
  std::int32_t x = 0;
  while (codes.at(x, y) <= max_depth_code) ++x;
  return {StatusCode::parse_error, static_cast<std::int64_t>(y) * codes.width + x};
}

}  // namespace ilp
