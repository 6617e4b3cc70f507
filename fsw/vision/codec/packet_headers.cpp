#include "fsw/vision/codec/packet_headers.hpp"

#include <bit>

#include "fsw/vision/codec/wavelet53.hpp"

namespace ilp {
namespace {

// One codeword segment of a code-block has at most this many passes (B.10.6).
constexpr unsigned max_passes = 109;
constexpr int max_planes = 30;
constexpr std::uint8_t first_length_bits = 3;

/// The bits of packet headers: after a byte 0xff the next one has seven (B.10.1).
class HeaderBits {
 public:
  HeaderBits(std::span<const std::uint8_t> bytes, std::size_t at) : bytes_(bytes), at_(at) {}

  unsigned bit() {
    if (left_ == 0) next_byte();
    --left_;
    return (byte_ >> left_) & 1U;
  }
  std::uint32_t bits(unsigned count) {
    std::uint32_t value = 0;
    while (count-- > 0) value = (value << 1U) | bit();
    return value;
  }
  /// Ends the header; the position is that of the packet's data.
  std::size_t end() {
    if (byte_ == 0xff) next_byte();
    return at_;
  }
  [[nodiscard]] bool overrun() const { return overrun_; }

 private:
  void next_byte() {
    left_ = byte_ == 0xff ? 7 : 8;
    overrun_ = overrun_ || at_ >= bytes_.size();
    byte_ = overrun_ ? 0 : bytes_[at_++];
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_;
  unsigned byte_ = 0;
  unsigned left_ = 0;
  bool overrun_ = false;
};

std::size_t tree_nodes(std::int32_t width, std::int32_t height) {
  std::size_t count = 0;
  while (true) {
    count += static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    if (width <= 1 && height <= 1) return count;
    width = (width + 1) / 2;
    height = (height + 1) / 2;
  }
}

/// Decodes the tag tree (B.10.2) of a band's code-blocks as far as to say whether the value of (x, y) is below `limit`.
bool below(HeaderBits& bits, std::span<TagNode> tree, const Subband& band, std::int32_t x, std::int32_t y,
           unsigned limit) {
  constexpr std::size_t most_levels = 16;
  std::array<std::size_t, most_levels> path{};
  std::size_t depth = 0, level_start = 0;
  std::int32_t width = band.blocks_wide, height = band.blocks_high;
  while (true) {
    const auto row = static_cast<std::size_t>(y >> depth), column = static_cast<std::size_t>(x >> depth);
    path[depth] = level_start + row * static_cast<std::size_t>(width) + column;
    ++depth;
    if ((width <= 1 && height <= 1) || depth == most_levels) break;
    level_start += static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    width = (width + 1) / 2;
    height = (height + 1) / 2;
  }
  unsigned low = 0;
  bool known = false;
  while (depth-- > 0) {
    TagNode& node = tree[path[depth]];
    if (node.at_least > low) low = node.at_least;
    known = node.known != 0;
    while (!known && low < limit && !bits.overrun()) {
      known = bits.bit() != 0;
      if (!known) ++low;
    }
    node.at_least = static_cast<std::uint8_t>(low);
    node.known = known ? 1 : 0;
  }
  return known && low < limit;
}

/// The number of new passes (B.10.6, table B.4).
unsigned read_passes(HeaderBits& bits) {
  if (bits.bit() == 0) return 1;
  if (bits.bit() == 0) return 2;
  const unsigned few = bits.bits(2);
  if (few != 3) return 3 + few;
  const unsigned more = bits.bits(5);
  if (more != 31) return 6 + more;
  return 37 + bits.bits(7);
}

class PacketReader {
 public:
  PacketReader(std::span<const std::uint8_t> codestream, const CodingStyle& style, CodeBlocks& code_blocks)
      : bytes_(codestream.first(style.data_end)), at_(style.data), code_blocks_(code_blocks) {}

  Status read(std::size_t layer, int resolution) {
    HeaderBits bits(bytes_, at_);
    std::uint64_t data = 0;
    std::size_t end_block = 0;
    const bool present = bits.bit() != 0;
    const std::size_t first = resolution == 0 ? 0 : static_cast<std::size_t>(3 * resolution - 2);
    const std::size_t last = resolution == 0 ? 1 : first + 3;
    for (std::size_t i = first; i < last; ++i) {
      const Subband& band = code_blocks_.subbands[i];
      for (std::int32_t y = 0; y < band.blocks_high; ++y) {
        for (std::int32_t x = 0; x < band.blocks_wide; ++x) {
          const std::size_t block = band.first_block + static_cast<std::size_t>(y * band.blocks_wide + x);
          end_block = block + 1;
          if (!read_block(bits, layer, band, x, y, present, code_blocks_.blocks[block], data)) return malformed();
        }
      }
    }
    at_ = bits.end();
    if (bits.overrun() || data > bytes_.size() - at_) return malformed();
    place_data(layer, code_blocks_.subbands[first].first_block, end_block);
    return {};
  }
  [[nodiscard]] Status malformed() const { return {StatusCode::parse_error, static_cast<std::int64_t>(at_), 0}; }
  [[nodiscard]] bool at_end() const { return at_ == bytes_.size(); }

