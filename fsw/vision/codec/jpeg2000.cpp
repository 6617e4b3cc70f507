#include "fsw/vision/codec/jpeg2000.hpp"

#include <bit>

#include "fsw/base/argument.hpp"
#include "fsw/vision/codec/background_fill.hpp"
#include "fsw/vision/codec/jp2_file.hpp"
#include "fsw/vision/codec/openjpeg_codec.hpp"
#include "fsw/vision/codec/region.hpp"

namespace ilp {
namespace {

constexpr std::size_t max_attempts = 6;
// A smaller layer holds little beside the headers of its packets, and OpenJPEG's rate control pads targets below 30.
constexpr double min_layer_bytes = 256;
constexpr std::size_t min_codestream_bytes = 128;

Status check(std::int32_t width, std::int32_t height, int bits, MaskView mask, const Jpeg2000Params& params,
             std::span<const std::uint8_t> metadata) {
  if (width < 1 || height < 1) return out_of_range(Argument::image_size, width);
  // Limits the sides too, because OpenJPEG needs many times the memory for long thin images.
  if (width > limits::max_image_side || height > limits::max_image_side ||
      static_cast<std::size_t>(width) * static_cast<std::size_t>(height) > limits::max_image_pixels) {
    return {StatusCode::image_too_large, width, height};
  }
  if (bits < 1 || bits > max_sample_bits) return out_of_range(Argument::coding_parameters, bits);
  if (mask.data != nullptr && (mask.width != width || mask.height != height)) {
    return out_of_range(Argument::mask_size, mask.width);
  }
  if (params.wavelet_levels < 0 || params.wavelet_levels > limits::max_wavelet_levels) {
    return out_of_range(Argument::coding_parameters, params.wavelet_levels);
  }
  if (params.layers < 1 || params.layers > limits::max_quality_layers) {
    return out_of_range(Argument::layers, params.layers);
  }
  if (!(params.layer_ratio > 0 && params.layer_ratio < 1))
    return out_of_range(Argument::coding_parameters, params.layer_ratio);
  if (params.region_resolutions < 0) return out_of_range(Argument::coding_parameters, params.region_resolutions);
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
  if ((all >> static_cast<unsigned>(bits)) != 0) return out_of_range(Argument::samples, all);
  return {};
}

struct Layering {
  int layers = 1;
  double ratio = 0.5;
};

/// Ascending sizes, each `ratio` times the next; the last is `top`, or without bound.
struct LayerTargets {
  std::array<double, limits::max_quality_layers> bytes{};
  int layers = 1;

  LayerTargets(double top, const Layering& wanted, bool last_unbounded) {
    auto smallest = top;
    while (layers < wanted.layers && smallest * wanted.ratio >= min_layer_bytes) {
      smallest *= wanted.ratio;
      ++layers;
    }
    double size = top;
    for (int i = layers; i-- > 0; size *= wanted.ratio) bytes[static_cast<std::size_t>(i)] = size;
    if (last_unbounded) bytes[static_cast<std::size_t>(layers - 1)] = 0;
  }
  [[nodiscard]] std::span<const double> view() const { return {bytes.data(), static_cast<std::size_t>(layers)}; }
};

/// The encoder's rate control is only approximate, so the size of the result is checked.
class CeilingEncoder {
 public:
  CeilingEncoder(ImageView<const std::int32_t> coefficients, const CodestreamParams& params,
                 std::span<std::uint8_t> codestream)
      : coefficients_(coefficients), params_(params), codestream_(codestream) {}

  /// Gives the codestream with up to `wanted` layers that fits its span, or grant_too_small with the nearest size.
  /// `expected` is the approximate size of everything.
  Status encode(const Layering& wanted, bool lossless, double expected) {
    if (codestream_.size() < min_codestream_bytes) return too_small(min_codestream_bytes);
    if (lossless || expected < 0.75 * static_cast<double>(codestream_.size())) {
      ILP_TRY(run(LayerTargets(expected, wanted, true)));
      if (fits() && layers_share(expected)) return {};
      if (fits()) return share_out(wanted, lossless);
      // Packet lengths take bytes too.
      if (lossless && layers > 1) ILP_TRY(run(LayerTargets(0, {}, true)));
      if (lossless) return fits() ? Status{} : too_small(bytes);
    }
    ILP_TRY(aim(codestream_.size(), wanted));
    const bool everything = bytes < codestream_.size() / 4 * 3;
    return everything && wanted.layers > 1 ? share_out(wanted, false) : Status{};
  }

