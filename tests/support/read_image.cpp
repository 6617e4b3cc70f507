#include "tests/support/read_image.hpp"

#include <png.h>

#include <bit>
#include <cstdio>
#include <fstream>
#include <limits>

namespace ilp::test {
namespace {

Image read_pgm(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string magic;
  std::int32_t header[3] = {};
  file >> magic;
  for (std::int32_t& value : header) {
    file >> std::ws;
    while (file.peek() == '#') {
      file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
      file >> std::ws;
    }
    file >> value;
  }
  file.get();
  if (!file || magic != "P5" || header[2] != 255 || header[0] <= 0 || header[1] <= 0) return {};
  Image image(header[0], header[1]);
  file.read(reinterpret_cast<char*>(image.pixels.data()), static_cast<std::streamsize>(image.pixels.size()));
  return file ? image : Image{};
}

Image read_png(const std::string& path) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&png, path.c_str()) == 0) return {};
  png.format = PNG_FORMAT_GRAY;
  Image image(static_cast<std::int32_t>(png.width), static_cast<std::int32_t>(png.height));
  return png_image_finish_read(&png, nullptr, image.pixels.data(), 0, nullptr) != 0 ? image : Image{};
}

// All of libpng's calls that can jump, in a frame of their own: nothing here outlives the jump.
__attribute__((noinline)) void decode16(png_structp png, png_infop info, std::FILE* handle, Image16& image) {
  png_init_io(png, handle);
  png_read_info(png, info);
  if (png_get_bit_depth(png, info) != 16 || png_get_color_type(png, info) != PNG_COLOR_TYPE_GRAY) return;
  if constexpr (std::endian::native == std::endian::little) png_set_swap(png);
  image.width = static_cast<std::int32_t>(png_get_image_width(png, info));
  image.height = static_cast<std::int32_t>(png_get_image_height(png, info));
  image.pixels.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  for (std::int32_t y = 0; y < image.height; ++y) {
    const std::ptrdiff_t start = static_cast<std::ptrdiff_t>(y) * image.width;
    png_read_row(png, reinterpret_cast<png_bytep>(image.pixels.data() + start), nullptr);
  }
}

}  // namespace

Image read_image(const std::string& path) {
  return path.ends_with(".pgm") ? read_pgm(path) : read_png(path);
}

Image16 read_image16(const std::string& path) {
  Image16 image;
  std::FILE* const handle = std::fopen(path.c_str(), "rb");
  if (handle == nullptr) return image;
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  if (setjmp(png_jmpbuf(png)) == 0) {
    decode16(png, info, handle, image);
  } else {
    image.pixels.clear();
  }
  png_destroy_read_struct(&png, &info, nullptr);
  std::fclose(handle);
  return image;
}

}  // namespace ilp::test
