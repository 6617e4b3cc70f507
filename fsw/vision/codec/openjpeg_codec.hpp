// Encodes and decodes bare codestreams of one component by OpenJPEG. No other file uses this library. Its memory comes
// from the heap gate; its messages are dropped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// Stages of the codec: the second value of a Status `codec_failed`.
ILP_ENUMERATION(CodecStage, (0, setup, ""), (1, start, ""), (2, code, ""), (3, finish, ""), (4, header, ""))

struct CodestreamParams {
  int bits = 8;   ///< bits of the signed samples
  int shift = 0;  ///< region shift that the header declares; the encoder does not apply it
  int wavelet_levels = 5;
  bool transformed = false;     ///< the samples are coefficients of the 5/3 transform, in the layout of wavelet53.hpp
  bool packet_lengths = false;  ///< writes PLT marker segments, which truncate_to_layers needs
  /// Size of the codestream after each layer, bytes, ascending; 0 (last layer only): no limit.
  std::span<const double> layer_bytes;
};

/// Encodes without loss before truncation (reversible): one tile, layer by layer, one precinct per resolution. `bytes`
/// is the size of the codestream; bytes beyond the size of `out` are counted but not stored. Returns `codec_failed` if
/// OpenJPEG fails, `arena_exhausted` if it runs out of memory.
Status openjpeg_encode(ImageView<const std::int32_t> samples, const CodestreamParams& params,
                       std::span<std::uint8_t> out, std::size_t& bytes);

struct Decoding {
  std::int32_t width = 0, height = 0;
  bool allow_truncated = false;  ///< decodes a codestream that ends early as far as it goes
  int layers = 0;                ///< number of quality layers to decode; 0: all
  /// Receives the samples, in memory that is valid only during the call.
  void (*take)(ImageView<const std::int32_t> samples, void* context) = nullptr;
  void* context = nullptr;
};

/// Decodes one component of exactly `width` x `height` samples. Returns `codec_failed` if OpenJPEG fails,
/// `arena_exhausted` if it runs out of memory.
Status openjpeg_decode(std::span<const std::uint8_t> codestream, const Decoding& decoding);

/// Returns the CRC-32 of a small test picture with a region, coded in layers. Returns 0 if the picture cannot be coded,
/// or if the library's version differs from that of its header.
[[nodiscard]] std::uint32_t openjpeg_digest();
/// Value of openjpeg_digest() on every machine and with every OpenJPEG version that the build accepts. With another
/// digest the functions that the build replaces in the library do not work as they should, and `transformed` must not
/// be used.
inline constexpr std::uint32_t tested_openjpeg_digest = 0x73F4146C;

}  // namespace ilp