  std::size_t bytes = 0;
  int layers = 1;
  int encodings = 0;

 private:
  [[nodiscard]] bool fits() const { return bytes <= codestream_.size(); }

  /// Whether layers that were laid out for `expected` bytes are still near halves of each other.
  [[nodiscard]] bool layers_share(double expected) const {
    return layers == 1 || (expected < 1.6 * static_cast<double>(bytes) && expected > 0.6 * static_cast<double>(bytes));
  }

  /// Lays out the layers again by the size of the result.
  Status share_out(const Layering& wanted, bool lossless) {
    ILP_TRY(run(LayerTargets(static_cast<double>(bytes), wanted, true)));
    if (fits()) return {};
    return lossless ? run(LayerTargets(0, {}, true)) : aim(codestream_.size(), wanted);
  }

  Status too_small(std::size_t needed) const {
    return {StatusCode::grant_too_small, static_cast<std::int64_t>(codestream_.size()),
            static_cast<std::int64_t>(needed)};
  }

  Status run(const LayerTargets& targets) {
    params_.layer_bytes = targets.view();
    params_.packet_lengths = targets.layers > 1;
    layers = targets.layers;
    ++encodings;
    return openjpeg_encode(coefficients_, params_, codestream_, bytes);
  }

  /// The largest size of the marker segment with the lengths of all packets, which the encoder's rate control ignores.
  [[nodiscard]] std::size_t packet_length_bytes(std::size_t ceiling, int for_layers) const {
    if (for_layers == 1) return 0;
    const std::size_t digits = ceiling < (1U << 14U) ? 2 : ceiling < (1U << 21U) ? 3 : 4;
    return 5 + digits * static_cast<std::size_t>(for_layers * (params_.wavelet_levels + 1));
  }

  Status aim(std::size_t ceiling, const Layering& wanted) {
    std::size_t smallest = ~std::size_t{0};
    // The observed error of the rate control: one more encoding costs more than these bytes.
    std::size_t margin = 20;
    for (std::size_t attempt = 1; attempt <= max_attempts; ++attempt) {
      const Layering allowed = attempt < max_attempts ? wanted : Layering{};
      const int allowed_layers = LayerTargets(static_cast<double>(ceiling), allowed, false).layers;
      const std::size_t reserved = packet_length_bytes(ceiling, allowed_layers) + margin;
      if (ceiling < reserved + min_codestream_bytes / 2) break;
      ILP_TRY(run(LayerTargets(static_cast<double>(ceiling - reserved), allowed, false)));
      if (fits()) return {};
      if (bytes < smallest) smallest = bytes;
      margin += attempt * (bytes - ceiling + 8);
    }
    return too_small(smallest);
  }

  ImageView<const std::int32_t> coefficients_;
  CodestreamParams params_;
  std::span<std::uint8_t> codestream_;
};

/// The treatment of the background under a ceiling.
struct Treatment {
  RegionCoding coding = RegionCoding::none;
  int dropped_planes = 0;
  double expected_bytes = 0;
};

/// Even with ample bytes the lowest plane is left out (some 50 dB). The exact background requires lossless.
Treatment with_background(const CoefficientCosts& costs, double region_bytes, double ceiling) {
  constexpr double slack = 2;
  const double left = slack * (ceiling - region_bytes);
  int planes = 1;
  while (planes < max_dropped_planes && costs.background[static_cast<std::size_t>(planes) + 1] > left) ++planes;
  return {RegionCoding::shift, planes, region_bytes + costs.background[static_cast<std::size_t>(planes)]};
}

/// If the region alone takes all bytes the background would never be coded: dropping it gives the same file without
/// coding its bits, and without the planes by which the region is shifted. The same holds for the background's lowest
/// planes, if the bytes left by the region do not reach them.
Treatment choose_treatment(const CoefficientCosts& costs, const Jpeg2000Params& params, double ceiling) {
  const double background = costs.background[0];
  if (params.region != RegionCoding::shift) {
    const bool drop = params.region == RegionCoding::drop_background;
    return {params.region, 0, costs.region + (drop ? 0 : background)};
  }
  const double everything = costs.region + background;
  if (params.lossless) {
    if (everything > ceiling) return {RegionCoding::drop_background, 0, costs.region};
    return {RegionCoding::shift, 0, everything};
  }
  if (costs.region > ceiling) return {RegionCoding::drop_background, 0, costs.region};
  return with_background(costs, costs.region, ceiling);
}

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

/// One encoding of one image.
template <typename Pixel>
class ImageEncoder {
 public:
  ImageEncoder(ImageView<const Pixel> image, int bits, MaskView mask, const Jpeg2000Params& params,
               Jpeg2000Workspace& workspace, std::span<std::uint8_t> codestream)
      : image_(image),
        bits_(bits),
        mask_(params.region == RegionCoding::none || params.library_transform ? MaskView{} : mask),
        params_(params),
        workspace_(workspace),
        codestream_(codestream),
        levels_(usable_levels(image.width, image.height, params.wavelet_levels)),
        samples_(workspace.samples.data(), image.width, image.height) {}

