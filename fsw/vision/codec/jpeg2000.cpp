#include "fsw/vision/codec/jpeg2000.hpp"

#include <bit>

#include "fsw/vision/codec/jp2_file.hpp"
#include "fsw/vision/codec/openjpeg_codec.hpp"
#include "fsw/vision/codec/region.hpp"

namespace ilp {
namespace {

constexpr std::size_t max_attempts = 6;
// A layer of less holds little beside the headers of its packets, and OpenJPEG's rate control pads targets below 30.
constexpr double min_layer_bytes = 256;
constexpr std::size_t min_codestream_bytes = 128;

Status check(std::int32_t width, std::int32_t height, int bits, MaskView mask, const Jpeg2000Params& params,
             std::span<const std::uint8_t> metadata) {
  if (width < 1 || height < 1) return {StatusCode::invalid_argument, 0, width};
  // Sides too: OpenJPEG needs many times the memory for long thin images.
  if (width > limits::max_image_side || height > limits::max_image_side ||
      static_cast<std::size_t>(width) * static_cast<std::size_t>(height) > limits::max_image_pixels) {
    return {StatusCode::image_too_large, width, height};
  }
  if (bits < 1 || bits > max_sample_bits) return {StatusCode::invalid_argument, 1, bits};
  if (mask.data != nullptr && (mask.width != width || mask.height != height)) {
    return {StatusCode::invalid_argument, 2, mask.width};
  }
  if (params.wavelet_levels < 0 || params.wavelet_levels > limits::max_wavelet_levels) {
    return {StatusCode::invalid_argument, 3, params.wavelet_levels};
  }
  if (params.layers < 1 || params.layers > limits::max_quality_layers) {
    return {StatusCode::invalid_argument, 4, params.layers};
  }
  if (params.region_resolutions < 0) return {StatusCode::invalid_argument, 5, params.region_resolutions};
  if (metadata.size() > limits::max_metadata_bytes) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(metadata.size()),
            static_cast<std::int64_t>(limits::max_metadata_bytes)};
  }
  return {};
}

int usable_levels(std::int32_t width, std::int32_t height, int wanted) {
  const auto side = static_cast<std::uint32_t>(width < height ? width : height);
  const int most = static_cast<int>(std::bit_width(side)) - 1;
  return wanted < most ? wanted : most;
}

void copy_mask(MaskView mask, ImageView<std::uint8_t> to) {
  for (std::int32_t y = 0; y < to.height; ++y) {
    const std::uint8_t* from = mask.row(y);
    std::uint8_t* row = to.row(y);
    for (std::int32_t x = 0; x < to.width; ++x) row[x] = from[x];
  }
}

Status level_shift(GrayView image, int, ImageView<std::int32_t> to) {
  for (std::int32_t y = 0; y < to.height; ++y) {
    const std::uint8_t* from = image.row(y);
    std::int32_t* row = to.row(y);
    for (std::int32_t x = 0; x < to.width; ++x) row[x] = from[x] - 128;
  }
  return {};
}

Status level_shift(ImageView<const std::uint16_t> image, int bits, ImageView<std::int32_t> to) {
  const std::int32_t half = std::int32_t{1} << (bits - 1);
  std::uint32_t all = 0;
  for (std::int32_t y = 0; y < to.height; ++y) {
    const std::uint16_t* from = image.row(y);
    std::int32_t* row = to.row(y);
    for (std::int32_t x = 0; x < to.width; ++x) {
      all |= from[x];
      row[x] = from[x] - half;
    }
  }
  if ((all >> static_cast<unsigned>(bits)) != 0) return {StatusCode::invalid_argument, 6, all};
  return {};
}

/// Ascending sizes, each half of the next; the last is `top`, or without bound.
struct LayerTargets {
  std::array<double, limits::max_quality_layers> bytes{};
  int layers = 1;

