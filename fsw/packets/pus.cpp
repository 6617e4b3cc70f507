#include "fsw/packets/pus.hpp"

#include "fsw/packets/crc16.hpp"

namespace ilp {
namespace {

constexpr std::size_t length_at = 4;

/// The common checks of telecommands and telemetry. `body` is the part between primary header and CRC.
Status check_packet(std::span<const std::uint8_t> packet, bool telecommand, std::uint16_t apid,
                    const PrimaryHeader& primary, std::size_t header_bytes) {
  const auto size = static_cast<std::int64_t>(packet.size());
  if (primary.version != 0) return {StatusCode::packet_version, primary.version};
  if (primary.telecommand != telecommand) return {StatusCode::packet_type, primary.telecommand ? 1 : 0};
  if (primary.apid != apid) return {StatusCode::packet_apid, primary.apid, apid};
  if (primary.sequence_flags != unsegmented) return {StatusCode::packet_segmented, primary.sequence_flags};
  if (packet_bytes(primary) != packet.size()) {
    return {StatusCode::packet_length, static_cast<std::int64_t>(packet_bytes(primary)), size};
  }
  if (!primary.secondary_header) return StatusCode::packet_no_secondary_header;
  const std::size_t least = primary_header_bytes + header_bytes + crc16_bytes;
  if (packet.size() < least) return {StatusCode::packet_too_short, size, static_cast<std::int64_t>(least)};
  if (crc16(packet) != 0) return {StatusCode::packet_crc, crc16(packet.first(packet.size() - crc16_bytes))};
  return {};
}

/// Writes length and CRC.
Status finish(ByteWriter& body, std::span<std::uint8_t> out, std::size_t& bytes) {
  const std::size_t size = body.size() + crc16_bytes;
  if (!body.ok() || size > out.size() || size > primary_header_bytes + 0x10000U) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(size), static_cast<std::int64_t>(out.size())};
  }
  const auto length = static_cast<std::uint16_t>(size - primary_header_bytes - 1);
  out[length_at] = static_cast<std::uint8_t>(length >> 8U);
  out[length_at + 1] = static_cast<std::uint8_t>(length & 0xFFU);
  body.u16(crc16(out.first(size - crc16_bytes)));
  bytes = size;
  return {};
}

}  // namespace

RequestId Telecommand::request() const {
  std::uint8_t head[primary_header_bytes] = {};
  ByteWriter out(head);
  encode_primary(primary, out);
  return {static_cast<std::uint32_t>(ByteReader(head).number(4)), source};
}

Status decode_telecommand(std::span<const std::uint8_t> packet, std::uint16_t apid, Telecommand& telecommand) {
  telecommand = {};
  ILP_TRY(decode_primary(packet, telecommand.primary));
  ByteReader in(packet.subspan(primary_header_bytes));
  if (telecommand.primary.secondary_header && in.left() >= telecommand_header_bytes) {
    const std::uint8_t first = in.u8();
    telecommand.version = first >> 4U;
    telecommand.ack_flags = first & 0x0FU;
    telecommand.service = in.u8();
    telecommand.subtype = in.u8();
    telecommand.source = in.u16();
  }
  ILP_TRY(check_packet(packet, true, apid, telecommand.primary, telecommand_header_bytes));
  if (telecommand.version != pus_version) return {StatusCode::packet_pus_version, telecommand.version};
  telecommand.data = in.take(in.left() - crc16_bytes);
  return {};
}

Status encode_telecommand(const Telecommand& telecommand, std::span<std::uint8_t> out, std::size_t& bytes) {
  ByteWriter body(out);
  PrimaryHeader primary = telecommand.primary;
  primary.telecommand = true;
  encode_primary(primary, body);
  body.u8(static_cast<std::uint8_t>((std::uint32_t{telecommand.version} << 4U) | (telecommand.ack_flags & 0x0FU)));
  body.u8(telecommand.service);
  body.u8(telecommand.subtype);
  body.u16(telecommand.source);
  body.put(telecommand.data);
  return finish(body, out, bytes);
}

Status decode_telemetry(std::span<const std::uint8_t> packet, std::uint16_t apid, const TimeFormat& time,
                        Telemetry& telemetry) {
  telemetry = {};
  ILP_TRY(decode_primary(packet, telemetry.primary));
  ILP_TRY(check_packet(packet, false, apid, telemetry.primary, telemetry_header_bytes));
  ByteReader in(packet.subspan(primary_header_bytes, packet.size() - primary_header_bytes - crc16_bytes));
  const std::uint8_t first = in.u8();
  telemetry.version = first >> 4U;
  telemetry.time_status = first & 0x0FU;
  telemetry.service = in.u8();
  telemetry.subtype = in.u8();
  telemetry.counter = in.u16();
  telemetry.destination = in.u16();
  if (telemetry.version != pus_version) return {StatusCode::packet_pus_version, telemetry.version};
  ILP_TRY(decode_time(time, in, telemetry.time));
  telemetry.data = in.rest();
  return {};
}

Status encode_telemetry(const Telemetry& telemetry, const TimeFormat& time, std::span<std::uint8_t> out,
                        std::size_t& bytes) {
  ByteWriter body(out);
  PrimaryHeader primary = telemetry.primary;
  primary.telecommand = false;
  encode_primary(primary, body);
  body.u8(static_cast<std::uint8_t>((std::uint32_t{telemetry.version} << 4U) | (telemetry.time_status & 0x0FU)));
  body.u8(telemetry.service);
  body.u8(telemetry.subtype);
  body.u16(telemetry.counter);
  body.u16(telemetry.destination);
  ILP_TRY(encode_time(time, telemetry.time, body));
  body.put(telemetry.data);
  return finish(body, out, bytes);
}

}  // namespace ilp
