// Gives the samples that a decoder makes of the first quality layers of a codestream, without decoding: from the
// coefficients that were coded, and the coding passes of each layer. In a window only, which costs in proportion.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/codec/block_decoder.hpp"
#include "fsw/vision/codec/openjpeg_codec.hpp"
#include "fsw/vision/codec/packet_headers.hpp"

namespace ilp {

struct SampleWindow {
  std::int32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< not empty
};

/// A code-block of which some layers' last pass may lack a byte, so that a decoder gets some of its last decisions
/// wrong.
struct DoubtfulBlock {
  std::size_t index = 0;  ///< of CodeBlocks::blocks
  BlockPart part;
  const std::int32_t* coefficients = nullptr;  ///< what the decoder has for it (block_decoder.hpp), if known
};
struct DoubtfulBlocks {
  std::array<DoubtfulBlock, 24> blocks;
  std::size_t count = 0;

  [[nodiscard]] std::span<DoubtfulBlock> view() { return std::span(blocks).first(count); }
};

class LayerDecoder {
 public:
  /// `coefficients` are those that were coded, and `pass_ends` what openjpeg_encode recorded then. `parse_error` for a
  /// codestream that our encoder did not write; the errors of read_packet_headers come with begin().
  Status prepare(std::span<const std::uint8_t> codestream, ImageView<const std::int32_t> coefficients,
                 std::span<const PassEnd> pass_ends, const SampleWindow& window);
  /// The memory that it works in, aligned for any type.
  [[nodiscard]] std::size_t memory_bytes() const;
  /// Reads the packet headers. `invalid_argument` where the coefficients are not those of the codestream, as far as
  /// the bit planes of its code-blocks tell.
  Status begin(std::span<std::uint8_t> memory);

  [[nodiscard]] int layers() const { return code_blocks_.layers; }
  [[nodiscard]] const CodingStyle& style() const { return style_; }
  /// The samples of the window, signed about zero and not limited to their number of bits, in the given memory. Empty
  /// where the coefficients of a doubtful block are missing: it is added to `doubtful`, as far as there is room.
  [[nodiscard]] ImageView<const std::int32_t> decode(int layers, DoubtfulBlocks& doubtful);

 private:
  /// The part of a line that one level of the inverse transform works on.
  struct Span {
    std::int32_t first = 0;   ///< of the low band, and of the high one
    std::int32_t length = 0;  ///< of the result, which begins at 2 * first

    [[nodiscard]] std::int32_t lows() const { return (length + 1) / 2; }
    [[nodiscard]] std::int32_t highs() const { return length / 2; }
  };
  struct Level {
    Span x, y;
  };
  static Span span_of(std::int32_t begin, std::int32_t end, std::int32_t whole);

  Status check_planes();
  [[nodiscard]] bool ends_well(const CodeBlock& block, std::size_t layer) const;
  bool fill(std::size_t subband, int layer, std::int32_t x, std::int32_t y, ImageView<std::int32_t> to,
            DoubtfulBlocks& doubtful) const;
  [[nodiscard]] bool take_decoded(std::size_t index, const BlockPart& part, std::int32_t x, std::int32_t y,
                                  ImageView<std::int32_t> to, DoubtfulBlocks& doubtful) const;
  [[nodiscard]] ImageView<const std::int32_t> block_of(const Subband& band, std::int32_t x, std::int32_t y) const;

  std::span<const std::uint8_t> codestream_;
  ImageView<const std::int32_t> coefficients_;
  std::span<const PassEnd> pass_ends_;
  SampleWindow window_, low_band_;
  CodingStyle style_;
  CodeBlocks code_blocks_;
  std::array<Level, limits::max_wavelet_levels> levels_{};
  std::int32_t stride_ = 0, rows_ = 0;
  int dropped_ = 0;
  std::int32_t* samples_ = nullptr;
  std::int32_t* scratch_ = nullptr;
};

}  // namespace ilp