  Status encode() {
    ILP_TRY(transform());
    const CoefficientCosts costs = measure_costs(samples_, region_, levels_);
    if (params_.library_transform) ILP_TRY(level_shift(image_, bits_, samples_));
    const auto ceiling = static_cast<double>(codestream_.size());
    const Treatment chosen = choose_treatment(costs, params_, ceiling);
    const Status status = run(costs, chosen);
    if (mask_.data == nullptr || params_.region != RegionCoding::shift) return status;
    // The costs are estimates: a dropped part is restored when there is room for it after all, and removed when it
    // leaves no room for a region that must be exact.
    const bool dropped = chosen.coding == RegionCoding::drop_background;
    if (params_.lossless && !dropped && status.is(StatusCode::grant_too_small)) {
      ILP_TRY(transform());
      return run(costs, {RegionCoding::drop_background, 0, costs.region});
    }
    const bool has_capacity = status.ok() && !params_.lossless && bytes < codestream_.size() / 8 * 7;
    if (!dropped || !has_capacity) return status;
    ILP_TRY(transform());
    return run(costs, with_background(costs, static_cast<double>(bytes), ceiling));
  }

  std::size_t bytes = 0;
  int layers = 1;
  int shift = 0;
  int encodings = 0;

 private:
  Status transform() {
    ILP_TRY(level_shift(image_, bits_, samples_));
    if (mask_.data != nullptr) {
      region_ = {workspace_.mask.data(), image_.width, image_.height};
      copy_mask(mask_, region_);
      const bool worthless = params_.region == RegionCoding::drop_background && params_.region_resolutions == 0;
      if (worthless) fill_background(samples_, mask_, workspace_.scratch.data());
    }
    to_coefficients(samples_, region_, levels_, params_.region_resolutions, workspace_.scratch.data());
    return {};
  }

  Status run(const CoefficientCosts& costs, const Treatment& treatment) {
    RegionShift region;
    if (treatment.coding == RegionCoding::shift && mask_.data != nullptr) {
      ILP_TRY(choose_shift(costs, treatment.dropped_planes, region));
    }
    scale_region(samples_, region_, treatment.coding, region);
    CodestreamParams coding;
    coding.bits = bits_ + region.shift - region.dropped_planes;
    coding.shift = region.shift;
    coding.wavelet_levels = levels_;
    coding.transformed = !params_.library_transform;
    CeilingEncoder encoder(samples_, coding, codestream_);
    const Status status =
        encoder.encode({params_.layers, params_.layer_ratio}, params_.lossless, treatment.expected_bytes);
    bytes = encoder.bytes;
    layers = encoder.layers;
    shift = region.shift;
    encodings += encoder.encodings;
    ILP_TRY(status);
    return correct_main_header(codestream_.first(bytes), bits_, region.shift - region.dropped_planes);
  }

  ImageView<const Pixel> image_;
  int bits_;
  MaskView mask_;
  const Jpeg2000Params& params_;
  Jpeg2000Workspace& workspace_;
  std::span<std::uint8_t> codestream_;
  int levels_;
  ImageView<std::int32_t> samples_;
  ImageView<std::uint8_t> region_;
};

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
  ImageEncoder<Pixel> encoder(image, bits, mask, params, workspace, file.subspan(overhead));
  const Status status = encoder.encode();
  product.encodings = encoder.encodings;
  product.shift = encoder.shift;
  if (status.is(StatusCode::grant_too_small)) {
    return {status.code, static_cast<std::int64_t>(ceiling), status.b + static_cast<std::int64_t>(overhead)};
  }
  ILP_TRY(status);

  const std::span<std::uint8_t> codestream = file.subspan(overhead, encoder.bytes);
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
  if (layers < 1 || layers > info.layers) return out_of_range(Argument::layers, layers);
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
