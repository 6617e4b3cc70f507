// The bytes that a file with several quality layers has beyond the same file cut to fewer (truncate_to_layers).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

namespace ilp {

/// The longer file consists of the first `same_head` bytes of the shorter one, its own bytes from there to `head_end`,
/// `same_data` bytes of the shorter one from its byte `shorter_data`, and its own bytes from head_end + same_data.
struct LayerSegments {
  std::size_t shorter_bytes = 0;
  std::size_t same_head = 0;
  std::size_t head_end = 0;
  std::size_t shorter_data = 0;
  std::size_t same_data = 0;
};

/// `file` is a file of encode_jpeg2000, whole or cut. The shorter one has its first `layers` layers, at least 1 and
/// fewer than the file's (`invalid_argument`). `parse_error` for a file that this project did not write.
Status compare_layers(std::span<const std::uint8_t> file, int layers, LayerSegments& segments);

/// A file that refines another (docs/outbox.md), all numbers little-endian.
struct RefinementHeader {
  std::int64_t product_id = 0;
  std::uint8_t first_layer = 0, last_layer = 0;  ///< layers that it adds, from 1
  std::uint32_t shorter_bytes = 0;               ///< size of the file that it refines
  std::uint32_t bytes = 0, crc32 = 0;            ///< of the refined file
  std::uint32_t same_head = 0, head_end = 0, shorter_data = 0, same_data = 0;
};
inline constexpr std::size_t refinement_header_bytes = 4 + 8 + 2 + 7 * 4;
inline constexpr std::size_t refinement_tail_bytes = 4;  ///< CRC-32 of everything before it

void write_refinement_header(const RefinementHeader& header, std::span<std::uint8_t, refinement_header_bytes> out);

/// Reads a whole file and checks its CRC and the consistency of its numbers: the refined file has at most as many bytes
/// as the shorter one and this file together. `own` gets its bytes of the refined file. `truncated`, `parse_error` (a:
/// offset).
Status read_refinement(std::span<const std::uint8_t> file, RefinementHeader& header,
                       std::span<const std::uint8_t>& own);

/// The refined file into `out`, of header.bytes bytes. invalid_argument when `shorter` has another size than the file
/// that was refined, parse_error when the result does not have the stated checksum: it refines another file.
Status refine(const RefinementHeader& header, std::span<const std::uint8_t> own, std::span<const std::uint8_t> shorter,
              std::span<std::uint8_t> out);

}  // namespace ilp
