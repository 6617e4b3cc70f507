#include "sim/host/png_encode.hpp"

#include <png.h>

#include <stdexcept>

#include "sim/host/base64.hpp"

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

std::vector<std::uint8_t> png_bytes(const Raster<std::uint8_t>& grey) {
  return encode(grey.width, grey.height, grey.samples.data(), PNG_FORMAT_GRAY);
}

std::vector<std::uint8_t> png_bytes(const Raster<Rgba>& picture) {
  return encode(picture.width, picture.height, picture.samples.data(), PNG_FORMAT_RGBA);
}

std::string data_uri(const std::vector<std::uint8_t>& png) {
  return "data:image/png;base64," + base64(png);
}

}  // namespace ilp::host
