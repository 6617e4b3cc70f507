#include "fsw/packets/space_packet.hpp"

namespace ilp {

Status decode_primary(std::span<const std::uint8_t> bytes, PrimaryHeader& header) {
  if (bytes.size() < primary_header_bytes) {
    return {StatusCode::packet_too_short, static_cast<std::int64_t>(bytes.size()), primary_header_bytes};
  }
  ByteReader in(bytes);
  const std::uint16_t identification = in.u16();
  const std::uint16_t sequence = in.u16();
  header.version = static_cast<std::uint8_t>(identification >> 13U);
  header.telecommand = (identification & 0x1000U) != 0;
  header.secondary_header = (identification & 0x0800U) != 0;
  header.apid = identification & max_apid;
  header.sequence_flags = static_cast<std::uint8_t>(sequence >> 14U);
  header.sequence_count = sequence & (sequence_counts - 1U);
  header.data_length = in.u16();
  return {};
}

void encode_primary(const PrimaryHeader& header, ByteWriter& out) {
  const unsigned identification = (static_cast<unsigned>(header.version & 7U) << 13U) |
                                  (header.telecommand ? 0x1000U : 0U) | (header.secondary_header ? 0x0800U : 0U) |
                                  (header.apid & max_apid);
  const unsigned sequence =
      (static_cast<unsigned>(header.sequence_flags & 3U) << 14U) | (header.sequence_count & (sequence_counts - 1U));
  out.u16(static_cast<std::uint16_t>(identification));
  out.u16(static_cast<std::uint16_t>(sequence));
  out.u16(header.data_length);
}

Status first_packet(std::span<const std::uint8_t> bytes, std::span<const std::uint8_t>& packet) {
  PrimaryHeader header;
  ILP_TRY(decode_primary(bytes, header));
  const std::size_t whole = packet_bytes(header);
  if (whole > bytes.size()) {
    return {StatusCode::packet_too_short, static_cast<std::int64_t>(bytes.size()), static_cast<std::int64_t>(whole)};
  }
  packet = bytes.first(whole);
  return {};
}

}  // namespace ilp
