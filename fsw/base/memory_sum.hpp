// A checksum for memory that is summed again and again, several times as fast as checksum64 (checksum.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace ilp {

/// Detects every change within one or two aligned words of 8 bytes, and nearly every other one. It is compared within
/// one process and never stored. Continues from `before`.
[[nodiscard]] std::uint64_t memory_sum64(std::span<const std::byte> bytes, std::uint64_t before = 0);

}  // namespace ilp