  LayerTargets(std::size_t top, int wanted, bool last_unbounded) {
    auto size = static_cast<double>(top);
    while (layers < wanted && size / 2 >= min_layer_bytes) {
      size /= 2;
      ++layers;
    }
    for (int i = 0; i < layers; ++i, size *= 2) bytes[static_cast<std::size_t>(i)] = size;
    if (last_unbounded) bytes[static_cast<std::size_t>(layers - 1)] = 0;
  }
  [[nodiscard]] std::span<const double> view() const { return {bytes.data(), static_cast<std::size_t>(layers)}; }
};

/// The encoder's rate control aims; only the size of what came out counts.
class CeilingEncoder {
 public:
  CeilingEncoder(ImageView<const std::int32_t> pre_image, const CodestreamParams& params,
                 std::span<std::uint8_t> codestream)
      : pre_image_(pre_image), params_(params), codestream_(codestream) {}

  /// The codestream with up to `wanted_layers` layers that fits its span, or grant_too_small with the size that came
  /// nearest.
  Status encode(int wanted_layers, bool lossless) {
    if (codestream_.size() < min_codestream_bytes) return too_small(min_codestream_bytes);
    if (lossless) {
      ILP_TRY(run(LayerTargets(0, 1, true)));
      if (!fits()) return too_small(bytes);
    } else {
      ILP_TRY(aim(codestream_.size(), wanted_layers));
    }
    // When everything took clearly less than the ceiling, the layers share out what it took.
    const std::size_t everything = bytes;
    const bool exhausted_image = lossless || everything < codestream_.size() / 8 * 7;
    if (wanted_layers == 1 || !exhausted_image) return {};
    ILP_TRY(run(LayerTargets(everything, wanted_layers, true)));
    if (fits()) return {};
    return lossless ? run(LayerTargets(0, 1, true)) : aim(codestream_.size(), wanted_layers);
  }

  std::size_t bytes = 0;
  int layers = 1;
  int encodings = 0;

 private:
  [[nodiscard]] bool fits() const { return bytes <= codestream_.size(); }

  Status too_small(std::size_t needed) const {
    return {StatusCode::grant_too_small, static_cast<std::int64_t>(codestream_.size()),
            static_cast<std::int64_t>(needed)};
  }

  Status run(const LayerTargets& targets) {
    params_.layer_bytes = targets.view();
    params_.packet_lengths = targets.layers > 1;
    layers = targets.layers;
    ++encodings;
    return openjpeg_encode(pre_image_, params_, codestream_, bytes);
  }

  // The encoder forgets the packet lengths and a few markers when it aims, and by how much depends on the image.
  Status aim(std::size_t ceiling, int wanted_layers) {
    std::size_t target = ceiling;
    std::size_t smallest = ~std::size_t{0};
    for (std::size_t attempt = 1; attempt <= max_attempts; ++attempt) {
      const int allowed_layers = attempt < max_attempts ? wanted_layers : 1;
      ILP_TRY(run(LayerTargets(target, allowed_layers, false)));
      if (fits()) return {};
      if (bytes < smallest) smallest = bytes;
      const std::size_t step = attempt * (bytes - ceiling + 8);
      if (target < step + min_codestream_bytes / 2) break;
      target -= step;
    }
    return too_small(smallest);
  }

  ImageView<const std::int32_t> pre_image_;
  CodestreamParams params_;
  std::span<std::uint8_t> codestream_;
};

Status fill_layer_bytes(std::span<const std::uint8_t> codestream, std::size_t overhead, Jpeg2000Product& product) {
  LayerTable table;
  ILP_TRY(read_layer_table(codestream, table));
  product.layers = table.layers;
  for (int i = 0; i < table.layers; ++i) {
    const auto layer = static_cast<std::size_t>(i);
    product.layer_bytes[layer] = overhead + table.bytes[layer];
  }
  return {};
}

