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
enum class CodecStage : std::uint8_t { setup, start, code, finish, header };

struct CodestreamParams {
  int bits = 8;   ///< of the signed samples
  int shift = 0;  ///< region shift that the header declares; not applied here
  int wavelet_levels = 5;
  bool packet_lengths = false;  ///< writes PLT marker segments, which allow layers to be cut off
  /// Size in bytes of the codestream after each layer, ascending; 0 (last only): all remaining bytes.
  std::span<const double> layer_bytes;
};

/// Reversible, one tile, layer by layer, one precinct per resolution. `bytes` is the size of the codestream; bytes
/// beyond the size of `out` are counted but not stored. `codec_failed`, `arena_exhausted`.
Status openjpeg_encode(ImageView<const std::int32_t> samples, const CodestreamParams& params,
                       std::span<std::uint8_t> out, std::size_t& bytes);

/// Decodes one component of exactly the size of `samples`: its first `layers` quality layers, or all for 0.
Status openjpeg_decode(std::span<const std::uint8_t> codestream, bool allow_truncated, int layers,
                       ImageView<std::int32_t> samples);

}  // namespace ilp
