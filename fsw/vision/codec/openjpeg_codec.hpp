// The only user of OpenJPEG: bare codestreams of one component. Its memory comes from the heap gate, its messages are
// dropped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"

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

/// Where the arithmetic coder stood after a coding pass (T.800, annex C). From it follows whether a decoder that has
/// only the pass's bytes decodes it rightly: OpenJPEG gives a pass three bytes more than are complete, which is one too
/// few for some.
struct PassEnd {
  std::uint32_t top = 0;       ///< end of the interval, its lowest bits up to bit 27 after `bytes`; 0: not known
  std::uint16_t bytes = 0;     ///< that are complete but for a carry into the last one
  std::uint8_t last_byte = 0;  ///< before that carry
};
/// Of all code-blocks that are not zero, in the order of their sub-bands: 3 * planes - 1 each, of which the last two
/// are of the terminated code-block.
struct PassEnds {
  std::span<PassEnd> room;
  std::size_t count = 0;  ///< may be more than the room
};

/// The encoder does not need the mask of the workspace.
[[nodiscard]] inline std::span<PassEnd> place_of_pass_ends(Jpeg2000Workspace& workspace) {
  static_assert(offsetof(Jpeg2000Workspace, mask) % alignof(PassEnd) == 0);
  return {reinterpret_cast<PassEnd*>(workspace.mask.data()), workspace.mask.size() / sizeof(PassEnd)};
}

/// Reversible, one tile, layer by layer, one precinct per resolution. `bytes` is the size of the codestream; bytes
/// beyond the size of `out` are counted but not stored. `codec_failed`, `arena_exhausted`.
Status openjpeg_encode(ImageView<const std::int32_t> samples, const CodestreamParams& params,
                       std::span<std::uint8_t> out, std::size_t& bytes, PassEnds* pass_ends = nullptr);

/// Calls `body(memory, context)` with memory of the encoder's region. `arena_exhausted`.
Status with_openjpeg_memory(std::size_t bytes, void (*body)(std::span<std::uint8_t> memory, void* context),
                            void* context);

/// Decodes one component of exactly the size of `samples`: its first `layers` quality layers, or all for 0.
Status openjpeg_decode(std::span<const std::uint8_t> codestream, bool allow_truncated, int layers,
                       ImageView<std::int32_t> samples);

}  // namespace ilp
