// CCSDS space packets (133.0-B): reads and writes primary headers, and splits octets into packets.
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
inline constexpr std::uint8_t unsegmented = 3;            ///< sequence flags of a packet that is not a segment

struct PrimaryHeader {
  std::uint8_t version = 0;      ///< 3 bits
  bool telecommand = false;      ///< packet type; false: telemetry
  bool secondary_header = true;  ///< a secondary header follows
  std::uint16_t apid = 0;        ///< 11 bits
  std::uint8_t sequence_flags = unsegmented;
  std::uint16_t sequence_count = 0;  ///< 14 bits
  std::uint16_t data_length = 0;     ///< octets after this header, minus 1
};

/// Total length of the packet in octets, from its length field.
[[nodiscard]] constexpr std::size_t packet_bytes(const PrimaryHeader& header) {
  return primary_header_bytes + header.data_length + 1U;
}

/// Reads the primary header at the front of `bytes`. Returns `packet_too_short` for less than six octets; any six
/// octets are a header.
Status decode_primary(std::span<const std::uint8_t> bytes, PrimaryHeader& header);
/// Appends the six octets of the header to `out`.
void encode_primary(const PrimaryHeader& header, ByteWriter& out);

/// Finds the packet at the front of `bytes` from its length field. Returns `packet_too_short` when it extends beyond
/// `bytes`.
Status first_packet(std::span<const std::uint8_t> bytes, std::span<const std::uint8_t>& packet);

}  // namespace ilp
