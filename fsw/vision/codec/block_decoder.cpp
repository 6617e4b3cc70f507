#include "fsw/vision/codec/block_decoder.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "fsw/base/argument.hpp"
#include "fsw/vision/codec/openjpeg_codec.hpp"
#include "fsw/vision/codec/wavelet53.hpp"

namespace ilp {
namespace {

// More than any coefficient has, so that no sample is limited.
constexpr unsigned sample_bits = 31;

/// Marker segments and packet headers (T.800, annexes A and B). What does not fit is counted only.
class Writer {
 public:
  explicit Writer(std::span<std::uint8_t> bytes) : bytes_(bytes) {}

  void u8(unsigned value) {
    if (at_ < bytes_.size()) bytes_[at_] = static_cast<std::uint8_t>(value);
    ++at_;
  }
  void u16(unsigned value) {
    u8(value >> 8U);
    u8(value & 0xffU);
  }
  void u32(std::uint32_t value) {
    u16(value >> 16U);
    u16(value & 0xffffU);
  }
  void copy(std::span<const std::uint8_t> from) {
    if (at_ + from.size() <= bytes_.size() && !from.empty()) std::memcpy(bytes_.data() + at_, from.data(), from.size());
    at_ += from.size();
  }
  /// The lowest `count` bits; after a byte of ones the next one has seven.
  void bits(std::uint32_t value, unsigned count) {
    while (count-- > 0) {
      byte_ = (byte_ << 1U) | ((value >> count) & 1U);
      if (--left_ == 0) end_byte();
    }
  }
  void end_bits() {
    while (left_ != 8) bits(0, 1);
  }
  [[nodiscard]] std::size_t size() const { return at_; }
  [[nodiscard]] bool fits() const { return at_ <= bytes_.size(); }

 private:
  void end_byte() {
    const bool ones = byte_ == 0xff;
    u8(byte_);
    byte_ = 0;
    left_ = ones ? 7 : 8;
  }

  std::span<std::uint8_t> bytes_;
  std::size_t at_ = 0;
  unsigned byte_ = 0, left_ = 8;
};

/// The number of passes (table B.4).
void write_passes(unsigned passes, Writer& writer) {
  if (passes == 1) return writer.bits(0, 1);
  if (passes == 2) return writer.bits(2, 2);
  if (passes <= 5) return writer.bits(0xcU | (passes - 3), 4);
  if (passes <= 36) return writer.bits(0x1e0U | (passes - 6), 9);
  writer.bits(0xff80U | (passes - 37), 16);
}

struct Layout {
  std::int32_t width, height;  ///< of the image: its sub-bands have the size of the block
  unsigned levels;
  unsigned orientation;  ///< of the block's sub-band: 0 LL, 1 HL, 2 LH, 3 HH
};

Layout layout_of(const BlockPart& part) {
  if (part.subband == 0) return {part.width, part.height, 0, 0};
  return {2 * part.width, 2 * part.height, 1, static_cast<unsigned>((part.subband - 1) % 3 + 1)};
}

void write_main_header(const CodingStyle& style, const BlockPart& part, const Layout& layout, Writer& w) {
  const auto width = static_cast<std::uint32_t>(layout.width), height = static_cast<std::uint32_t>(layout.height);
  w.u16(0xff4f);
  w.u16(0xff51);
  w.u16(41);
  w.u16(0);
  for (const std::uint32_t value : {width, height, 0U, 0U, width, height, 0U, 0U}) w.u32(value);
  w.u16(1);
  w.u8(0x80U | (sample_bits - 1));
  w.u16(0x0101);
  w.u16(0xff52);
  w.u16(12);
  for (const unsigned value : {0U, 0U, 0U, 1U, 0U, layout.levels, 4U, 4U, 0U, 1U}) w.u8(value);
  w.u16(0xff5c);
  const unsigned bands = 3 * layout.levels + 1;
  w.u16(3 + bands);
  w.u8(1U << 5U);
  for (unsigned i = 0; i < bands; ++i) w.u8(static_cast<unsigned>(style.planes[part.subband]) << 3U);
  if (style.shift == 0) return;
  w.u16(0xff5e);
  w.u16(5);
  for (const unsigned value : {0U, 0U, static_cast<unsigned>(style.shift)}) w.u8(value);
}

void write_packets(const CodingStyle& style, const BlockPart& part, const Layout& layout, Writer& w) {
  const std::size_t layer = part.layers - 1;
  const unsigned passes = part.block.passes[layer];
  const std::uint32_t bytes = part.block.bytes[layer];
  if (layout.levels > 0) w.u8(0);
  w.bits(1, 1);
  for (unsigned band = layout.levels; band <= 3 * layout.levels; ++band) {
    w.bits(band == layout.orientation ? 1 : 0, 1);
    if (band != layout.orientation) continue;
    const int empty = style.planes[part.subband] + style.shift - part.block.planes;
    for (int i = 0; i < empty; ++i) w.bits(0, 1);
    w.bits(1, 1);
    write_passes(passes, w);
    unsigned length_bits = 3 + static_cast<unsigned>(std::bit_width(passes)) - 1;
    for (; length_bits < static_cast<unsigned>(std::bit_width(bytes)); ++length_bits) w.bits(1, 1);
    w.bits(0, 1);
    w.bits(bytes, length_bits);
  }
  w.end_bits();
}

}  // namespace

Status decode_block(std::span<const std::uint8_t> codestream, const CodingStyle& style, const BlockPart& part,
                    std::span<std::uint8_t> scratch, ImageView<std::int32_t> coefficients) {
  if (scratch.size() < block_scratch_bytes) return out_of_range(Argument::scratch, scratch.size());
  const Layout layout = layout_of(part);
  const std::span<std::uint8_t> bytes = scratch.subspan(2 * block_samples_bytes, block_codestream_bytes);
  Writer writer(bytes);
  write_main_header(style, part, layout, writer);
  const std::size_t tile_part = writer.size();
  for (const unsigned value : {0xff90U, 10U, 0U, 0U, 0U, 1U, 0xff93U}) writer.u16(value);
  write_packets(style, part, layout, writer);
  for (std::size_t i = 0; i < part.layers; ++i) {
    const std::uint32_t before = i == 0 ? 0 : part.block.bytes[i - 1];
    writer.copy(codestream.subspan(part.block.data[i], part.block.bytes[i] - before));
  }
  const std::size_t end = writer.size();
  writer.u16(0xffd9);
  if (!writer.fits()) return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(end)};
  Writer length(bytes.subspan(tile_part + 6));
  length.u32(static_cast<std::uint32_t>(end - tile_part));

  const ImageView<std::int32_t> samples(reinterpret_cast<std::int32_t*>(scratch.data()), layout.width, layout.height);
  ILP_TRY(openjpeg_decode(bytes.first(writer.size()), false, 0, samples));
  forward_wavelet53(samples, static_cast<int>(layout.levels),
                    reinterpret_cast<std::int32_t*>(scratch.data() + block_samples_bytes));
  const std::int32_t x = (layout.orientation & 1U) != 0 ? part.width : 0;
  const std::int32_t y = (layout.orientation & 2U) != 0 ? part.height : 0;
  for (std::int32_t i = 0; i < part.height; ++i) {
    std::copy_n(samples.row(y + i) + x, part.width, coefficients.row(i));
  }
  return {};
}

}  // namespace ilp
