// HMAC-SHA-256 (RFC 2104, FIPS 180-4) by libsodium: fixed memory, no allocation.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace ilp {

using HmacSha256 = std::array<std::uint8_t, 32>;

/// Returns the code of the concatenated parts.
[[nodiscard]] HmacSha256 hmac_sha256(std::span<const std::uint8_t> key,
                                     std::span<const std::span<const std::uint8_t>> parts);

/// Returns whether `a` equals `b`. The time that this takes depends on the sizes only.
[[nodiscard]] bool equal_in_constant_time(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b);

}  // namespace ilp
