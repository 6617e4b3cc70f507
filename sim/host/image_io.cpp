#include "sim/host/image_io.hpp"

#include <png.h>

#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>

#include "hal/camera/directory/pgm.hpp"
#include "sim/host/files.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::host {
namespace fs = std::filesystem;
namespace {

static_assert(std::endian::native == std::endian::little, "PFM is written as it stands in memory");

[[noreturn]] void fail_image(const fs::path& path, const std::string& what) {
  throw std::runtime_error(path.string() + ": " + what);
}

bool is_png(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) fail_image(path, "cannot be read: " + read_failure(errno));
  unsigned char signature[8] = {};
  in.read(reinterpret_cast<char*>(signature), sizeof(signature));
  return in.gcount() == 8 && png_sig_cmp(signature, 0, 8) == 0;
}

struct PngImage {
  png_image image{};
  PngImage() { image.version = PNG_IMAGE_VERSION; }
  ~PngImage() { png_image_free(&image); }
  PngImage(const PngImage&) = delete;
  PngImage& operator=(const PngImage&) = delete;
};

void begin_png(const fs::path& path, PngImage& reader) {
  if (png_image_begin_read_from_file(&reader.image, path.c_str()) == 0) {
    fail_image(path, std::string("damaged PNG: ") + reader.image.message);
  }
  if (is_too_large(reader.image.width, reader.image.height)) {
    fail_image(
        path, "PNG of " + size_text(reader.image.width, reader.image.height) + " pixels, more than this program takes");
  }
}

Raster<std::uint8_t> read_png(const fs::path& path) {
  PngImage reader;
  begin_png(path, reader);
  reader.image.format = PNG_FORMAT_GRAY;
  Raster<std::uint8_t> result(static_cast<int>(reader.image.width), static_cast<int>(reader.image.height));
  if (png_image_finish_read(&reader.image, nullptr, result.samples.data(), 0, nullptr) == 0 ||
      PNG_IMAGE_FAILED(reader.image)) {
    fail_image(path, std::string("damaged PNG: ") + reader.image.message);
  }
  return result;
}

std::string next_word(std::istream& in) {
  std::string word;
  while (in >> word) {
    if (word[0] != '#') return word;
    in.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return {};
}

ImageSize read_pgm_header(const fs::path& path, std::istream& in) {
  if (next_word(in) != "P5") fail_image(path, "neither PNG nor binary PGM (P5)");
  constexpr int most[] = {static_cast<int>(largest_image_side), static_cast<int>(largest_image_side), 65535};
  int numbers[3] = {};
  for (int i = 0; i < 3; ++i) {
    std::istringstream text(next_word(in));
    if (!(text >> numbers[i]) || numbers[i] <= 0 || numbers[i] > most[i]) fail_image(path, "malformed PGM header");
  }
  if (numbers[2] != 255) fail_image(path, "PGM with a maximum of " + std::to_string(numbers[2]) + ", 255 expected");
  in.get();
  return {numbers[0], numbers[1]};
}

Raster<std::uint8_t> read_pgm_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  const ImageSize size = read_pgm_header(path, in);
  const auto pixels = static_cast<std::uintmax_t>(size.width) * static_cast<std::uintmax_t>(size.height);
  if (pixels > fs::file_size(path)) fail_image(path, "PGM ends early");
  Raster<std::uint8_t> result(size.width, size.height);
  in.read(reinterpret_cast<char*>(result.samples.data()), static_cast<std::streamsize>(result.samples.size()));
  if (in.gcount() != static_cast<std::streamsize>(result.samples.size())) fail_image(path, "PGM ends early");
  return result;
}

void save_png(const fs::path& path, int width, int height, png_uint_32 format, const void* pixels, int stride_bytes) {
  PngImage writer;
  writer.image.width = static_cast<png_uint_32>(width);
  writer.image.height = static_cast<png_uint_32>(height);
  writer.image.format = format;
  if (png_image_write_to_file(&writer.image, path.c_str(), 0, pixels, stride_bytes, nullptr) == 0) {
    const int cause = errno;
    fail_image(path, "cannot be written: " + (cause == ENOSPC ? write_failure(cause) : writer.image.message));
  }
}

