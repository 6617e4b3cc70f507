// Encodes images and depth maps as JP2 files with a region of interest of any shape. A file never exceeds its byte
// ceiling.
//
// Either the region's wavelet coefficients are scaled above all others (Maxshift, ITU-T T.800 annex H), so that the
// rest is coded after them as far as the bytes reach, or the other coefficients are dropped. An encoder without masks
// can do this: it gets the changed coefficients, of more bits, instead of an image that it would transform. Afterwards
// the main header is corrected.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

enum class RegionCoding : std::uint8_t {
  none,            ///< the mask is ignored
  shift,           ///< the region first, the rest with what bytes are left, up to about 50 dB (lossless: exactly)
  drop_background  ///< the coefficients of the rest are zero; without resolutions of the whole, samples near the region
                   ///< have the values that cost least
};

struct Jpeg2000Params {
  std::size_t max_bytes = 0;  ///< ceiling of the whole file, boxes and metadata included
  RegionCoding region = RegionCoding::shift;
  /// Coarsest resolutions that count as region everywhere. 1 (the low band alone) costs nothing inside and improves the
  /// rest.
  int region_resolutions = 1;
  int wavelet_levels = 5;    ///< at most limits::max_wavelet_levels; fewer are used when a side is below 2^levels
  int layers = 1;            ///< quality layers; fewer when the bytes are few
  double layer_ratio = 0.5;  ///< bytes up to a layer over those up to the next, above 0 and below 1
  /// Codes the region (everything without one) exactly, or returns `grant_too_small`. A shifted background is exact
  /// too, or dropped.
  bool lossless = false;
  /// The library transforms the image, and the mask is ignored: for a library that does not take coefficients.
  bool library_transform = false;
};

struct Jpeg2000Product {
  std::size_t bytes = 0;
  int layers = 0;
  int shift = 0;      ///< shift of the region in bit planes; 0: no region marker
  int encodings = 0;  ///< runs of the encoder until the ceiling was met
  /// Size of the file when cut after layer i (truncate_to_layers); the last is `bytes`.
  std::array<std::size_t, limits::max_quality_layers> layer_bytes{};
};

/// Scratch of one encoding; a static object of its owner.
struct Jpeg2000Workspace {
  alignas(8) std::array<std::int32_t, limits::max_image_pixels> samples;
  std::array<std::int32_t, limits::max_image_pixels> scratch;
  std::array<std::uint8_t, limits::max_image_pixels> mask;

  /// A place for the file, where memory is short: the encoder writes it when it does not need `scratch` any more.
  [[nodiscard]] std::span<std::uint8_t> place_of_file() {
    static_assert(sizeof(scratch) >= limits::max_product_bytes);
    return {reinterpret_cast<std::uint8_t*>(scratch.data()), limits::max_product_bytes};
  }
};

inline constexpr int max_sample_bits = 16;

/// Takes any size up to limits::max_image_pixels with no side above limits::max_image_side. `mask` has the size of the
/// image, or is empty: everything is region. `metadata` (at most limits::max_metadata_bytes, may be empty) is stored in
/// a box before the codestream. The file is written to `out`, which need not be larger than max_bytes. The same input
/// gives the same bytes. `invalid_argument`, `image_too_large`; `grant_too_small` (b: bytes that would suffice, as far
/// as known); `coefficient_overflow` (shift of samples with many bits); `codec_failed` (b: stage); `arena_exhausted`.
/// After an error `out` is void.
Status encode_jpeg2000(GrayView image, MaskView mask, const Jpeg2000Params& params,
                       std::span<const std::uint8_t> metadata, Jpeg2000Workspace& workspace,
                       std::span<std::uint8_t> out, Jpeg2000Product& product);
/// Samples of `bits` bits (1 to 16), all below 2^bits: depth, disparity, height.
Status encode_jpeg2000(ImageView<const std::uint16_t> samples, int bits, MaskView mask, const Jpeg2000Params& params,
                       std::span<const std::uint8_t> metadata, Jpeg2000Workspace& workspace,
                       std::span<std::uint8_t> out, Jpeg2000Product& product);

/// Cuts a file of encode_jpeg2000, in place, to its first `layers` quality layers without decoding it. The result is a
/// complete file. `parse_error` for a file that this project did not write; `invalid_argument` for layers below 1 or
/// above the file's.
Status truncate_to_layers(std::span<std::uint8_t> file, int layers, std::size_t& bytes);

}  // namespace ilp
