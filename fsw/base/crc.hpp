// CRC-32 of ISO-HDLC (polynomial 0x04C11DB7 reflected, as in zip and PNG), for files and checkpoints.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace ilp {

/// Pass the previous result as `crc` to continue over further bytes.
[[nodiscard]] std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0);
/// CRC-32C (polynomial 0x1EDC6F41 reflected, Castagnoli), one of CFDP's checksums. Continues likewise.
[[nodiscard]] std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0);
/// Whether crc32c is computed by instructions of the processor, which must have them then. The result is the same. On
/// x86-64 they are found at the first call; elsewhere the program says at its start that they are there.
void use_crc32c_instructions(bool use);
/// False where no build has them, or where an x86-64 processor does not.
[[nodiscard]] bool may_have_crc32c_instructions();

/// Finds the single flipped bit that explains the difference between two CRC-32C, counted from the first bit (the
/// lowest of the first byte) of the last `bytes` bytes of the message. Returns 8 * bytes if no single bit of these
/// explains it.
[[nodiscard]] std::size_t crc32c_flipped_bit(std::size_t bytes, std::uint32_t difference);

}  // namespace ilp
