#include "fsw/base/crc.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "fsw/base/little_endian.hpp"

namespace ilp {
namespace {

/// Slicing by sixteen (after M. E. Kounavis, F. L. Berry, "Novel Table Lookup-Based Algorithms for High-Performance CRC
/// Generation", IEEE Trans. Computers 57(11), 2008): table k is the effect of a byte that k further bytes follow.
using Tables = std::array<std::array<std::uint32_t, 256>, 16>;

/// `polynomial` is reflected.
constexpr Tables make_tables(std::uint32_t polynomial) {
  Tables tables{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t value = i;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1U) ^ ((value & 1U) != 0 ? polynomial : 0U);
    tables[0][i] = value;
  }
  for (std::size_t k = 1; k < tables.size(); ++k) {
    for (std::uint32_t i = 0; i < 256; ++i) {
      const std::uint32_t before = tables[k - 1][i];
      tables[k][i] = (before >> 8U) ^ tables[0][before & 0xFFU];
    }
  }
  return tables;
}
constexpr Tables iso_hdlc = make_tables(0xEDB88320U);
constexpr std::uint32_t castagnoli_polynomial = 0x82F63B78U;
constexpr Tables castagnoli = make_tables(castagnoli_polynomial);

/// As load_little_endian, in one instruction on a little-endian machine.
std::uint32_t load(const std::uint8_t* from) {
  if constexpr (std::endian::native == std::endian::little) {
    std::uint32_t value;
    std::memcpy(&value, from, sizeof(value));
    return value;
  } else {
    return load_little_endian<std::uint32_t>(from);
  }
}

/// The effect of the four bytes of `word` when `k` bytes follow.
std::uint32_t effect(const Tables& t, std::uint32_t word, std::size_t k) {
  return t[k + 3][word & 0xFFU] ^ t[k + 2][word >> 8U & 0xFFU] ^ t[k + 1][word >> 16U & 0xFFU] ^ t[k][word >> 24U];
}

std::uint32_t run(const Tables& t, std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  std::uint32_t value = ~crc;
  const std::uint8_t* at = bytes.data();
  std::size_t left = bytes.size();
  for (; left >= 16; at += 16, left -= 16) {
    value = effect(t, value ^ load(at), 12) ^ effect(t, load(at + 4), 8) ^ effect(t, load(at + 8), 4) ^
            effect(t, load(at + 12), 0);
  }
  for (; left > 0; ++at, --left) value = (value >> 8U) ^ t[0][(value ^ *at) & 0xFFU];
  return ~value;
}

}  // namespace

std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  return run(iso_hdlc, bytes, crc);
}

std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  return run(castagnoli, bytes, crc);
}

std::size_t crc32c_flipped_bit(std::size_t bytes, std::uint32_t difference) {
  // From the last bit backwards: every bit after a flipped bit shifts its effect on the remainder.
  std::uint32_t effect = castagnoli_polynomial;
  for (std::size_t bit = 8 * bytes; bit-- > 0;) {
    if (effect == difference) return bit;
    effect = (effect >> 1U) ^ ((effect & 1U) != 0 ? castagnoli_polynomial : 0U);
  }
  return 8 * bytes;
}

}  // namespace ilp
