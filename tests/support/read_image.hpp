// Reads the grey images of the test data: 8-bit PNG (colour is converted) and binary PGM.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fsw/base/image_view.hpp"

namespace ilp::test {

/// Row-major 8-bit image that owns its pixels.
struct Image {
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::vector<std::uint8_t> pixels;

  Image() = default;
  Image(std::int32_t w, std::int32_t h)
      : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}

  [[nodiscard]] bool empty() const { return pixels.empty(); }
  [[nodiscard]] GrayView view() const { return {pixels.data(), width, height}; }
  [[nodiscard]] MutableGrayView view() { return {pixels.data(), width, height}; }
};

/// 16-bit grey PNG (disparity maps), values as stored.
struct Image16 {
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::vector<std::uint16_t> pixels;

  [[nodiscard]] bool empty() const { return pixels.empty(); }
};

/// The project's test data lie beside it; tests run with the project root as working directory.
inline constexpr const char* data_root = "../shared/data/";

/// An empty image when the file is missing or malformed.
[[nodiscard]] Image read_image(const std::string& path);
[[nodiscard]] Image16 read_image16(const std::string& path);

}  // namespace ilp::test
