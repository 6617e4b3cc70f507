// Authentication of space packets in the manner of CCSDS 355.0-B, whose baseline for telecommands gives the sizes: a
// security header (SPI, sequence number) follows the primary header, a message authentication code follows the data.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/status.hpp"
#include "fsw/packets/hmac_sha256.hpp"

namespace ilp {

inline constexpr std::size_t security_header_bytes = 6;    ///< SPI 16 bits, sequence number 32 bits
inline constexpr std::size_t security_trailer_bytes = 16;  ///< first half of HMAC-SHA-256 over all octets before it
inline constexpr std::size_t security_bytes = security_header_bytes + security_trailer_bytes;
inline constexpr std::size_t min_key_bytes = 16;
inline constexpr std::size_t max_key_bytes = 64;

/// The highest sequence number of one security association.
struct SequenceMark {
  std::uint32_t highest = 0;
  std::uint16_t spi = 0;
  std::uint16_t padding = 0;

  friend bool operator==(const SequenceMark&, const SequenceMark&) = default;
};
using SequenceMarks = FixedVector<SequenceMark, limits::max_security_associations>;

class Authenticator {
 public:
  /// `invalid_argument` for a known SPI or a key of another length, `capacity_exceeded`.
  Status add(std::uint16_t spi, std::span<const std::uint8_t> key);
  /// The first one that was added, which also signs maps; empty: there is none.
  [[nodiscard]] std::span<const std::uint8_t> first_key() const;
  /// Reads lines `SPI KEY`, the SPI from 1 to 65535, the key in hexadecimal; `#` begins a comment. `parse_error` (a =
  /// line).
  Status add_keys(std::span<const char> text);
  [[nodiscard]] bool empty() const { return associations_.empty(); }

  /// Checks a whole space packet and removes security header and trailer: `bytes` octets remain, with the length field
  /// adapted. `authentication_missing`, `authentication_key`, `authentication_code`, `authentication_replay` (a = SPI,
  /// b = sequence number) leave the packet unchanged. Of the sequence numbers below the highest one, the last 63 are
  /// accepted once each, older ones never.
  Status open(std::span<std::uint8_t> packet, std::size_t& bytes);

  [[nodiscard]] SequenceMarks marks() const;
  /// After a restart, accepts only sequence numbers above the marks. Marks of other associations are ignored.
  void resume(const SequenceMarks& marks);

 private:
  struct Association {
    std::uint16_t spi = 0;
    std::uint32_t highest = 0;
    std::uint64_t seen = ~std::uint64_t{0};  ///< bit i: `highest` - i was received
    std::array<std::uint8_t, max_key_bytes> key{};
    std::size_t key_bytes = 0;
  };
  Association* find(std::uint16_t spi);
  Status add_line(std::span<const char> line);

  FixedVector<Association, limits::max_security_associations> associations_;
};

/// The sender's side: writes the packet with security header and trailer to `out`. `truncated` if `packet` is no whole
/// space packet, `capacity_exceeded`. Every sequence number is used once, from 1 on.
Status seal(std::span<const std::uint8_t> packet, std::uint16_t spi, std::uint32_t sequence,
            std::span<const std::uint8_t> key, std::span<std::uint8_t> out, std::size_t& bytes);

}  // namespace ilp