 private:
  bool read_block(HeaderBits& bits, std::size_t layer, const Subband& band, std::int32_t x, std::int32_t y,
                  bool present, CodeBlock& block, std::uint64_t& data) {
    const unsigned before = layer == 0 ? 0 : block.passes[layer - 1];
    block.passes[layer] = static_cast<std::uint8_t>(before);
    block.bytes[layer] = layer == 0 ? 0 : block.bytes[layer - 1];
    if (!present) return true;
    const std::size_t nodes = tree_nodes(band.blocks_wide, band.blocks_high);
    if (before == 0) {
      const auto inclusion = code_blocks_.nodes.subspan(band.first_node, nodes);
      if (!below(bits, inclusion, band, x, y, static_cast<unsigned>(layer) + 1)) return true;
      const auto empty_planes = code_blocks_.nodes.subspan(band.first_node + nodes, nodes);
      int empty = 0;
      while (!below(bits, empty_planes, band, x, y, static_cast<unsigned>(empty) + 1)) {
        if (++empty >= band.planes || bits.overrun()) return false;
      }
      if (band.planes - empty > max_planes) return false;
      block.planes = static_cast<std::uint8_t>(band.planes - empty);
      block.length_bits = first_length_bits;
    } else if (bits.bit() == 0) {
      return true;
    }
    const unsigned passes = read_passes(bits);
    while (bits.bit() != 0) {
      if (++block.length_bits > 32) return false;
    }
    const unsigned length_bits = block.length_bits + static_cast<unsigned>(std::bit_width(passes)) - 1;
    if (length_bits > 32 || before + passes > max_passes) return false;
    const std::uint32_t bytes = bits.bits(length_bits);
    if (bytes > bytes_.size()) return false;
    block.bytes[layer] += bytes;
    data += bytes;
    block.passes[layer] = static_cast<std::uint8_t>(before + passes);
    return !bits.overrun();
  }

  /// The parts of the code-blocks follow the header, in the same order.
  void place_data(std::size_t layer, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      CodeBlock& block = code_blocks_.blocks[i];
      block.data[layer] = static_cast<std::uint32_t>(at_);
      at_ += block.bytes[layer] - (layer == 0 ? 0 : block.bytes[layer - 1]);
    }
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_;
  CodeBlocks& code_blocks_;
};

}  // namespace

void lay_out_code_blocks(const CodingStyle& style, CodeBlocks& code_blocks) {
  code_blocks = {};
  code_blocks.levels = style.wavelet_levels;
  code_blocks.layers = style.layers;
  const auto add = [&](std::int32_t x, std::int32_t y, std::int32_t x1, std::int32_t y1) {
    const std::size_t index = code_blocks.subband_count++;
    Subband& band = code_blocks.subbands[index];
    band = {.x = x, .y = y, .width = x1 - x, .height = y1 - y};
    band.planes = style.planes[index] + style.shift;
    band.first_block = code_blocks.block_count;
    band.first_node = code_blocks.node_count;
    if (band.width == 0 || band.height == 0) return;
    band.blocks_wide = (band.width + code_block_side - 1) / code_block_side;
    band.blocks_high = (band.height + code_block_side - 1) / code_block_side;
    code_blocks.block_count += static_cast<std::size_t>(band.blocks_wide) * static_cast<std::size_t>(band.blocks_high);
    code_blocks.node_count += 2 * tree_nodes(band.blocks_wide, band.blocks_high);
  };
  std::int32_t width = low_band_side(style.width, style.wavelet_levels);
  std::int32_t height = low_band_side(style.height, style.wavelet_levels);
  add(0, 0, width, height);
  for (int level = style.wavelet_levels - 1; level >= 0; --level) {
    const std::int32_t whole_width = low_band_side(style.width, level);
    const std::int32_t whole_height = low_band_side(style.height, level);
    add(width, 0, whole_width, height);
    add(0, height, width, whole_height);
    add(width, height, whole_width, whole_height);
    width = whole_width;
    height = whole_height;
  }
}

Status read_packet_headers(std::span<const std::uint8_t> codestream, const CodingStyle& style,
                           CodeBlocks& code_blocks) {
  for (CodeBlock& block : code_blocks.blocks) block = {};
  for (TagNode& node : code_blocks.nodes) node = {};
  PacketReader reader(codestream, style, code_blocks);
  for (int layer = 0; layer < code_blocks.layers; ++layer) {
    for (int resolution = 0; resolution <= code_blocks.levels; ++resolution) {
      ILP_TRY(reader.read(static_cast<std::size_t>(layer), resolution));
    }
  }
  return reader.at_end() ? Status{} : reader.malformed();
}

}  // namespace ilp
