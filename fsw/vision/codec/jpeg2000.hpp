// Encodes images and depth maps as JP2 files with a region of interest of any shape. A file never exceeds its byte
// ceiling.
//
// Either the region's wavelet coefficients are scaled above all others (Maxshift, ITU-T T.800 annex H), so that the
// background is coded after them as far as the bytes reach, or the coefficients of the background are dropped. OpenJPEG
// does not take a mask, so it gets the scaled coefficients, which need more bits, instead of an image that it would
// transform. Afterwards the main header is corrected.
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
  none,   ///< the mask is ignored
  shift,  ///< the region first, then the background with the remaining bytes, up to about 50 dB (exact if lossless)
  /// The coefficients of the background are zero. If region_resolutions is 0, samples near the region get the values
  /// that cost least.
  drop_background
};

struct Jpeg2000Params {
  std::size_t max_bytes = 0;  ///< largest size of the file, with its boxes and metadata
  RegionCoding region = RegionCoding::shift;
  /// Number of coarsest resolutions that count as region everywhere. With 1 (the low band alone) the region loses no
  /// quality and the background improves.
  int region_resolutions = 1;
  int wavelet_levels = 5;  ///< 0 to limits::max_wavelet_levels; fewer are used if a side is below 2^levels px
  int layers = 1;          ///< quality layers, 1 to limits::max_quality_layers; fewer are written if the bytes are few
  double layer_ratio = 0.5;  ///< size up to a layer divided by the size up to the next one; above 0 and below 1
  /// Codes the region without loss (without a mask: the whole image), or returns `grant_too_small`. A shifted
  /// background is then also without loss, or is dropped.
  bool lossless = false;
  /// OpenJPEG transforms the image, and the mask is ignored. For a build of OpenJPEG that does not take coefficients
  /// (openjpeg_digest).
  bool library_transform = false;
};

struct Jpeg2000Product {
  std::size_t bytes = 0;  ///< size of the file
  int layers = 0;         ///< number of quality layers that were written
  int shift = 0;          ///< shift of the region in bit planes; 0: the file has no region marker
  int encodings = 0;      ///< number of encoder runs until the ceiling was met
  /// Size of the file when cut after layer i (truncate_to_layers). The last one is `bytes`.
  std::array<std::size_t, limits::max_quality_layers> layer_bytes{};
};

/// Scratch memory of one encoding, several megabytes: keep it in static memory.
struct Jpeg2000Workspace {
  alignas(8) std::array<std::int32_t, limits::max_image_pixels> samples;
  std::array<std::int32_t, limits::max_image_pixels> scratch;
  std::array<std::uint8_t, limits::max_image_pixels> mask;

  /// Memory for the file, if no other is available. It overlaps `scratch`, which the encoder no longer needs when it
  /// writes the file.
  [[nodiscard]] std::span<std::uint8_t> place_of_file() {
    static_assert(sizeof(scratch) >= limits::max_product_bytes);
    return {reinterpret_cast<std::uint8_t*>(scratch.data()), limits::max_product_bytes};
  }
};

inline constexpr int max_sample_bits = 16;

/// Encodes an 8-bit image of up to limits::max_image_pixels, with no side above limits::max_image_side. `mask` has the
/// size of the image, nonzero inside the region; if it has no data, the whole image is the region. `metadata` (at most
/// limits::max_metadata_bytes, may be empty) is stored in a box before the codestream. The file is written to the start
/// of `out`; its size is at most max_bytes and at most the size of `out`. The same input gives the same bytes. Returns
/// `invalid_argument` or `image_too_large` if an argument is out of range, `capacity_exceeded` if the metadata are too
/// long, `grant_too_small` if the file does not fit (b: bytes that would suffice, as far as known),
/// `coefficient_overflow` if shifted samples need too many bits, `codec_failed` if OpenJPEG fails (b: CodecStage),
/// `arena_exhausted` if it runs out of memory. After an error the content of `out` is undefined.
Status encode_jpeg2000(GrayView image, MaskView mask, const Jpeg2000Params& params,
                       std::span<const std::uint8_t> metadata, Jpeg2000Workspace& workspace,
                       std::span<std::uint8_t> out, Jpeg2000Product& product);
/// Encodes samples of `bits` bits (1 to 16), all below 2^bits: depth, disparity or height.
Status encode_jpeg2000(ImageView<const std::uint16_t> samples, int bits, MaskView mask, const Jpeg2000Params& params,
                       std::span<const std::uint8_t> metadata, Jpeg2000Workspace& workspace,
                       std::span<std::uint8_t> out, Jpeg2000Product& product);

/// Cuts a file of encode_jpeg2000 in place to its first `layers` quality layers, without decoding it. `bytes` is the
/// new size; the result is a complete file. Returns `parse_error` if this project did not write the file,
/// `invalid_argument` if `layers` is below 1 or above the number of the file's layers.
Status truncate_to_layers(std::span<std::uint8_t> file, int layers, std::size_t& bytes);

}  // namespace ilp
