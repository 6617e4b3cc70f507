// The boxes of a JP2 file and the marker segments of its codestream (ITU-T T.800, annexes A and I), as far as this
// project writes, corrects, cuts and reads them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/codec/jpeg2000_decode.hpp"

namespace ilp {

/// Type of our metadata box (a `uuid` box).
inline constexpr std::array<std::uint8_t, 16> metadata_uuid = {0x4a, 0x1d, 0x63, 0x0e, 0x9b, 0x52, 0x4c, 0x7f,
                                                               0xa6, 0x18, 0x3d, 0xe0, 0x77, 0xc4, 0x21, 0x95};

/// Bytes before the codestream. A file without metadata has no metadata box.
[[nodiscard]] std::size_t jp2_overhead(std::size_t metadata_bytes);

/// Writes everything before the codestream, jp2_overhead() bytes, to the start of `file`.
void write_jp2_boxes(std::int32_t width, std::int32_t height, int bits, std::span<const std::uint8_t> metadata,
                     std::size_t codestream_bytes, std::span<std::uint8_t> file);

/// Corrects the length in the codestream's box. `file` begins 8 bytes before the codestream.
void write_codestream_box(std::size_t codestream_bytes, std::span<std::uint8_t> box);

/// Corrects the codestream of signed, scaled coefficients to describe the image: unsigned samples of `bits` bits (SIZ),
/// bit planes without the region's shift (QCD). parse_error if it does not begin as our encoder's codestreams do.
Status correct_main_header(std::span<std::uint8_t> codestream, int bits, int shift);

/// The packets of a codestream with one tile, one tile part, and one packet for each layer and resolution.
struct LayerTable {
  int layers = 0;
  std::array<std::size_t, limits::max_quality_layers> bytes{};          ///< of the codestream when cut after layer i
  std::array<std::size_t, limits::max_quality_layers> data_end{};       ///< of layer i, from the first packet
  std::array<std::size_t, limits::max_quality_layers> lengths_bytes{};  ///< of the PLT entries up to layer i
  std::size_t cod = 0, sot = 0, plt = 0;                                ///< offsets of the markers
  std::size_t data = 0;                                                 ///< offset of the first packet
};
/// `parse_error` unless the codestream is as described and holds its packet lengths in one PLT marker segment.
Status read_layer_table(std::span<const std::uint8_t> codestream, LayerTable& table);

/// Cuts the codestream in place after `layers` layers, 1 to table.layers, and corrects its headers.
void cut_codestream(std::span<std::uint8_t> codestream, const LayerTable& table, int layers);

/// Parses boxes and main header. The spans of `info` point into `file`. Errors as read_jpeg2000_header.
Status parse_jp2(std::span<const std::uint8_t> file, Jpeg2000Info& info);

}  // namespace ilp
