// Writes and reads blocks of bytes in a file, each with its length and its checksum.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <span>
#include <vector>

namespace ilp::tasks {

/// Writes a block: its length (32 bits, little-endian), its CRC-32 and its bytes.
void write_block(std::ostream& stream, std::span<const std::uint8_t> bytes);
/// Reads the next block; none at the end of the stream. Throws std::runtime_error if a block is truncated, damaged or
/// larger than 1 GiB.
[[nodiscard]] std::optional<std::vector<std::uint8_t>> read_block(std::istream& stream);

}  // namespace ilp::tasks
