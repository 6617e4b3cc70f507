// Packets of ECSS-E-ST-70-41C (PUS-C): telecommands and telemetry with their secondary headers and packet CRC.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"
#include "fsw/packets/space_packet.hpp"
#include "fsw/packets/time_code.hpp"

namespace ilp {

inline constexpr std::uint8_t pus_version = 2;
inline constexpr std::size_t telecommand_header_bytes = 5;
inline constexpr std::size_t telemetry_header_bytes = 7;  ///< followed by the time
inline constexpr std::size_t crc16_bytes = 2;
/// Primary header, secondary header and CRC.
inline constexpr std::size_t telecommand_overhead_bytes = primary_header_bytes + telecommand_header_bytes + crc16_bytes;

/// Success reports that a telecommand requests. Failures are always reported.
namespace ack {
inline constexpr std::uint8_t acceptance = 1, start = 2, progress = 4, completion = 8;
}

/// Identifies a telecommand by its source and the first four octets of its primary header.
struct RequestId {
  std::uint32_t packet = 0;  ///< the four octets, big-endian
  std::uint16_t source = 0;
  bool operator==(const RequestId&) const = default;
};

struct Telecommand {
  PrimaryHeader primary;
  std::uint8_t version = pus_version;
  std::uint8_t ack_flags = 0x0F;  ///< 4 bits of namespace ack
  std::uint8_t service = 0;
  std::uint8_t subtype = 0;
  std::uint16_t source = 0;
  std::span<const std::uint8_t> data;  ///< application data, which the struct does not own

  [[nodiscard]] RequestId request() const;
};

struct Telemetry {
  PrimaryHeader primary;
  std::uint8_t version = pus_version;
  std::uint8_t time_status = 0;  ///< spacecraft time reference status, 4 bits
  std::uint8_t service = 0;
  std::uint8_t subtype = 0;
  std::uint16_t counter = 0;  ///< per type of message and destination
  std::uint16_t destination = 0;
  UtcNs time = 0;
  std::span<const std::uint8_t> data;  ///< source data, which the struct does not own
};

/// Decodes one telecommand as received and addressed to `apid`. Returns the first of these faults that applies:
/// `packet_too_short` (no primary header), `packet_version`, `packet_type`, `packet_apid`, `packet_segmented`,
/// `packet_length`, `packet_no_secondary_header`, `packet_too_short` (no space for the headers and the CRC),
/// `packet_crc`, `packet_pus_version`. After a fault `telecommand` has every header whose octets exist, and no data.
Status decode_telecommand(std::span<const std::uint8_t> packet, std::uint16_t apid, Telecommand& telecommand);
/// Writes `telecommand` to `out`; packet type, length and CRC are computed. `bytes` gets the packet's length. Returns
/// `capacity_exceeded` if the packet does not fit into `out` or into its length field.
Status encode_telecommand(const Telecommand& telecommand, std::span<std::uint8_t> out, std::size_t& bytes);

/// Decodes one telemetry packet of `apid`. Returns the faults of decode_telecommand and decode_time.
Status decode_telemetry(std::span<const std::uint8_t> packet, std::uint16_t apid, const TimeFormat& time,
                        Telemetry& telemetry);
/// As encode_telecommand. Also returns `time_out_of_range` if the format cannot hold the time.
Status encode_telemetry(const Telemetry& telemetry, const TimeFormat& time, std::span<std::uint8_t> out,
                        std::size_t& bytes);

}  // namespace ilp
