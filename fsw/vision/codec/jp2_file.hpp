// Reads and writes the boxes of a JP2 file and the marker segments of its codestream (ITU-T T.800, annexes A and I), as
// far as this project needs them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/codec/jpeg2000_decode.hpp"

namespace ilp {

/// UUID of the `uuid` box that holds the metadata.
inline constexpr std::array<std::uint8_t, 16> metadata_uuid = {0x4a, 0x1d, 0x63, 0x0e, 0x9b, 0x52, 0x4c, 0x7f,
                                                               0xa6, 0x18, 0x3d, 0xe0, 0x77, 0xc4, 0x21, 0x95};

/// Returns the number of bytes before the codestream for `metadata_bytes` bytes of metadata. A file without metadata
/// has no metadata box.
[[nodiscard]] std::size_t jp2_overhead(std::size_t metadata_bytes);

/// Writes the jp2_overhead() bytes before the codestream to the start of `file`. `bits` is the bit depth of the
/// samples.
void write_jp2_boxes(std::int32_t width, std::int32_t height, int bits, std::span<const std::uint8_t> metadata,
                     std::size_t codestream_bytes, std::span<std::uint8_t> file);

/// Writes the length of the codestream's box. `box` begins at the header of this box, 8 bytes before the codestream.
void write_codestream_box(std::size_t codestream_bytes, std::span<std::uint8_t> box);

/// Changes the main header of a codestream of signed, scaled coefficients so that it describes the image: unsigned
/// samples of `bits` bits (SIZ), and bit planes without the region's shift (QCD). Returns `parse_error` if the
/// codestream does not begin as the encoder of openjpeg_codec.hpp writes it.
Status correct_main_header(std::span<std::uint8_t> codestream, int bits, int shift);

/// Offsets and sizes of the packets of a codestream with one tile, one tile part, and one packet per layer and
/// resolution.
struct LayerTable {
  int layers = 0;
  std::array<std::size_t, limits::max_quality_layers> bytes{};     ///< size of the codestream when cut after layer i
  std::array<std::size_t, limits::max_quality_layers> data_end{};  ///< end of layer i, bytes from the first packet
  std::array<std::size_t, limits::max_quality_layers> lengths_bytes{};  ///< size of the PLT entries up to layer i
  std::size_t cod = 0, sot = 0, plt = 0;  ///< offsets of the markers COD, SOT and PLT in the codestream
  std::size_t data = 0;                   ///< offset of the first packet in the codestream
};
/// Fills the table. Returns `parse_error` if the codestream has another structure or does not hold its packet lengths
/// in one PLT marker segment.
Status read_layer_table(std::span<const std::uint8_t> codestream, LayerTable& table);

/// Cuts the codestream in place after layer `layers` (1 to table.layers) and corrects its headers.
void cut_codestream(std::span<std::uint8_t> codestream, const LayerTable& table, int layers);

/// Parses boxes and main header. The spans of `info` point into `file`. Returns the errors of read_jpeg2000_header.
Status parse_jp2(std::span<const std::uint8_t> file, Jpeg2000Info& info);

}  // namespace ilp
