#include "fsw/vision/codec/layer_decoder.hpp"

#include <algorithm>
#include <bit>

#include "fsw/base/argument.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/codec/coding_passes.hpp"
#include "fsw/vision/codec/wavelet53.hpp"

namespace ilp {
namespace {

// A window begins at most this many samples after the result of the level before it.
constexpr std::int32_t most_offset = 3;
constexpr std::size_t alignment = 64;

constexpr std::size_t aligned(std::size_t bytes) {
  return (bytes + alignment - 1) / alignment * alignment;
}

std::uint32_t magnitudes_of(ImageView<const std::int32_t> block) {
  std::uint32_t result = 0;
  with_widest_vectors([&] {
    std::uint32_t all = 0;
    for (std::int32_t y = 0; y < block.height; ++y) {
      const std::int32_t* const row = block.row(y);
      for (std::ptrdiff_t x = 0; x < block.width; ++x) {
        const auto sign = static_cast<std::uint32_t>(row[x] >> 31);
        all |= (static_cast<std::uint32_t>(row[x]) ^ sign) - sign;
      }
    }
    result = all;
  });
  return result;
}

}  // namespace

// A sample 2k needs s[k], d[k-1] and d[k], a sample 2k+1 also s[k+1] and d[k+1]. Where the line is cut off, the two
// samples after the cut and the one before it are wrong: none of them is asked for.
LayerDecoder::Span LayerDecoder::span_of(std::int32_t begin, std::int32_t end, std::int32_t whole) {
  Span span;
  span.first = std::max(begin / 2 - 1, 0);
  const std::int32_t last = std::min(end / 2 + 1, (whole + 1) / 2);
  span.length = std::min(2 * last, whole) - 2 * span.first;
  return span;
}

Status LayerDecoder::prepare(std::span<const std::uint8_t> codestream, ImageView<const std::int32_t> coefficients,
                             std::span<const PassEnd> pass_ends, const SampleWindow& window) {
  ILP_TRY(read_coding_style(codestream, style_));
  if (style_.width != coefficients.width || style_.height != coefficients.height) {
    return out_of_range(Argument::image_size, style_.width);
  }
  codestream_ = codestream;
  coefficients_ = coefficients;
  pass_ends_ = pass_ends;
  window_ = window;
  lay_out_code_blocks(style_, code_blocks_);
  low_band_ = window;
  for (int i = 0; i < style_.wavelet_levels; ++i) {
    Level& level = levels_[static_cast<std::size_t>(i)];
    level.x = span_of(low_band_.x0, low_band_.x1, low_band_side(style_.width, i));
    level.y = span_of(low_band_.y0, low_band_.y1, low_band_side(style_.height, i));
    low_band_ = {level.x.first, level.y.first, level.x.first + level.x.lows(), level.y.first + level.y.lows()};
  }
  const bool transformed = style_.wavelet_levels > 0;
  stride_ = (transformed ? levels_[0].x.length : window.x1 - window.x0) + most_offset * style_.wavelet_levels;
  rows_ = (transformed ? levels_[0].y.length : window.y1 - window.y0) + most_offset * style_.wavelet_levels;
  return {};
}

std::size_t LayerDecoder::memory_bytes() const {
  const std::size_t plane =
      aligned(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(rows_) * sizeof(std::int32_t));
  return 2 * plane + aligned(code_blocks_.block_count * sizeof(CodeBlock)) + code_blocks_.node_count * sizeof(TagNode);
}

Status LayerDecoder::begin(std::span<std::uint8_t> memory) {
  if (memory.size() < memory_bytes()) return out_of_range(Argument::scratch, memory.size());
  const std::size_t plane =
      aligned(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(rows_) * sizeof(std::int32_t));
  samples_ = reinterpret_cast<std::int32_t*>(memory.data());
  scratch_ = reinterpret_cast<std::int32_t*>(memory.data() + plane);
  std::uint8_t* const blocks = memory.data() + 2 * plane;
  code_blocks_.blocks = {reinterpret_cast<CodeBlock*>(blocks), code_blocks_.block_count};
  code_blocks_.nodes = {reinterpret_cast<TagNode*>(blocks + aligned(code_blocks_.block_count * sizeof(CodeBlock))),
                        code_blocks_.node_count};
  ILP_TRY(read_packet_headers(codestream_, style_, code_blocks_));
  return check_planes();
}

ImageView<const std::int32_t> LayerDecoder::block_of(const Subband& band, std::int32_t x, std::int32_t y) const {
  const std::int32_t left = x * code_block_side, top = y * code_block_side;
  return {coefficients_.row(band.y + top) + band.x + left, std::min(code_block_side, band.width - left),
          std::min(code_block_side, band.height - top), coefficients_.stride};
}

/// All code-blocks have as many planes more than their coefficients as were dropped.
Status LayerDecoder::check_planes() {
  const auto last = static_cast<std::size_t>(code_blocks_.layers - 1);
  bool known = false;
  std::size_t ends = 0;
  for (std::size_t i = 0; i < code_blocks_.subband_count; ++i) {
    const Subband& band = code_blocks_.subbands[i];
    std::size_t index = band.first_block;
    for (std::int32_t y = 0; y < band.blocks_high; ++y) {
      for (std::int32_t x = 0; x < band.blocks_wide; ++x) {
        CodeBlock& block = code_blocks_.blocks[index++];
        const auto planes = static_cast<int>(std::bit_width(magnitudes_of(block_of(band, x, y))));
        block.first_pass_end = static_cast<std::uint32_t>(ends);
        if (planes > 0) ends += static_cast<std::size_t>(3 * planes - 1);
        if (block.passes[last] == 0) continue;
        if (!known) dropped_ = block.planes - planes;
        known = true;
        const bool right = dropped_ >= 0 && planes > 0 && block.planes - planes == dropped_;
        if (!right || block.passes[last] > 3 * planes - 2) return out_of_range(Argument::samples, block.planes);
      }
    }
  }
  return ends == pass_ends_.size() ? Status{} : out_of_range(Argument::samples);
}

/// Whether a decoder that has only the block's bytes up to this layer decodes them all rightly. It takes ones for the
/// bytes that it lacks: the number that it has then is too large if the end of the coder's interval is not above it.
/// False where that end is not known.
bool LayerDecoder::ends_well(const CodeBlock& block, std::size_t layer) const {
  const int passes = block.passes[layer];
  if (passes == 0 || passes == 3 * (block.planes - dropped_) - 2) return true;
  const PassEnd& end = pass_ends_[block.first_pass_end + static_cast<std::size_t>(passes - 1)];
  const std::uint32_t bytes = block.bytes[layer];
  if (end.top == 0 || bytes < end.bytes) return false;
  const auto byte = [&](std::uint32_t i) -> std::uint32_t {
    std::size_t part = 0;
    while (i >= block.bytes[part]) ++part;
    return codestream_[block.data[part] + (i - (part == 0 ? 0 : block.bytes[part - 1]))];
  };
  // Bit 27 carries into the last complete byte; after a byte of ones the next one overlaps it by one bit.
  constexpr int carry_bit = 27;
  const std::uint32_t last = end.bytes == 0 ? 0 : byte(end.bytes - 1U);
  std::uint32_t number = ((last - end.last_byte) & 1U) << static_cast<unsigned>(carry_bit);
  int lowest = last == 0xff ? carry_bit + 1 : carry_bit;
  for (std::uint32_t i = end.bytes; i < bytes; ++i) {
    lowest -= 8;
    if (lowest < 0) return true;
    const std::uint32_t next = byte(i);
    number += next << static_cast<unsigned>(lowest);
    if (next == 0xff) ++lowest;
  }
  return number + ((std::uint32_t{1} << static_cast<unsigned>(lowest)) - 1) < end.top;
}

/// Copies the part of a doubtful block from (x, y) on, if it is decoded; else it is to be.
bool LayerDecoder::take_decoded(std::size_t index, const BlockPart& part, std::int32_t x, std::int32_t y,
                                ImageView<std::int32_t> to, DoubtfulBlocks& doubtful) const {
  for (const DoubtfulBlock& block : doubtful.view()) {
    if (block.index != index || block.part.layers != part.layers) continue;
    if (block.coefficients == nullptr) return false;
    const ImageView<const std::int32_t> decoded(block.coefficients, part.width, part.height);
    for (std::int32_t i = 0; i < to.height; ++i) std::copy_n(decoded.row(y + i) + x, to.width, to.row(i));
    return true;
  }
  if (doubtful.count < doubtful.blocks.size()) doubtful.blocks[doubtful.count++] = {index, part, nullptr};
  return false;
}

/// Fills `to` with the decoded coefficients of a band, from its coefficient (x, y) on. False where some are not known.
bool LayerDecoder::fill(std::size_t subband, int layer, std::int32_t x, std::int32_t y, ImageView<std::int32_t> to,
                        DoubtfulBlocks& doubtful) const {
  if (to.empty()) return true;
  bool known = true;
  const Subband& band = code_blocks_.subbands[subband];
  const std::int32_t right = x + to.width, bottom = y + to.height;
  for (std::int32_t by = y / code_block_side; by * code_block_side < bottom; ++by) {
    for (std::int32_t bx = x / code_block_side; bx * code_block_side < right; ++bx) {
      const std::int32_t left = bx * code_block_side, top = by * code_block_side;
      const std::int32_t x0 = std::max(x, left), x1 = std::min(right, left + code_block_side);
      const std::int32_t y0 = std::max(y, top), y1 = std::min(bottom, top + code_block_side);
      const std::size_t index = band.first_block + static_cast<std::size_t>(by * band.blocks_wide + bx);
      const CodeBlock& block = code_blocks_.blocks[index];
      const ImageView<const std::int32_t> coded = block_of(band, bx, by);
      const ImageView<std::int32_t> part(to.row(y0 - y) + (x0 - x), x1 - x0, y1 - y0, to.stride);
      if (!ends_well(block, static_cast<std::size_t>(layer))) {
        const BlockPart whole{block, subband, coded.width, coded.height, static_cast<std::size_t>(layer) + 1};
        known = take_decoded(index, whole, x0 - left, y0 - top, part, doubtful) && known;
        continue;
      }
      KnownPasses passes;
      passes.passes = block.passes[static_cast<std::size_t>(layer)];
      passes.planes = block.planes - dropped_;
      passes.dropped = dropped_;
      passes.shift = style_.shift;
      if (known) decode_passes(coded, passes, x0 - left, y0 - top, part);
    }
  }
  return known;
}

ImageView<const std::int32_t> LayerDecoder::decode(int layers, DoubtfulBlocks& doubtful) {
  const int layer = layers - 1;
  std::int32_t* at = samples_;
  const auto view = [&](std::int32_t x, std::int32_t y, std::int32_t width, std::int32_t height) {
    return ImageView<std::int32_t>(at + static_cast<std::ptrdiff_t>(y) * stride_ + x, width, height, stride_);
  };
  std::size_t band = 0;
  const SampleWindow& low = low_band_;
  bool known = fill(band++, layer, low.x0, low.y0, view(0, 0, low.x1 - low.x0, low.y1 - low.y0), doubtful);
  for (int i = style_.wavelet_levels - 1; i >= 0; --i) {
    const Span& x = levels_[static_cast<std::size_t>(i)].x;
    const Span& y = levels_[static_cast<std::size_t>(i)].y;
    const ImageView<std::int32_t> parts[] = {view(x.lows(), 0, x.highs(), y.lows()),
                                             view(0, y.lows(), x.lows(), y.highs()),
                                             view(x.lows(), y.lows(), x.highs(), y.highs())};
    for (const ImageView<std::int32_t>& part : parts) {
      known = fill(band++, layer, x.first, y.first, part, doubtful) && known;
    }
    if (known) inverse_wavelet53(view(0, 0, x.length, y.length), 1, scratch_);
    const Level* const next = i > 0 ? &levels_[static_cast<std::size_t>(i - 1)] : nullptr;
    const std::int32_t next_x = next != nullptr ? next->x.first : window_.x0;
    const std::int32_t next_y = next != nullptr ? next->y.first : window_.y0;
    at += static_cast<std::ptrdiff_t>(next_y - 2 * y.first) * stride_ + (next_x - 2 * x.first);
  }
  return known ? view(0, 0, window_.x1 - window_.x0, window_.y1 - window_.y0) : ImageView<std::int32_t>();
}

}  // namespace ilp
