// CRC-32 and CRC-32C, for files and stored data.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace ilp {

/// CRC-32 of ISO-HDLC (polynomial 0x04C11DB7 reflected, as in zip and PNG). To continue over further bytes, pass the
/// previous result as `crc`.
[[nodiscard]] std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0);
/// CRC-32C (polynomial 0x1EDC6F41 reflected, Castagnoli), one of CFDP's checksums. Continues likewise.
[[nodiscard]] std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0);
/// Sets whether crc32c uses the processor's CRC instructions, which must exist if `use` is true. The result is the
/// same. On x86-64 the first call of crc32c finds out whether they exist; on other processors the program must call
/// this function at its start to use them.
void use_crc32c_instructions(bool use);
/// Returns false if this build has no such instructions, or if it runs on an x86-64 processor without them.
[[nodiscard]] bool may_have_crc32c_instructions();

/// Finds the single flipped bit that explains the difference between two CRC-32C of a message. `difference` is their
/// exclusive or. Only the last `bytes` bytes of the message are searched. Returns the index of the bit in these bytes
/// (0: the lowest bit of the first one), or 8 * bytes if no single bit explains the difference.
[[nodiscard]] std::size_t crc32c_flipped_bit(std::size_t bytes, std::uint32_t difference);

}  // namespace ilp
