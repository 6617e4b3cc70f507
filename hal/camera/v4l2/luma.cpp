#include "hal/camera/v4l2/luma.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cstring>

namespace ilp {
namespace {

constexpr PixelFormat formats[] = {{V4L2_PIX_FMT_GREY, "GREY", 1, 8},
                                   {V4L2_PIX_FMT_Y10, "Y10", 2, 10},
                                   {V4L2_PIX_FMT_Y12, "Y12", 2, 12},
                                   {V4L2_PIX_FMT_Y16, "Y16", 2, 16},
                                   {V4L2_PIX_FMT_YUYV, "YUYV", 2, 8}};

void copy_first_bytes(const std::uint8_t* from, std::uint8_t* to, std::int32_t width) {
  for (std::ptrdiff_t x = 0; x < width; ++x) to[x] = from[2 * x];
}

void copy_high_bits(const std::uint8_t* from, int shift, std::uint8_t* to, std::int32_t width) {
  for (std::ptrdiff_t x = 0; x < width; ++x) {
    const std::uint32_t value = from[2 * x] | static_cast<std::uint32_t>(from[2 * x + 1]) << 8U;
    to[x] = static_cast<std::uint8_t>(std::min(value >> shift, 255U));
  }
}

}  // namespace

std::span<const PixelFormat> pixel_formats() {
  return formats;
}

const PixelFormat* find_pixel_format(const char* name) {
  for (const PixelFormat& format : formats) {
    if (std::strcmp(format.name, name) == 0) return &format;
  }
  return nullptr;
}

void copy_luma(const PixelFormat& format, std::span<const std::uint8_t> from, std::size_t stride, MutableGrayView to) {
  for (std::int32_t y = 0; y < to.height; ++y) {
    const std::uint8_t* const row = from.data() + static_cast<std::size_t>(y) * stride;
    if (format.bytes == 1) {
      std::memcpy(to.row(y), row, static_cast<std::size_t>(to.width));
    } else if (format.bits == 8) {
      copy_first_bytes(row, to.row(y), to.width);
    } else {
      copy_high_bits(row, format.bits - 8, to.row(y), to.width);
    }
  }
}

}  // namespace ilp
