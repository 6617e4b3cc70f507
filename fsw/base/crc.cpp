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

// A register's worth of bytes, and one byte, by the instruction of the processor.
#if defined(__x86_64__)
#define ILP_CRC32C_TARGET [[gnu::target("sse4.2")]]
ILP_CRC32C_TARGET inline std::uint32_t step_by_8(std::uint32_t value, std::uint64_t word) {
  return static_cast<std::uint32_t>(__builtin_ia32_crc32di(value, word));
}
ILP_CRC32C_TARGET inline std::uint32_t step_by_1(std::uint32_t value, std::uint8_t octet) {
  return __builtin_ia32_crc32qi(value, octet);
}
#elif defined(__aarch64__) && defined(__GNUC__) && !defined(__clang__)
#define ILP_CRC32C_TARGET [[gnu::target("+crc")]]
ILP_CRC32C_TARGET inline std::uint32_t step_by_8(std::uint32_t value, std::uint64_t word) {
  return __builtin_aarch64_crc32cx(value, word);
}
ILP_CRC32C_TARGET inline std::uint32_t step_by_1(std::uint32_t value, std::uint8_t octet) {
  return __builtin_aarch64_crc32cb(value, octet);
}
#endif

#if defined(ILP_CRC32C_TARGET)
/// Bytes of each of three streams that are summed at once, because an instruction waits for the one before in its
/// stream: three of them and a rest of 16 bytes are a page of a database.
constexpr std::size_t stream_bytes = 1360;

/// The effect of each byte of a sum when `stream_bytes` zero bytes follow.
using Shift = std::array<std::array<std::uint32_t, 256>, 4>;
constexpr Shift make_shift() {
  std::array<std::uint32_t, 32> columns{};
  for (std::size_t bit = 0; bit < columns.size(); ++bit) {
    std::uint32_t value = std::uint32_t{1} << bit;
    for (std::size_t i = 0; i < stream_bytes; ++i) value = (value >> 8U) ^ castagnoli[0][value & 0xFFU];
    columns[bit] = value;
  }
  Shift shift{};
  for (std::size_t k = 0; k < shift.size(); ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      for (std::size_t bit = 0; bit < 8; ++bit) shift[k][byte] ^= (byte >> bit & 1U) != 0 ? columns[8 * k + bit] : 0U;
    }
  }
  return shift;
}
constexpr Shift past_a_stream = make_shift();

std::uint32_t shifted(std::uint32_t crc) {
  return past_a_stream[0][crc & 0xFFU] ^ past_a_stream[1][crc >> 8U & 0xFFU] ^ past_a_stream[2][crc >> 16U & 0xFFU] ^
         past_a_stream[3][crc >> 24U];
}

std::uint64_t load_word(const std::uint8_t* from) {
  static_assert(std::endian::native == std::endian::little);
  std::uint64_t word;
  std::memcpy(&word, from, sizeof(word));
  return word;
}

ILP_CRC32C_TARGET std::uint32_t run_by_instructions(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  std::uint32_t value = ~crc;
  const std::uint8_t* at = bytes.data();
  std::size_t left = bytes.size();
  for (; left >= 3 * stream_bytes; at += 3 * stream_bytes, left -= 3 * stream_bytes) {
    std::uint32_t second = 0, third = 0;
    for (std::size_t i = 0; i < stream_bytes; i += sizeof(std::uint64_t)) {
      value = step_by_8(value, load_word(at + i));
      second = step_by_8(second, load_word(at + stream_bytes + i));
      third = step_by_8(third, load_word(at + 2 * stream_bytes + i));
    }
    value = shifted(shifted(value) ^ second) ^ third;
  }
  for (; left >= sizeof(std::uint64_t); at += sizeof(std::uint64_t), left -= sizeof(std::uint64_t)) {
    value = step_by_8(value, load_word(at));
  }
  for (; left > 0; ++at, --left) value = step_by_1(value, *at);
  return ~value;
}
#else
std::uint32_t run_by_instructions(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  return run(castagnoli, bytes, crc);
}
#endif

// Zero until somebody chooses, so that no code must run before main.
enum class Chosen : std::uint8_t { nothing, tables, instructions };
Chosen chosen = Chosen::nothing;

bool by_instructions() {
#if defined(__x86_64__)
  if (chosen == Chosen::nothing) return may_have_crc32c_instructions();
#endif
  return chosen == Chosen::instructions;
}

}  // namespace

void use_crc32c_instructions(bool use) {
  chosen = use ? Chosen::instructions : Chosen::tables;
}

bool may_have_crc32c_instructions() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("sse4.2");
#elif defined(ILP_CRC32C_TARGET)
  return true;
#else
  return false;
#endif
}

std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  return run(iso_hdlc, bytes, crc);
}

std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  return by_instructions() ? run_by_instructions(bytes, crc) : run(castagnoli, bytes, crc);
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
