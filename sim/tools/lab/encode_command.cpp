// encode: encodes an image as a JP2 file with a region of interest.

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>

#include "fsw/vision/codec/jpeg2000.hpp"
#include "fsw/vision/codec/jpeg2000_decode.hpp"
#include "fsw/vision/codec/layer_errors.hpp"
#include "sim/host/files.hpp"
#include "sim/host/status_error.hpp"
#include "sim/tools/lab/input_files.hpp"
#include "sim/tools/lab/lab.hpp"

namespace ilp::lab {
namespace {

struct EncodeOptions {
  std::string image, mask, out;
  double bpp = 0;
  bool drop = false;
  Jpeg2000Params params;
};

constexpr double default_bpp = 1;

/// PSNR of an 8-bit image; infinite if all pixels are equal, NaN if there are no pixels.
struct Psnr {
  double squares = 0;
  std::size_t pixels = 0;

  void add(double difference) {
    squares += difference * difference;
    ++pixels;
  }
  [[nodiscard]] double db() const {
    if (pixels == 0) return std::numeric_limits<double>::quiet_NaN();
    return 10 * std::log10(255.0 * 255.0 * static_cast<double>(pixels) / squares);
  }
};

void measure_quality(const GrayImage& image, const GrayImage& mask, std::span<const std::uint8_t> file, Psnr& inside,
                     Psnr& outside) {
  host::Raster<std::int32_t> decoded(image.width, image.height);
  host::require(decode_jpeg2000(file, false, decoded.view()), "decoding the result");
  for (std::size_t i = 0; i < image.samples.size(); ++i) {
    const int value = std::clamp(decoded.samples[i], 0, 255);
    const bool is_inside = mask.samples.empty() || mask.samples[i] != 0;
    (is_inside ? inside : outside).add(static_cast<double>(value - image.samples[i]));
  }
}

void write_bytes(const std::string& path, std::span<const std::uint8_t> bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) throw std::runtime_error(path + " cannot be written: " + host::write_failure(errno));
}

Jpeg2000Params params_for(const EncodeOptions& options, const GrayImage& image) {
  Jpeg2000Params params = options.params;
  const double bpp = options.bpp > 0 ? options.bpp : default_bpp;
  const bool unlimited = params.lossless && options.bpp <= 0;
  const double ceiling = std::floor(bpp * static_cast<double>(image.samples.size()) / 8);
  params.max_bytes =
      unlimited ? limits::max_product_bytes : std::min(static_cast<std::size_t>(ceiling), limits::max_product_bytes);
  if (options.drop) params.region = RegionCoding::drop_background;
  if (options.mask.empty()) params.region = RegionCoding::none;
  return params;
}

Json run_encode(const EncodeOptions& options, int repeat) {
  if (options.drop && options.mask.empty()) throw UsageError("--drop-background needs --mask");
  const GrayImage image = read_camera_image(options.image);
  const GrayImage mask = read_mask(options.mask, image, options.image);
  const Jpeg2000Params params = params_for(options, image);
  const auto workspace = std::make_unique<Jpeg2000Workspace>();
  std::vector<std::uint8_t> file(limits::max_product_bytes);
  Jpeg2000Product product;
  Status status;
  const double kernel_ms = time_kernel(
      repeat, [&] { product = {}; },
      [&] { status = encode_jpeg2000(image.view(), mask.view(), params, {}, *workspace, file, product); });
  const std::string verdict = verdict_of(status, "encode");
  Psnr inside, outside;
  Json layers = Json::array(), layer_quality = Json::array();
  if (status.ok()) {
    const std::span<const std::uint8_t> coded(file.data(), product.bytes);
    measure_quality(image, mask, coded, inside, outside);
    write_bytes(options.out, coded);
    LayerErrors errors;
    host::require(measure_layer_errors(coded, image.view(), mask.view(), errors),
                  "measuring the layers of " + options.image);
    for (std::size_t i = 0; i < static_cast<std::size_t>(product.layers); ++i) {
      layers.push_back(product.layer_bytes[i]);
      layer_quality.push_back(psnr_of(errors.mean_square[i]));
    }
  }
  return {{"verdict", verdict},
          {"bytes", product.bytes},
          {"max_bytes", params.max_bytes},
          {"bpp", 8.0 * static_cast<double>(product.bytes) / static_cast<double>(image.samples.size())},
          {"shift", product.shift},
          {"layer_bytes", layers},
          {"layer_psnr_inside_db", layer_quality},
          {"psnr_inside_db", inside.db()},
          {"psnr_outside_db", outside.db()},
          {"exact_inside", inside.pixels > 0 && inside.squares == 0},
          {"pixels_inside", inside.pixels},
          {"pixels_outside", outside.pixels},
          {"kernel_ms", kernel_ms}};
}

}  // namespace

void add_encode_command(Lab& lab) {
  const auto options = std::make_shared<EncodeOptions>();
  CLI::App& app =
      lab.add("encode", "an image as a JP2 file; a PSNR is null when the region is exact or empty",
              "0001.png --bpp 0.5 --out 0001.jp2", [options](int repeat) { return run_encode(*options, repeat); });
  app.add_option("IMAGE", options->image, "PNG, PGM, JPEG or TIFF")->required();
  app.add_option("--mask", options->mask, "image whose pixels other than 0 are the region of interest");
  app.add_option("--bpp", options->bpp, "ceiling of the whole file in bit/px (default 1; with --lossless: none)")
      ->check(finite_in(0.001, 32))
      ->default_str("");
  app.add_option("--layers", options->params.layers, "number of quality layers")
      ->check(CLI::Range(1, limits::max_quality_layers));
  app.add_flag("--lossless", options->params.lossless, "code the region exactly; without a mask, the whole image");
  app.add_flag("--drop-background", options->drop, "code nothing outside the mask");
  app.add_option("--out", options->out, "JP2 file to write")->required();
}

}  // namespace ilp::lab
