#include "fsw/vision/codec/layer_errors.hpp"

#include <algorithm>

#include "fsw/base/argument.hpp"
#include "fsw/base/math.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/codec/jp2_file.hpp"
#include "fsw/vision/codec/layer_decoder.hpp"
#include "fsw/vision/codec/openjpeg_codec.hpp"

namespace ilp {
namespace {

struct ErrorSums {
  std::int32_t largest = 0;
  std::uint64_t squares = 0;
  std::uint64_t pixels = 0;
};

/// `decoded` are signed about `zero`, and limited to 0 ... `most` as a decoder does.
template <typename Pixel>
void add_row(const std::int32_t* decoded, std::int32_t zero, std::int32_t most, const Pixel* original,
             const std::uint8_t* mask, std::int32_t width, ErrorSums& sums) {
  std::int32_t largest = 0;
  std::uint32_t pixels = 0;
  std::uint64_t squares = 0;
  for (std::int32_t x = 0; x < width; ++x) {
    const std::int32_t counts = mask == nullptr || mask[x] != 0 ? 1 : 0;
    const std::int32_t raised = decoded[x] + zero;
    const std::int32_t sample = raised < 0 ? 0 : raised > most ? most : raised;
    const std::int32_t difference = (sample - static_cast<std::int32_t>(original[x])) * counts;
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

/// What is measured: the product, its original, and where they are compared.
template <typename Pixel>
struct Comparison {
  Jpeg2000Info info;
  ImageView<const Pixel> original;
  MaskView mask;
  SampleWindow window;  ///< around all pixels of the mask
  std::int32_t enough = -1;

  /// `decoded` has the samples of the window.
  void measure(ImageView<const std::int32_t> decoded, std::int32_t zero, int layer, LayerErrors& errors) const {
    const std::int32_t most = (std::int32_t{1} << info.bits) - 1;
    const std::int32_t width = window.x1 - window.x0;
    ErrorSums sums;
    with_widest_vectors([&] {
      for (std::int32_t y = window.y0; y < window.y1; ++y) {
        const std::int32_t* const row = decoded.row(y - window.y0);
        const Pixel* const wanted = original.row(y) + window.x0;
        if (mask.data == nullptr) {
          add_row(row, zero, most, wanted, nullptr, width, sums);
        } else {
          add_row(row, zero, most, wanted, mask.row(y) + window.x0, width, sums);
        }
      }
    });
    const auto i = static_cast<std::size_t>(layer);
    errors.largest[i] = sums.largest;
    errors.mean_square[i] = sums.pixels == 0 ? 0 : static_cast<double>(sums.squares) / static_cast<double>(sums.pixels);
  }
};

/// The rectangle around the mask; that of one pixel if there is none inside.
SampleWindow window_of(MaskView mask, std::int32_t width, std::int32_t height) {
  if (mask.data == nullptr) return {0, 0, width, height};
  const auto inside = [](std::uint8_t m) { return m != 0; };
  SampleWindow window{width, height, 0, 0};
  for (std::int32_t y = 0; y < height; ++y) {
    const std::uint8_t* const row = mask.row(y);
    const std::uint8_t* const end = row + width;
    const std::uint8_t* const first = std::find_if(row, end, inside);
    if (first == end) continue;
    const std::uint8_t* last = end;
    while (last[-1] == 0) --last;
    window.x0 = std::min(window.x0, static_cast<std::int32_t>(first - row));
    window.x1 = std::max(window.x1, static_cast<std::int32_t>(last - row));
    window.y0 = std::min(window.y0, y);
    window.y1 = y + 1;
  }
  return window.y1 > 0 ? window : SampleWindow{0, 0, 1, 1};
}

/// Which layers are measured.
using Measured = std::array<bool, limits::max_quality_layers>;

/// The layers from the coefficients that were coded.
template <typename Pixel>
struct LayersOfCoefficients {
  const Comparison<Pixel>& comparison;
  LayerDecoder decoder;
  LayerErrors& errors;
  Measured& measured;
  DoubtfulBlocks doubtful;
  Status status;

  /// Measures the layers that are not measured yet, as far as they are known.
  void run(std::span<std::uint8_t> memory) {
    status = decoder.begin(memory);
    if (!status.ok()) return;
    const std::int32_t zero = std::int32_t{1} << (comparison.info.bits - 1);
    for (int layer = 0; layer < decoder.layers(); ++layer) {
      const auto i = static_cast<std::size_t>(layer);
      if (!measured[i]) {
        const ImageView<const std::int32_t> decoded = decoder.decode(layer + 1, doubtful);
        if (decoded.empty()) continue;
        measured[i] = true;
        comparison.measure(decoded, zero, layer, errors);
      }
      if (errors.largest[i] <= comparison.enough) break;
    }
  }

  /// Lets OpenJPEG decode the doubtful blocks, in memory that holds neither the file nor the coefficients.
  void decode_blocks(std::span<std::uint8_t> memory) {
    constexpr std::size_t block_bytes = std::size_t{code_block_side} * code_block_side * sizeof(std::int32_t);
    if (memory.size() < block_scratch_bytes) return;
    const std::span<std::uint8_t> scratch = memory.first(block_scratch_bytes);
    std::span<std::uint8_t> room = memory.subspan(block_scratch_bytes);
    for (DoubtfulBlock& block : doubtful.view()) {
      if (room.size() < block_bytes) return;
      auto* const coefficients = reinterpret_cast<std::int32_t*>(room.data());
      room = room.subspan(block_bytes);
      const ImageView<std::int32_t> to(coefficients, block.part.width, block.part.height);
      ++errors.decoded_blocks;
      const Status decoded = decode_block(comparison.info.codestream, decoder.style(), block.part, scratch, to);
      if (decoded.ok()) block.coefficients = coefficients;
    }
  }
};

template <typename Pixel>
Status measure_coefficients(const Comparison<Pixel>& comparison, Jpeg2000Workspace& workspace, LayerErrors& errors,
                            Measured& measured) {
  const std::span<const PassEnd> pass_ends = place_of_pass_ends(workspace);
  if (!workspace.holds_coefficients || workspace.pass_ends > pass_ends.size()) return StatusCode::not_found;
  LayersOfCoefficients<Pixel> layers{comparison, {}, errors, measured, {}, {}};
  const Jpeg2000Info& info = comparison.info;
  const ImageView<const std::int32_t> coefficients(workspace.samples.data(), info.width, info.height);
  ILP_TRY(
      layers.decoder.prepare(info.codestream, coefficients, pass_ends.first(workspace.pass_ends), comparison.window));
  const auto run = [](std::span<std::uint8_t> memory, void* context) {
    static_cast<LayersOfCoefficients<Pixel>*>(context)->run(memory);
  };
  ILP_TRY(with_openjpeg_memory(layers.decoder.memory_bytes(), run, &layers));
  ILP_TRY(layers.status);
  if (layers.doubtful.count == 0) return {};
  layers.decode_blocks(workspace.place_beside_file());
  ILP_TRY(with_openjpeg_memory(layers.decoder.memory_bytes(), run, &layers));
  return layers.status;
}

template <typename Pixel>
Status decode_layer(const Comparison<Pixel>& comparison, int layer, Jpeg2000Workspace& workspace, LayerErrors& errors) {
  workspace.holds_coefficients = false;
  ++errors.decodings;
  const Jpeg2000Info& info = comparison.info;
  const SampleWindow& window = comparison.window;
  const ImageView<std::int32_t> decoded(workspace.samples.data(), info.width, info.height);
  ILP_TRY(openjpeg_decode(info.codestream, false, layer + 1, decoded));
  comparison.measure(decoded.crop(window.x0, window.y0, window.x1 - window.x0, window.y1 - window.y0), 0, layer,
                     errors);
  return {};
}

template <typename Pixel>
Status measure(std::span<const std::uint8_t> file, ImageView<const Pixel> samples, MaskView mask,
               Jpeg2000Workspace& workspace, LayerErrors& errors, std::int32_t enough) {
  errors = {};
  Comparison<Pixel> comparison{{}, samples, mask, {}, enough};
  Jpeg2000Info& info = comparison.info;
  ILP_TRY(parse_jp2(file, info));
  if (samples.width != info.width || samples.height != info.height || info.bits > max_sample_bits ||
      info.layers > limits::max_quality_layers || samples.area() > limits::max_image_pixels) {
    return out_of_range(Argument::image_size, samples.width);
  }
  if (mask.data != nullptr && (mask.width != info.width || mask.height != info.height)) {
    return out_of_range(Argument::mask_size, mask.width);
  }
  comparison.window = window_of(mask, info.width, info.height);
  Measured measured{};
  if (!measure_coefficients(comparison, workspace, errors, measured).ok()) measured = {};
  for (int layer = 0; layer < info.layers; ++layer) {
    const auto i = static_cast<std::size_t>(layer);
    if (!measured[i]) ILP_TRY(decode_layer(comparison, layer, workspace, errors));
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
