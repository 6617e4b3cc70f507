// ImageView, a view of pixels that it does not own, and FixedImage, which owns pixels in fixed memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "fsw/base/status.hpp"

namespace ilp {

/// Row-major pixels; pixel (0,0) is the centre of the top-left pixel. `stride` is in elements, not bytes.
template <typename T>
struct ImageView {
  T* data = nullptr;
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::int32_t stride = 0;

  constexpr ImageView() = default;
  constexpr ImageView(T* pixels, std::int32_t w, std::int32_t h) : data(pixels), width(w), height(h), stride(w) {}
  constexpr ImageView(T* pixels, std::int32_t w, std::int32_t h, std::int32_t row_stride)
      : data(pixels), width(w), height(h), stride(row_stride) {}

  [[nodiscard]] T* row(std::int32_t y) const { return data + static_cast<std::ptrdiff_t>(y) * stride; }
  [[nodiscard]] T& at(std::int32_t x, std::int32_t y) const { return row(y)[x]; }
  [[nodiscard]] bool contains(std::int32_t x, std::int32_t y) const {
    return x >= 0 && y >= 0 && x < width && y < height;
  }
  [[nodiscard]] bool empty() const { return width <= 0 || height <= 0; }
  [[nodiscard]] std::size_t area() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  /// The rectangle with top-left pixel (x, y). The caller keeps it inside the image.
  [[nodiscard]] ImageView crop(std::int32_t x, std::int32_t y, std::int32_t w, std::int32_t h) const {
    return ImageView(row(y) + x, w, h, stride);
  }
  // A mutable view converts to a constant one.
  operator ImageView<const T>() const requires(!std::is_const_v<T>) {
    return ImageView<const T>(data, width, height, stride);
  }
};

template <typename A, typename B>
[[nodiscard]] constexpr bool same_size(const A& a, const B& b) {
  return a.width == b.width && a.height == b.height;
}

using GrayView = ImageView<const std::uint8_t>;
using MutableGrayView = ImageView<std::uint8_t>;
/// A mask: 0 is outside, any other value is inside.
using MaskView = ImageView<const std::uint8_t>;

/// Storage for an image of up to `Capacity` pixels, without gaps between rows. `Spare` further pixels follow for work
/// that needs more memory than the image.
template <typename T, std::size_t Capacity, std::size_t Spare = 0>
class FixedImage {
 public:
  /// Sets the size; the pixels are undefined. Returns `image_too_large` (values: width, height) beyond the capacity.
  [[nodiscard]] Status resize(std::int32_t width, std::int32_t height) {
    if (width < 0 || height < 0 || static_cast<std::size_t>(width) * static_cast<std::size_t>(height) > Capacity) {
      return {StatusCode::image_too_large, width, height};
    }
    width_ = width;
    height_ = height;
    return {};
  }
  [[nodiscard]] std::int32_t width() const { return width_; }
  [[nodiscard]] std::int32_t height() const { return height_; }
  [[nodiscard]] ImageView<T> view() { return {pixels_.data(), width_, height_}; }
  [[nodiscard]] ImageView<const T> view() const { return {pixels_.data(), width_, height_}; }
  /// All storage: the image's pixels and the unused ones after them.
  [[nodiscard]] std::span<T> storage() { return pixels_; }

 private:
  std::array<T, Capacity + Spare> pixels_{};
  std::int32_t width_ = 0;
  std::int32_t height_ = 0;
};

}  // namespace ilp
