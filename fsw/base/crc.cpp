#include "fsw/base/crc.hpp"

#include <array>

namespace ilp {
namespace {

using Table = std::array<std::uint32_t, 256>;

/// `polynomial`: reflected.
constexpr Table make_table(std::uint32_t polynomial) {
  Table table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t value = i;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1U) ^ ((value & 1U) != 0 ? polynomial : 0U);
    table[i] = value;
  }
  return table;
}
constexpr Table iso_hdlc = make_table(0xEDB88320U);
constexpr Table castagnoli = make_table(0x82F63B78U);

std::uint32_t run(const Table& table, std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  std::uint32_t value = ~crc;
  for (const std::uint8_t byte : bytes) value = (value >> 8U) ^ table[(value ^ byte) & 0xFFU];
  return ~value;
}

}  // namespace

std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  return run(iso_hdlc, bytes, crc);
}

std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  return run(castagnoli, bytes, crc);
}

}  // namespace ilp
