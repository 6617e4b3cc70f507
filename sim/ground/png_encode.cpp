#include "sim/ground/png_encode.hpp"

#include <png.h>

#include <stdexcept>

namespace ilp::ground {
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

std::vector<std::uint8_t> png_bytes(const Raster<std::uint8_t>& grey) {
  return encode(grey.width, grey.height, grey.samples.data(), PNG_FORMAT_GRAY);
}

std::vector<std::uint8_t> png_bytes(const Raster<Rgba>& picture) {
  return encode(picture.width, picture.height, picture.samples.data(), PNG_FORMAT_RGBA);
}

std::string data_uri(const std::vector<std::uint8_t>& png) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string uri = "data:image/png;base64,";
  uri.reserve(uri.size() + (png.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < png.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = (group << 8U) | (i + k < png.size() ? png[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) {
      uri += i + k <= png.size() ? digits[(group >> (18 - 6 * k)) & 63U] : '=';
    }
  }
  return uri;
}

}  // namespace ilp::ground
