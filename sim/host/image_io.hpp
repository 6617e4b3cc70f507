// Reads and writes image files (PNG, PGM, PFM) for host code. Functions throw std::runtime_error that names the file
// and what was expected.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "fsw/base/image_view.hpp"
#include "hal/camera/camera.hpp"
#include "sim/host/raster.hpp"

namespace ilp::host {

struct ImageSize {
  int width = 0;
  int height = 0;
  bool operator==(const ImageSize&) const = default;
};

/// Larger images are refused before memory is allocated, because a forged header of a few bytes could claim gigabytes.
inline constexpr std::int64_t largest_image_side = 32768, most_image_pixels = std::int64_t{1} << 28U;
[[nodiscard]] inline bool is_too_large(std::int64_t width, std::int64_t height) {
  return width > largest_image_side || height > largest_image_side || width * height > most_image_pixels;
}

/// Reads a PNG (any colour type, converted to 8-bit grey) or a binary PGM, recognised by content.
Raster<std::uint8_t> read_gray(const std::filesystem::path& path);
/// The size that the header states; the pixels may still be damaged.
ImageSize read_image_size(const std::filesystem::path& path);
void write_png(const std::filesystem::path& path, ImageView<const std::uint8_t> gray);
void write_png(const std::filesystem::path& path, ImageView<const Rgb> picture);
void write_pgm(const std::filesystem::path& path, ImageView<const std::uint8_t> gray);

/// Portable float map, one channel, little-endian; rows are stored from the bottom, as the format wants.
Raster<float> read_pfm(const std::filesystem::path& path);
[[nodiscard]] std::vector<std::uint8_t> pfm_bytes(ImageView<const float> values);
void write_pfm(const std::filesystem::path& path, ImageView<const float> values);

/// Decodes PNG and PGM for DirectoryCamera. Throws nothing. Returns `not_found` if the file does not exist,
/// `image_too_large` if it exceeds the flight's limits, `parse_error` if it is damaged, and the codes of read_pgm for
/// PGM.
Status decode_image(const char* path, FrameImage& image);

}  // namespace ilp::host
