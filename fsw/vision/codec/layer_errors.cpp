#include "fsw/vision/codec/layer_errors.hpp"

#include "fsw/base/math.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/codec/jp2_file.hpp"
#include "fsw/vision/codec/openjpeg_codec.hpp"

namespace ilp {
namespace {

struct ErrorSums {
  std::int32_t largest = 0;
  std::uint64_t squares = 0;
  std::uint64_t pixels = 0;
};

template <typename Pixel>
void add_row(const std::int32_t* decoded, const Pixel* original, const std::uint8_t* mask, std::int32_t width,
             ErrorSums& sums) {
  std::int32_t largest = 0;
  std::uint32_t pixels = 0;
  std::uint64_t squares = 0;
  for (std::int32_t x = 0; x < width; ++x) {
    const std::int32_t counts = mask == nullptr || mask[x] != 0 ? 1 : 0;
    const std::int32_t difference = (decoded[x] - static_cast<std::int32_t>(original[x])) * counts;
    const std::int32_t error = difference < 0 ? -difference : difference;
    largest = error > largest ? error : largest;
    // Samples have 16 bits at most, and so has the difference: the square fits.
    squares += static_cast<std::uint32_t>(error) * static_cast<std::uint32_t>(error);
    pixels += static_cast<std::uint32_t>(counts);
  }
  if (largest > sums.largest) sums.largest = largest;
  sums.squares += squares;
  sums.pixels += pixels;
}

template <typename Pixel>
void compare(ImageView<const std::int32_t> decoded, ImageView<const Pixel> original, MaskView mask,
             std::int32_t& largest, double& mean_square) {
  ErrorSums sums;
  with_widest_vectors([&] {
    for (std::int32_t y = 0; y < original.height; ++y) {
      if (mask.data == nullptr) {
        add_row(decoded.row(y), original.row(y), nullptr, original.width, sums);
      } else {
        add_row(decoded.row(y), original.row(y), mask.row(y), original.width, sums);
      }
    }
  });
  largest = sums.largest;
  mean_square = sums.pixels == 0 ? 0 : static_cast<double>(sums.squares) / static_cast<double>(sums.pixels);
}

template <typename Pixel>
Status measure(std::span<const std::uint8_t> file, ImageView<const Pixel> samples, MaskView mask,
               Jpeg2000Workspace& workspace, LayerErrors& errors, std::int32_t enough) {
  errors = {};
  Jpeg2000Info info;
  ILP_TRY(parse_jp2(file, info));
  if (samples.width != info.width || samples.height != info.height || info.bits > max_sample_bits ||
      info.layers > limits::max_quality_layers || samples.area() > limits::max_image_pixels) {
    return {StatusCode::invalid_argument, samples.width, samples.height};
  }
  if (mask.data != nullptr && (mask.width != info.width || mask.height != info.height)) {
    return {StatusCode::invalid_argument, mask.width, mask.height};
  }
  const ImageView<std::int32_t> decoded(workspace.samples.data(), info.width, info.height);
  for (int layer = 0; layer < info.layers; ++layer) {
    ILP_TRY(openjpeg_decode(info.codestream, false, layer + 1, decoded));
    const auto i = static_cast<std::size_t>(layer);
    compare(ImageView<const std::int32_t>(decoded), samples, mask, errors.largest[i], errors.mean_square[i]);
    errors.layers = layer + 1;
    if (errors.largest[i] <= enough) break;
  }
  return {};
}

}  // namespace

Status measure_layer_errors(std::span<const std::uint8_t> file, GrayView samples, MaskView mask,
                            Jpeg2000Workspace& workspace, LayerErrors& errors) {
  return measure(file, samples, mask, workspace, errors, -1);
}

Status measure_layer_errors(std::span<const std::uint8_t> file, ImageView<const std::uint16_t> samples, MaskView mask,
                            Jpeg2000Workspace& workspace, LayerErrors& errors, std::int32_t enough) {
  return measure(file, samples, mask, workspace, errors, enough);
}

double psnr_of(double mean_square) {
  constexpr double ln10 = 2.30258509299404568402;
  if (!(mean_square > 0)) return exact_psnr_db;
  const double db = 10 / ln10 * det_log(255.0 * 255.0 / mean_square);
  return db < exact_psnr_db ? db : exact_psnr_db;
}

}  // namespace ilp
