// Authentication of space packets in the manner of CCSDS 355.0-B: a security header (SPI, sequence number) follows the
// primary header, a message authentication code follows the data. The sizes are those of its baseline for telecommands.
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
inline constexpr std::size_t security_trailer_bytes = 16;  ///< first half of the HMAC-SHA-256 of all octets before it
inline constexpr std::size_t security_bytes = security_header_bytes + security_trailer_bytes;
inline constexpr std::size_t min_key_bytes = 16;
inline constexpr std::size_t max_key_bytes = 64;

/// The highest sequence number that was received in one security association.
struct SequenceMark {
  std::uint32_t highest = 0;
  std::uint16_t spi = 0;
  std::uint16_t padding = 0;

  friend bool operator==(const SequenceMark&, const SequenceMark&) = default;
};
using SequenceMarks = FixedVector<SequenceMark, limits::max_security_associations>;

/// Checks packets against the keys of its security associations, and refuses replayed packets.
class Authenticator {
 public:
  /// Adds a security association. Returns `invalid_argument` for an SPI that was added before, or a key not of
  /// min_key_bytes to max_key_bytes; `capacity_exceeded` if there are too many associations.
  Status add(std::uint16_t spi, std::span<const std::uint8_t> key);
  /// The key that was added first, which also signs maps. Empty if there is no key.
  [[nodiscard]] std::span<const std::uint8_t> first_key() const;
  /// Adds the keys of a text with lines `SPI KEY`: the SPI is from 1 to 65535, the key is hexadecimal, and `#` begins a
  /// comment. Returns `parse_error` (first value: number of the line) or `capacity_exceeded`.
  Status add_keys(std::span<const char> text);
  [[nodiscard]] bool empty() const { return associations_.empty(); }

  /// Checks one complete space packet, removes security header and trailer, and adapts the length field; `bytes` octets
  /// remain. Returns `authentication_missing` if the packet is too short, `authentication_key` for an unknown SPI,
  /// `authentication_code` for a wrong code, or `authentication_replay` (values: SPI, sequence number); the packet then
  /// stays unchanged. Of the sequence numbers below the highest one, the last 63 are accepted once each, older ones
  /// never.
  Status open(std::span<std::uint8_t> packet, std::size_t& bytes);

  /// The marks of all associations, which survive a restart.
  [[nodiscard]] SequenceMarks marks() const;
  /// After a restart: accepts only sequence numbers above the marks. Marks with an unknown SPI are ignored.
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

/// The sender's side: writes the packet with security header and trailer to `out`; `bytes` gets the length. Returns
/// `truncated` if `packet` has no octet after its primary header, `capacity_exceeded` if the result does not fit. The
/// caller uses every sequence number once, from 1 on.
Status seal(std::span<const std::uint8_t> packet, std::uint16_t spi, std::uint32_t sequence,
            std::span<const std::uint8_t> key, std::span<std::uint8_t> out, std::size_t& bytes);

}  // namespace ilp
