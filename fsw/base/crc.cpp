#include "fsw/base/crc.hpp"

#include <array>

namespace ilp {
namespace {

constexpr std::array<std::uint32_t, 256> make_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t value = i;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1U) ^ ((value & 1U) != 0 ? 0xEDB88320U : 0U);
    table[i] = value;
  }
  return table;
}
constexpr auto table = make_table();

}  // namespace

std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  std::uint32_t value = ~crc;
  for (const std::uint8_t byte : bytes) value = (value >> 8U) ^ table[(value ^ byte) & 0xFFU];
  return ~value;
}

}  // namespace ilp
