#include "fsw/base/crc.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "fsw/base/little_endian.hpp"

#if defined(__aarch64__)
#include <sys/auxv.h>
#endif

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

// Until a test chooses, the processor decides.
enum class Chosen : std::uint8_t { nothing, tables, instruction };
Chosen chosen = Chosen::nothing;

// ---- the processor's own instruction ----

#if defined(__x86_64__)
#define ILP_TARGET_CRC [[gnu::target("sse4.2")]]
ILP_TARGET_CRC std::uint32_t add_word(std::uint32_t crc, std::uint64_t word) {
  return static_cast<std::uint32_t>(__builtin_ia32_crc32di(crc, word));
}
ILP_TARGET_CRC std::uint32_t add_byte(std::uint32_t crc, std::uint8_t byte) {
  return __builtin_ia32_crc32qi(crc, byte);
}
bool processor_has_it() {
  return __builtin_cpu_supports("sse4.2") != 0;
}
#elif defined(__aarch64__)
#define ILP_TARGET_CRC [[gnu::target("+crc")]]
ILP_TARGET_CRC std::uint32_t add_word(std::uint32_t crc, std::uint64_t word) {
  return __builtin_aarch64_crc32cx(crc, word);
}
ILP_TARGET_CRC std::uint32_t add_byte(std::uint32_t crc, std::uint8_t byte) {
  return __builtin_aarch64_crc32cb(crc, byte);
}
bool processor_has_it() {
  return (getauxval(AT_HWCAP) & HWCAP_CRC32) != 0;
}
#endif

#if defined(ILP_TARGET_CRC)

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

ILP_TARGET_CRC std::uint32_t run_instruction(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  std::uint32_t value = ~crc;
  const std::uint8_t* at = bytes.data();
  std::size_t left = bytes.size();
  for (; left >= 3 * stream_bytes; at += 3 * stream_bytes, left -= 3 * stream_bytes) {
    std::uint32_t second = 0, third = 0;
    for (std::size_t i = 0; i < stream_bytes; i += sizeof(std::uint64_t)) {
      value = add_word(value, load_word(at + i));
      second = add_word(second, load_word(at + stream_bytes + i));
      third = add_word(third, load_word(at + 2 * stream_bytes + i));
    }
    value = shifted(shifted(value) ^ second) ^ third;
  }
  for (; left >= sizeof(std::uint64_t); at += sizeof(std::uint64_t), left -= sizeof(std::uint64_t)) {
    value = add_word(value, load_word(at));
  }
  for (; left > 0; ++at, --left) value = add_byte(value, *at);
  return ~value;
}
#endif

}  // namespace

bool has_crc32c_instruction() {
#if defined(ILP_TARGET_CRC)
  return processor_has_it();
#else
  return false;
#endif
}

void use_crc32c_instruction(bool use) {
  chosen = use ? Chosen::instruction : Chosen::tables;
}

std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  return run(iso_hdlc, bytes, crc);
}

std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
#if defined(ILP_TARGET_CRC)
  if (chosen == Chosen::instruction || (chosen == Chosen::nothing && has_crc32c_instruction())) {
    return run_instruction(bytes, crc);
  }
#endif
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
