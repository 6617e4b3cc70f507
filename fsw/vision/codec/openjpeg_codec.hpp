// The only user of OpenJPEG: bare codestreams of one component. Its memory comes from the heap gate, its messages are
// dropped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// Stages that a codec_failed Status names in its second value.
ILP_ENUMERATION(CodecStage, (0, setup, ""), (1, start, ""), (2, code, ""), (3, finish, ""), (4, header, ""))

struct CodestreamParams {
  int bits = 8;   ///< of the signed samples
  int shift = 0;  ///< region shift that the header declares; not applied here
  int wavelet_levels = 5;
  bool transformed = false;     ///< the samples are the coefficients of the 5/3 transform (layout of wavelet53.hpp)
  bool packet_lengths = false;  ///< writes PLT marker segments, which allow layers to be cut off
  /// Size in bytes of the codestream after each layer, ascending; 0 (last only): all remaining bytes.
  std::span<const double> layer_bytes;
};

/// Reversible, one tile, layer by layer, one precinct per resolution. `bytes` is the size of the codestream; bytes
/// beyond the size of `out` are counted but not stored. `codec_failed`, `arena_exhausted`.
Status openjpeg_encode(ImageView<const std::int32_t> samples, const CodestreamParams& params,
                       std::span<std::uint8_t> out, std::size_t& bytes);

struct Decoding {
  std::int32_t width = 0, height = 0;
  bool allow_truncated = false;  ///< decodes as far as the codestream goes
  int layers = 0;                ///< the first quality layers; 0: all
  /// Gets the samples, in memory of the library.
  void (*take)(ImageView<const std::int32_t> samples, void* context) = nullptr;
  void* context = nullptr;
};

/// Decodes one component of exactly this size. `codec_failed`, `arena_exhausted`.
Status openjpeg_decode(std::span<const std::uint8_t> codestream, const Decoding& decoding);

/// CRC-32 of a small picture with a region that is coded in layers. It is 0 where the picture cannot be coded, or the
/// library is of another version than its header.
[[nodiscard]] std::uint32_t openjpeg_digest();
/// The digest on every machine and with every version that the build accepts. With another digest the functions that
/// the build replaces in the library do not work as they should: `transformed` must not be used.
inline constexpr std::uint32_t tested_openjpeg_digest = 0x73F4146C;

}  // namespace ilp
