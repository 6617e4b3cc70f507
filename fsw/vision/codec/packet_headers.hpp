// Reads from the packet headers of a codestream how many coding passes of each code-block are in each quality layer
// (ITU-T T.800, B.9 and B.10), for codestreams as our encoder writes them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/codec/jp2_file.hpp"

namespace ilp {

inline constexpr std::int32_t code_block_side = 64;

/// A sub-band as a rectangle of the transform's layout (wavelet53.hpp), in code-blocks from its upper left corner on.
struct Subband {
  std::int32_t x = 0, y = 0, width = 0, height = 0;
  std::int32_t blocks_wide = 0, blocks_high = 0;
  std::size_t first_block = 0;  ///< of CodeBlocks::blocks, row by row
  std::size_t first_node = 0;   ///< of its two tag trees
  int planes = 0;               ///< bit planes of the region's magnitudes, those of the shift included
};

struct CodeBlock {
  std::array<std::uint8_t, limits::max_quality_layers> passes;  ///< coding passes up to each layer's end
  std::array<std::uint32_t, limits::max_quality_layers> bytes;  ///< of its data up to each layer's end
  std::array<std::uint32_t, limits::max_quality_layers> data;   ///< offset of the layer's part in the codestream
  std::uint32_t first_pass_end;                                 ///< of PassEnds
  std::uint8_t planes;       ///< bit planes from the first pass on, if there is a pass
  std::uint8_t length_bits;  ///< state of the reader
};

struct TagNode {
  std::uint8_t at_least;
  std::uint8_t known;
};

/// The sub-bands from the low band on, then HL, LH and HH from the coarsest level to the finest. The caller owns the
/// memory of blocks and nodes.
struct CodeBlocks {
  int levels = 0, layers = 0;
  std::size_t subband_count = 0;
  std::array<Subband, 3 * limits::max_wavelet_levels + 1> subbands{};
  std::size_t block_count = 0, node_count = 0;
  std::span<CodeBlock> blocks;
  std::span<TagNode> nodes;
};

/// Fills in everything but `blocks` and `nodes`, which need block_count and node_count elements.
void lay_out_code_blocks(const CodingStyle& style, CodeBlocks& code_blocks);

/// Reads all packet headers. `parse_error` where a header says what our encoder does not write, or the packets do not
/// fill the codestream to its end.
Status read_packet_headers(std::span<const std::uint8_t> codestream, const CodingStyle& style, CodeBlocks& code_blocks);

}  // namespace ilp
