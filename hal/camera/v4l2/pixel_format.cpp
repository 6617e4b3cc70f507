#include "hal/camera/v4l2/pixel_format.hpp"

#include <linux/videodev2.h>

#include <cstring>

namespace ilp {
namespace {

// In newer headers of the kernel only.
constexpr std::uint32_t y12_packed = v4l2_fourcc('Y', '1', '2', 'P');

constexpr PixelFormat grey(std::uint32_t fourcc, const char* name, Packing packing, std::uint8_t bits) {
  return {fourcc, name, packing, bits, false, 1, 0};
}

constexpr PixelFormat luma(std::uint32_t fourcc, const char* name, std::uint8_t step, std::uint8_t offset) {
  return {fourcc, name, Packing::bytes, 8, false, step, offset};
}

constexpr PixelFormat bayer(std::uint32_t fourcc, const char* name, Packing packing, std::uint8_t bits) {
  return {fourcc, name, packing, bits, true, 1, 0};
}

constexpr PixelFormat formats[] = {
    grey(V4L2_PIX_FMT_GREY, "GREY", Packing::bytes, 8),
    grey(V4L2_PIX_FMT_Y10, "Y10", Packing::words, 10),
    grey(V4L2_PIX_FMT_Y12, "Y12", Packing::words, 12),
    grey(V4L2_PIX_FMT_Y16, "Y16", Packing::words, 16),
    grey(V4L2_PIX_FMT_Y10P, "Y10P", Packing::mipi10, 10),
    grey(y12_packed, "Y12P", Packing::mipi12, 12),
    luma(V4L2_PIX_FMT_YUYV, "YUYV", 2, 0),
    luma(V4L2_PIX_FMT_UYVY, "UYVY", 2, 1),
    luma(V4L2_PIX_FMT_YVYU, "YVYU", 2, 0),
    luma(V4L2_PIX_FMT_VYUY, "VYUY", 2, 1),
    luma(V4L2_PIX_FMT_NV12, "NV12", 1, 0),
    luma(V4L2_PIX_FMT_NV21, "NV21", 1, 0),
    luma(V4L2_PIX_FMT_NV16, "NV16", 1, 0),
    luma(V4L2_PIX_FMT_YUV420, "YUV420", 1, 0),
    luma(V4L2_PIX_FMT_YVU420, "YVU420", 1, 0),
    luma(V4L2_PIX_FMT_YUV422P, "YUV422P", 1, 0),
    grey(V4L2_PIX_FMT_MJPEG, "MJPEG", Packing::jpeg, 8),
    grey(V4L2_PIX_FMT_JPEG, "JPEG", Packing::jpeg, 8),
    bayer(V4L2_PIX_FMT_SBGGR8, "SBGGR8", Packing::bytes, 8),
    bayer(V4L2_PIX_FMT_SGBRG8, "SGBRG8", Packing::bytes, 8),
    bayer(V4L2_PIX_FMT_SGRBG8, "SGRBG8", Packing::bytes, 8),
    bayer(V4L2_PIX_FMT_SRGGB8, "SRGGB8", Packing::bytes, 8),
    bayer(V4L2_PIX_FMT_SBGGR10, "SBGGR10", Packing::words, 10),
    bayer(V4L2_PIX_FMT_SGBRG10, "SGBRG10", Packing::words, 10),
    bayer(V4L2_PIX_FMT_SGRBG10, "SGRBG10", Packing::words, 10),
    bayer(V4L2_PIX_FMT_SRGGB10, "SRGGB10", Packing::words, 10),
    bayer(V4L2_PIX_FMT_SBGGR10P, "SBGGR10P", Packing::mipi10, 10),
    bayer(V4L2_PIX_FMT_SGBRG10P, "SGBRG10P", Packing::mipi10, 10),
    bayer(V4L2_PIX_FMT_SGRBG10P, "SGRBG10P", Packing::mipi10, 10),
    bayer(V4L2_PIX_FMT_SRGGB10P, "SRGGB10P", Packing::mipi10, 10),
    bayer(V4L2_PIX_FMT_SBGGR12, "SBGGR12", Packing::words, 12),
    bayer(V4L2_PIX_FMT_SGBRG12, "SGBRG12", Packing::words, 12),
    bayer(V4L2_PIX_FMT_SGRBG12, "SGRBG12", Packing::words, 12),
    bayer(V4L2_PIX_FMT_SRGGB12, "SRGGB12", Packing::words, 12),
    bayer(V4L2_PIX_FMT_SBGGR12P, "SBGGR12P", Packing::mipi12, 12),
    bayer(V4L2_PIX_FMT_SGBRG12P, "SGBRG12P", Packing::mipi12, 12),
    bayer(V4L2_PIX_FMT_SGRBG12P, "SGRBG12P", Packing::mipi12, 12),
    bayer(V4L2_PIX_FMT_SRGGB12P, "SRGGB12P", Packing::mipi12, 12),
    bayer(V4L2_PIX_FMT_SBGGR16, "SBGGR16", Packing::words, 16),
    bayer(V4L2_PIX_FMT_SGBRG16, "SGBRG16", Packing::words, 16),
    bayer(V4L2_PIX_FMT_SGRBG16, "SGRBG16", Packing::words, 16),
    bayer(V4L2_PIX_FMT_SRGGB16, "SRGGB16", Packing::words, 16),
};

}  // namespace

std::span<const PixelFormat> pixel_formats() {
  return formats;
}

const PixelFormat* find_pixel_format(const char* name) {
  for (const PixelFormat& format : formats) {
    if (std::strcmp(format.name, name) == 0 || std::strcmp(fourcc_text(format.fourcc).text, name) == 0) return &format;
  }
  return nullptr;
}

std::size_t row_bytes(const PixelFormat& format, std::int32_t width) {
  const auto pixels = static_cast<std::size_t>(width);
  switch (format.packing) {
    case Packing::bytes:
      return pixels * format.step;
    case Packing::words:
      return pixels * 2;
    case Packing::mipi10:
      return (pixels + 3) / 4 * 5;
    case Packing::mipi12:
      return (pixels + 1) / 2 * 3;
    case Packing::jpeg:
      break;
  }
  return 0;
}

std::size_t period_bytes(const PixelFormat& format) {
  if (format.packing == Packing::mipi10) return 5;
  return format.packing == Packing::mipi12 ? 3 : 4;
}

FourccText fourcc_text(std::uint32_t fourcc) {
  FourccText code;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto c = static_cast<char>((fourcc >> 8 * i) & 0x7FU);
    code.text[i] = c < ' ' || c > '~' ? '?' : c;
  }
  for (std::size_t i = 4; i > 0 && code.text[i - 1] == ' '; --i) code.text[i - 1] = 0;
  return code;
}

}  // namespace ilp
