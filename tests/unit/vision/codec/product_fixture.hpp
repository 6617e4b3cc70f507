// Pictures, masks and depth maps for products, a fixture that codes and decodes them, and pictures of other programs.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "fsw/vision/codec/jpeg2000.hpp"
#include "fsw/vision/codec/jpeg2000_decode.hpp"
#include "tests/support/strip.hpp"

namespace ilp::test {

template <typename Pixel>
struct Picture {
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::vector<Pixel> pixels;
  Picture(std::int32_t w, std::int32_t h)
      : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
  [[nodiscard]] ImageView<const Pixel> view() const { return {pixels.data(), width, height}; }
  Pixel& at(std::int32_t x, std::int32_t y) {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
};
using Mask = Picture<std::uint8_t>;
using Depth = Picture<std::uint16_t>;
using Decoded = Picture<std::int32_t>;

inline Image textured_image(std::int32_t width, std::int32_t height) {
  return render_texture(width, height, {1, 0.1, 0, 0}, 1.0, 0.0, 1.5, 4);
}

// Fine detail everywhere and no noise: bytes are what quality depends on.
inline Image detailed_image(std::int32_t width, std::int32_t height) {
  return render_texture(width, height, {4, 0.1, 0, 0}, 1.0, 0.0, 0.0, 4);
}

// Heights with hills, and holes where `mask` is 0.
inline Depth depth_map(std::int32_t width, std::int32_t height, int bits) {
  Depth depth(width, height);
  const double full = std::ldexp(1.0, bits) - 1;
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      const double t = 0.5 + 0.3 * std::sin(x * 0.021) * std::cos(y * 0.017) + 0.1 * std::sin(x * 0.11 + y * 0.07);
      depth.at(x, y) = static_cast<std::uint16_t>(std::lround(t * full));
    }
  }
  return depth;
}

/// A disc that covers about `share` of the image, or everything.
inline Mask disc_mask(std::int32_t width, std::int32_t height, double share) {
  Mask mask(width, height);
  const double radius2 = share >= 1 ? 1e9 : share * width * height / 3.14159;
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      const double dx = x - 0.45 * width;
      const double dy = y - 0.5 * height;
      mask.at(x, y) = dx * dx + dy * dy < radius2 ? 255 : 0;
    }
  }
  return mask;
}

class Jpeg2000Test : public ::testing::Test {
 protected:
  Jpeg2000Test() : workspace(std::make_unique<Jpeg2000Workspace>()), file(limits::max_product_bytes) {}

  Status encode(GrayView image, MaskView mask, const Jpeg2000Params& params) {
    return encode_jpeg2000(image, mask, params, metadata, *workspace, file, product);
  }
  Status encode(const Depth& depth, int bits, MaskView mask, const Jpeg2000Params& params) {
    return encode_jpeg2000(depth.view(), bits, mask, params, metadata, *workspace, file, product);
  }
  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return std::span(file).first(product.bytes); }
  [[nodiscard]] Decoded decode() const { return decode(bytes()); }
  static Decoded decode(std::span<const std::uint8_t> data) {
    Jpeg2000Info info;
    EXPECT_TRUE(read_jpeg2000_header(data, info).ok());
    Decoded samples(info.width, info.height);
    const Status status = decode_jpeg2000(data, false, {samples.pixels.data(), info.width, info.height});
    EXPECT_TRUE(status.ok()) << status_name(status.code) << " stage " << status.b;
    return samples;
  }

  std::unique_ptr<Jpeg2000Workspace> workspace;
  std::vector<std::uint8_t> file;
  std::vector<std::uint8_t> metadata;
  Jpeg2000Product product;
};

template <typename Pixel>
double psnr(const ImageView<const Pixel>& image, const Decoded& decoded, MaskView mask, bool inside) {
  double sum = 0;
  double count = 0;
  for (std::int32_t y = 0; y < image.height; ++y) {
    for (std::int32_t x = 0; x < image.width; ++x) {
      if ((mask.at(x, y) != 0) != inside) continue;
      const double e = static_cast<double>(decoded.view().at(x, y)) - image.at(x, y);
      sum += e * e;
      count += 1;
    }
  }
  return 10 * std::log10(255.0 * 255.0 * count / (sum + 1e-9));
}

inline std::size_t bytes_for(double bits_per_pixel, const GrayView& image) {
  return static_cast<std::size_t>(bits_per_pixel * static_cast<double>(image.area()) / 8);
}

struct Pgm {
  int maximum = 0;
  Decoded samples{0, 0};
};

inline Pgm read_pgm(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string magic;
  int width = 0;
  int height = 0;
  Pgm pgm;
  if (!(in >> magic) || magic != "P5") return pgm;
  while ((in >> std::ws).peek() == '#') std::getline(in, magic);
  if (!(in >> width >> height >> pgm.maximum) || width < 1 || height < 1) return pgm;
  in.get();
  pgm.samples = Decoded(width, height);
  for (auto& v : pgm.samples.pixels) {
    v = in.get();
    if (pgm.maximum > 255) v = v * 256 + in.get();
  }
  return pgm;
}

}  // namespace ilp::test
