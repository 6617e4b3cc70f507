// Unsigned integers as bytes in network order (the most significant first), in any width up to 8 octets.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ilp {

/// Writes the lowest `width` octets of the value to `to`.
constexpr void store_big_endian(std::uint64_t value, std::size_t width, std::uint8_t* to) {
  for (std::size_t i = 0; i < width; ++i) to[i] = static_cast<std::uint8_t>(value >> (8 * (width - 1 - i)));
}

/// Reads an integer of `width` octets at `from`.
[[nodiscard]] constexpr std::uint64_t load_big_endian(const std::uint8_t* from, std::size_t width) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < width; ++i) value = (value << 8U) | from[i];
  return value;
}

}  // namespace ilp
