// CCSDS space packets (133.0-B): the primary header, and packets cut out of a stream or a datagram.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"
#include "fsw/packets/bytes.hpp"

namespace ilp {

inline constexpr std::size_t primary_header_bytes = 6;
inline constexpr std::uint16_t max_apid = 0x7FF;
inline constexpr std::uint16_t idle_apid = 0x7FF;
inline constexpr std::uint16_t sequence_counts = 0x4000;  ///< the count that follows 16383 is 0
inline constexpr std::uint8_t unsegmented = 3;

struct PrimaryHeader {
  std::uint8_t version = 0;  ///< 3 bits
  bool telecommand = false;
  bool secondary_header = true;
  std::uint16_t apid = 0;  ///< 11 bits
  std::uint8_t sequence_flags = unsegmented;
  std::uint16_t sequence_count = 0;  ///< 14 bits
  std::uint16_t data_length = 0;     ///< octets after this header, minus 1
};

/// Length of the whole packet, by its header.
[[nodiscard]] constexpr std::size_t packet_bytes(const PrimaryHeader& header) {
  return primary_header_bytes + header.data_length + 1U;
}

/// `packet_too_short` for less than six octets; any six octets are a header.
Status decode_primary(std::span<const std::uint8_t> bytes, PrimaryHeader& header);
void encode_primary(const PrimaryHeader& header, ByteWriter& out);

/// The whole packet at the front of `bytes`, by its length field. `packet_too_short` when it extends beyond `bytes`.
Status first_packet(std::span<const std::uint8_t> bytes, std::span<const std::uint8_t>& packet);

}  // namespace ilp
