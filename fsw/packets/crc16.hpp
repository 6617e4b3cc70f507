// CRC-16 of space packets, telecommands and CFDP PDUs: polynomial 0x1021, start 0xFFFF, not reflected, no final
// inversion ("CCITT-FALSE", ECSS-E-ST-70-41C annex B.1). Over data followed by their own CRC it gives 0.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace ilp {

namespace detail {
constexpr std::array<std::uint16_t, 256> make_crc16_table() {
  std::array<std::uint16_t, 256> table{};
  for (unsigned i = 0; i < 256; ++i) {
    unsigned value = i << 8U;
    for (int bit = 0; bit < 8; ++bit) value = (value << 1U) ^ ((value & 0x8000U) != 0 ? 0x1021U : 0U);
    table[i] = static_cast<std::uint16_t>(value & 0xFFFFU);
  }
  return table;
}
inline constexpr auto crc16_table = make_crc16_table();
}  // namespace detail

/// Returns the CRC of `bytes`. To continue over further bytes, pass the previous result as `start`.
[[nodiscard]] constexpr std::uint16_t crc16(std::span<const std::uint8_t> bytes, std::uint16_t start = 0xFFFF) {
  unsigned value = start;
  for (const std::uint8_t byte : bytes) {
    value = ((value << 8U) & 0xFFFFU) ^ detail::crc16_table[((value >> 8U) ^ byte) & 0xFFU];
  }
  return static_cast<std::uint16_t>(value);
}

}  // namespace ilp
