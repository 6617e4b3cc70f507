// Unsigned integers as bytes, the least significant first, on every machine.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

namespace ilp {

/// Writes the sizeof(value) bytes of `value` to `to`.
template <std::unsigned_integral Unsigned>
void store_little_endian(Unsigned value, std::uint8_t* to) {
  for (std::size_t i = 0; i < sizeof(value); ++i) to[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

/// Reads an integer of sizeof(Unsigned) bytes at `from`.
template <std::unsigned_integral Unsigned>
[[nodiscard]] Unsigned load_little_endian(const std::uint8_t* from) {
  Unsigned value = 0;
  for (std::size_t i = 0; i < sizeof(value); ++i) {
    value = static_cast<Unsigned>(value | (static_cast<Unsigned>(from[i]) << (8 * i)));
  }
  return value;
}

}  // namespace ilp