template <typename Pixel>
Status encode(ImageView<const Pixel> image, int bits, MaskView mask, const Jpeg2000Params& params,
              std::span<const std::uint8_t> metadata, Jpeg2000Workspace& workspace, std::span<std::uint8_t> out,
              Jpeg2000Product& product) {
  product = {};
  ILP_TRY(check(image.width, image.height, bits, mask, params, metadata));
  const std::size_t overhead = jp2_overhead(metadata.size());
  const std::size_t ceiling = out.size() < params.max_bytes ? out.size() : params.max_bytes;
  if (ceiling < overhead + min_codestream_bytes) {
    return {StatusCode::grant_too_small, static_cast<std::int64_t>(ceiling),
            static_cast<std::int64_t>(overhead + min_codestream_bytes)};
  }
  const std::span<std::uint8_t> file = out.first(ceiling);

  const ImageView<std::int32_t> samples(workspace.samples.data(), image.width, image.height);
  ILP_TRY(level_shift(image, bits, samples));
  const int levels = usable_levels(image.width, image.height, params.wavelet_levels);
  if (mask.data != nullptr) {
    const ImageView<std::uint8_t> region(workspace.mask.data(), image.width, image.height);
    copy_mask(mask, region);
    ILP_TRY(apply_region(samples, region, levels, params.region, params.region_resolutions, workspace.scratch.data(),
                         workspace.mask_scratch.data(), product.shift));
  }

  CodestreamParams coding;
  coding.bits = bits + product.shift;
  coding.shift = product.shift;
  coding.wavelet_levels = levels;
  CeilingEncoder encoder(samples, coding, file.subspan(overhead));
  const Status status = encoder.encode(params.layers, params.lossless);
  product.encodings = encoder.encodings;
  if (status.is(StatusCode::grant_too_small)) {
    return {status.code, static_cast<std::int64_t>(ceiling), status.b + static_cast<std::int64_t>(overhead)};
  }
  ILP_TRY(status);

  const std::span<std::uint8_t> codestream = file.subspan(overhead, encoder.bytes);
  ILP_TRY(correct_main_header(codestream, bits, product.shift));
  write_jp2_boxes(image.width, image.height, bits, metadata, codestream.size(), file);
  product.bytes = overhead + codestream.size();
  product.layers = 1;
  product.layer_bytes[0] = product.bytes;
  if (encoder.layers > 1) ILP_TRY(fill_layer_bytes(codestream, overhead, product));
  return {};
}

}  // namespace

Status encode_jpeg2000(GrayView image, MaskView mask, const Jpeg2000Params& params,
                       std::span<const std::uint8_t> metadata, Jpeg2000Workspace& workspace,
                       std::span<std::uint8_t> out, Jpeg2000Product& product) {
  return encode(image, 8, mask, params, metadata, workspace, out, product);
}

Status encode_jpeg2000(ImageView<const std::uint16_t> samples, int bits, MaskView mask, const Jpeg2000Params& params,
                       std::span<const std::uint8_t> metadata, Jpeg2000Workspace& workspace,
                       std::span<std::uint8_t> out, Jpeg2000Product& product) {
  return encode(samples, bits, mask, params, metadata, workspace, out, product);
}

Status truncate_to_layers(std::span<std::uint8_t> file, int layers, std::size_t& bytes) {
  Jpeg2000Info info;
  ILP_TRY(parse_jp2(file, info));
  const auto offset = static_cast<std::size_t>(info.codestream.data() - file.data());
  if (layers < 1 || layers > info.layers) return {StatusCode::invalid_argument, layers, info.layers};
  if (layers == info.layers) {
    bytes = offset + info.codestream.size();
    return {};
  }
  LayerTable table;
  ILP_TRY(read_layer_table(info.codestream, table));
  cut_codestream(file.subspan(offset), table, layers);
  const std::size_t codestream_bytes = table.bytes[static_cast<std::size_t>(layers - 1)];
  constexpr std::size_t box_head = 8;
  if (offset >= box_head) write_codestream_box(codestream_bytes, file.subspan(offset - box_head));
  bytes = offset + codestream_bytes;
  return {};
}

}  // namespace ilp