std::ofstream create(const fs::path& path) {
  std::ofstream out(path, std::ios::binary);
  if (!out) fail_image(path, "cannot be written: " + write_failure(errno));
  return out;
}

}  // namespace

Raster<std::uint8_t> read_gray(const fs::path& path) {
  return is_png(path) ? read_png(path) : read_pgm_file(path);
}

ImageSize read_image_size(const fs::path& path) {
  if (is_png(path)) {
    PngImage reader;
    begin_png(path, reader);
    return {static_cast<int>(reader.image.width), static_cast<int>(reader.image.height)};
  }
  std::ifstream in(path, std::ios::binary);
  return read_pgm_header(path, in);
}

void write_png(const fs::path& path, ImageView<const std::uint8_t> gray) {
  save_png(path, gray.width, gray.height, PNG_FORMAT_GRAY, gray.data, gray.stride);
}

void write_png(const fs::path& path, ImageView<const Rgb> picture) {
  static_assert(sizeof(Rgb) == 3);
  save_png(path, picture.width, picture.height, PNG_FORMAT_RGB, picture.data, 3 * picture.stride);
}

void write_pgm(const fs::path& path, ImageView<const std::uint8_t> gray) {
  std::ofstream out = create(path);
  out << "P5\n" << gray.width << " " << gray.height << "\n255\n";
  for (int y = 0; y < gray.height; ++y) out.write(reinterpret_cast<const char*>(gray.row(y)), gray.width);
  if (!out.flush()) fail_image(path, "cannot be written: " + write_failure(errno));
}

std::vector<std::uint8_t> pfm_bytes(ImageView<const float> values) {
  const std::string header = "Pf\n" + std::to_string(values.width) + " " + std::to_string(values.height) + "\n-1.0\n";
  const auto row_bytes = sizeof(float) * static_cast<std::size_t>(values.width);
  std::vector<std::uint8_t> bytes(header.begin(), header.end());
  bytes.reserve(header.size() + row_bytes * static_cast<std::size_t>(values.height));
  for (int y = values.height - 1; y >= 0; --y) {
    const auto* row = reinterpret_cast<const std::uint8_t*>(values.row(y));
    bytes.insert(bytes.end(), row, row + row_bytes);
  }
  return bytes;
}

void write_pfm(const fs::path& path, ImageView<const float> values) {
  const std::vector<std::uint8_t> bytes = pfm_bytes(values);
  std::ofstream out = create(path);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) fail_image(path, "cannot be written: " + write_failure(errno));
}

Raster<float> read_pfm(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) fail_image(path, "cannot be read: " + read_failure(errno));
  std::string magic;
  int width = 0;
  int height = 0;
  double scale = 0;
  in >> magic >> width >> height >> scale;
  const int side = static_cast<int>(largest_image_side);
  if (!in || magic != "Pf" || width <= 0 || height <= 0 || width > side || height > side || !(scale < 0)) {
    fail_image(path, "not a one-channel little-endian PFM");
  }
  in.get();
  const auto samples = static_cast<std::uintmax_t>(width) * static_cast<std::uintmax_t>(height);
  if (samples * sizeof(float) > fs::file_size(path)) fail_image(path, "PFM ends early");
  Raster<float> result(width, height);
  for (int y = height - 1; y >= 0; --y) {
    const auto size = static_cast<std::streamsize>(sizeof(float)) * width;
    in.read(reinterpret_cast<char*>(&result.at(0, y)), size);
    if (in.gcount() != size) fail_image(path, "PFM ends early");
  }
  return result;
}

Status decode_image(const char* path, FrameImage& image) {
  try {
    if (!is_png(path)) return read_pgm(path, image);
    const ImageSize size = read_image_size(path);
    ILP_TRY(image.resize(size.width, size.height));
    const Raster<std::uint8_t> png = read_png(path);
    std::memcpy(image.view().data, png.samples.data(), png.samples.size());
    return {};
  } catch (const std::exception&) {
    std::error_code error;
    return fs::exists(path, error) ? StatusCode::parse_error : StatusCode::not_found;
  }
}

}  // namespace ilp::host
