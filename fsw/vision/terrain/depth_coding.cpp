#include "fsw/vision/terrain/depth_coding.hpp"

#include <algorithm>
#include <cmath>

namespace ilp {
namespace {

bool positive(double v) {
  return std::isfinite(v) && v > 0;
}

}  // namespace

Status choose_depth_coding(ImageView<const float> inverse_depth, ImageView<const float> sigma, MaskView mask,
                           double focal_px, double baseline, double steps_per_px, DepthCoding& coding) {
  if (!same_size(inverse_depth, sigma) || !same_size(inverse_depth, mask)) return {StatusCode::invalid_argument, 1};
  if (!positive(focal_px) || !positive(baseline) || !positive(steps_per_px)) return {StatusCode::invalid_argument, 2};
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
    return {StatusCode::invalid_argument, 1};
  }
  if (!positive(coding.step) || !std::isfinite(coding.offset)) return {StatusCode::invalid_argument, 2};
  for (std::int32_t y = 0; y < mask.height; ++y) {
    for (std::int32_t x = 0; x < mask.width; ++x) {
      codes.at(x, y) = 0;
      if (mask.at(x, y) == 0 || !(sigma.at(x, y) > 0)) continue;
      const double code = std::floor((static_cast<double>(inverse_depth.at(x, y)) - coding.offset) / coding.step + 0.5);
      if (!(code >= 1 && code <= max_depth_code)) {
        return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(std::clamp(code, -1e9, 1e9)), max_depth_code};
      }
      codes.at(x, y) = static_cast<std::uint16_t>(code);
    }
  }
  return {};
}

Status decode_depth(ImageView<const std::uint16_t> codes, const DepthCoding& coding,
                    const ImageView<float>& inverse_depth) {
  if (!same_size(codes, inverse_depth)) return {StatusCode::invalid_argument, 1};
  if (!positive(coding.step) || !std::isfinite(coding.offset)) return {StatusCode::invalid_argument, 2};
  for (std::int32_t y = 0; y < codes.height; ++y) {
    for (std::int32_t x = 0; x < codes.width; ++x) {
      const std::uint16_t code = codes.at(x, y);
      if (code > max_depth_code) return {StatusCode::parse_error, static_cast<std::int64_t>(y) * codes.width + x};
      inverse_depth.at(x, y) = code == 0 ? 0.0F : static_cast<float>(coding.offset + coding.step * code);
    }
  }
  return {};
}

}  // namespace ilp
