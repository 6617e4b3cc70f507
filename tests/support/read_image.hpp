// Reads the grey images of the test data: PNG of 8 bits (colour is converted) or 16 bits, and binary PGM.
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

/// A 16-bit grey image, such as a disparity map, with the values of the file.
struct Image16 {
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::vector<std::uint16_t> pixels;

  [[nodiscard]] bool empty() const { return pixels.empty(); }
};

/// Folder of the test data, relative to the project's root, which is the working directory of tests.
inline constexpr const char* data_root = "../shared/data/";

/// Read an image. Return an empty image if the file is missing or malformed.
[[nodiscard]] Image read_image(const std::string& path);
[[nodiscard]] Image16 read_image16(const std::string& path);

}  // namespace ilp::test
