#include "fsw/vision/codec/layer_errors.hpp"

#include "fsw/base/argument.hpp"
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
    const std::uint32_t square = static_cast<std::uint32_t>(error) * static_cast<std::uint32_t>(error);
    squares += square;
    pixels += static_cast<std::uint32_t>(counts);
  }
  if (largest > sums.largest) sums.largest = largest;
  sums.squares += squares;
  sums.pixels += pixels;
}

/// What a layer is compared with, and where.
template <typename Pixel>
struct Comparison {
  ImageView<const Pixel> original;
  MaskView mask;
  ErrorSums sums{};

  void add(ImageView<const std::int32_t> decoded) {
    with_widest_vectors([&] {
      for (std::int32_t y = 0; y < decoded.height; ++y) {
        const std::uint8_t* const inside = mask.data == nullptr ? nullptr : mask.row(y);
        add_row(decoded.row(y), original.row(y), inside, decoded.width, sums);
      }
    });
  }
};

template <typename Pixel>
Status measure(std::span<const std::uint8_t> file, ImageView<const Pixel> samples, MaskView mask, LayerErrors& errors,
               std::int32_t enough) {
  errors = {};
  Jpeg2000Info info;
  ILP_TRY(parse_jp2(file, info));
  if (samples.width != info.width || samples.height != info.height || info.bits > max_sample_bits ||
      info.layers > limits::max_quality_layers) {
    return out_of_range(Argument::image_size, samples.width);
  }
  if (mask.data != nullptr && (mask.width != info.width || mask.height != info.height)) {
    return out_of_range(Argument::mask_size, mask.width);
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(info.layers); ++i) {
    Comparison<Pixel> comparison{samples, mask};
    Decoding decoding{info.width, info.height, false, static_cast<int>(i) + 1, nullptr, &comparison};
    decoding.take = [](ImageView<const std::int32_t> decoded, void* context) {
      static_cast<Comparison<Pixel>*>(context)->add(decoded);
    };
    ILP_TRY(openjpeg_decode(info.codestream, decoding));
    const ErrorSums& sums = comparison.sums;
    errors.layers = static_cast<int>(i) + 1;
    errors.largest[i] = sums.largest;
    errors.mean_square[i] = sums.pixels == 0 ? 0 : static_cast<double>(sums.squares) / static_cast<double>(sums.pixels);
    if (errors.largest[i] <= enough) break;
  }
  return {};
}

}  // namespace

Status measure_layer_errors(std::span<const std::uint8_t> file, GrayView samples, MaskView mask, LayerErrors& errors) {
  return measure(file, samples, mask, errors, -1);
}

Status measure_layer_errors(std::span<const std::uint8_t> file, ImageView<const std::uint16_t> samples, MaskView mask,
                            LayerErrors& errors, std::int32_t enough) {
  return measure(file, samples, mask, errors, enough);
}

double psnr_of(double mean_square) {
  constexpr double ln10 = 2.30258509299404568402;
  if (!(mean_square > 0)) return exact_psnr_db;
  const double db = 10 / ln10 * det_log(255.0 * 255.0 / mean_square);
  return db < exact_psnr_db ? db : exact_psnr_db;
}

}  // namespace ilp
