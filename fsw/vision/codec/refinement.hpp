// Refinement files: the bytes that a file with several quality layers has in addition to the same file cut to fewer
// layers (truncate_to_layers).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

namespace ilp {

/// How a file with more layers is composed of the shorter file and of bytes of its own, in this order:
/// - the first `same_head` bytes of the shorter file,
/// - its own bytes from offset same_head to `head_end`,
/// - `same_data` bytes of the shorter file from offset `shorter_data`,
/// - its own bytes from offset head_end + same_data to its end.
struct LayerSegments {
  std::size_t shorter_bytes = 0;
  std::size_t same_head = 0;
  std::size_t head_end = 0;
  std::size_t shorter_data = 0;
  std::size_t same_data = 0;
};

/// Finds the segments of `file`, a result of encode_jpeg2000 (whole or cut). The shorter file has its first `layers`
/// layers. Returns `invalid_argument` unless `layers` is at least 1 and below the number of the file's layers,
/// `parse_error` if this project did not write the file.
Status compare_layers(std::span<const std::uint8_t> file, int layers, LayerSegments& segments);

/// Header of a refinement file (docs/outbox.md). All numbers are little-endian.
struct RefinementHeader {
  std::int64_t product_id = 0;
  /// First and last layer that the refinement adds; layers count from 1.
  std::uint8_t first_layer = 0, last_layer = 0;
  std::uint32_t shorter_bytes = 0;     ///< size of the shorter file, which is refined
  std::uint32_t bytes = 0, crc32 = 0;  ///< size and CRC-32 of the refined file
  std::uint32_t same_head = 0, head_end = 0, shorter_data = 0, same_data = 0;
};
inline constexpr std::size_t refinement_header_bytes = 4 + 8 + 2 + 7 * 4;
inline constexpr std::size_t refinement_tail_bytes = 4;  ///< CRC-32 of all bytes before it

void write_refinement_header(const RefinementHeader& header, std::span<std::uint8_t, refinement_header_bytes> out);

/// Reads a refinement file and checks its CRC and the consistency of its numbers: the refined file has at most as many
/// bytes as the shorter file and this file together. `own` receives the bytes of the refined file that this file holds.
/// Returns `truncated` if the file is too short, `parse_error` (a: offset) if a check fails.
Status read_refinement(std::span<const std::uint8_t> file, RefinementHeader& header,
                       std::span<const std::uint8_t>& own);

/// Composes the refined file in `out`, which holds header.bytes bytes. Returns `invalid_argument` if `shorter` or `out`
/// has another size than the header says, `parse_error` if the result does not have the header's checksum, because the
/// refinement belongs to another file.
Status refine(const RefinementHeader& header, std::span<const std::uint8_t> own, std::span<const std::uint8_t> shorter,
              std::span<std::uint8_t> out);

}  // namespace ilp
