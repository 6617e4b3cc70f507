// Lets OpenJPEG decode one code-block: as the only one of a codestream of its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/codec/packet_headers.hpp"

namespace ilp {

/// Which code-block of a codestream, and how much of it.
struct BlockPart {
  CodeBlock block{};
  std::size_t subband = 0;  ///< of CodeBlocks
  std::int32_t width = 0, height = 0;
  std::size_t layers = 1;  ///< quality layers
};

/// Bytes of scratch that decode_block() needs, at most.
inline constexpr std::size_t block_samples_bytes = std::size_t{4} * code_block_side * code_block_side * 4;
inline constexpr std::size_t block_codestream_bytes = std::size_t{1} << 15U;
inline constexpr std::size_t block_scratch_bytes = 2 * block_samples_bytes + block_codestream_bytes;

/// `coefficients` gets what a decoder of the whole codestream has for the block, in the block's size. `scratch` is
/// aligned for 32-bit numbers. `capacity_exceeded` for a block with more bytes than a codestream here may have; errors
/// of openjpeg_decode.
Status decode_block(std::span<const std::uint8_t> codestream, const CodingStyle& style, const BlockPart& part,
                    std::span<std::uint8_t> scratch, ImageView<std::int32_t> coefficients);

}  // namespace ilp
