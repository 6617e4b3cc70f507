#include "fsw/navigation/vehicle_packets.hpp"

#include "fsw/packets/bytes.hpp"

namespace ilp {
namespace {

constexpr std::uint8_t housekeeping = 3;
constexpr std::uint8_t housekeeping_report = 25;
constexpr std::size_t report_bytes = 1 + 8 * (navigation_column_count - 1);
/// Of one call: packets that are not meant for the flight do not hold it up.
constexpr int packets_at_once = 64;

}  // namespace

Status encode_navigation_packet(const NavigationSample& sample, UtcNs utc, std::uint16_t apid, std::uint16_t count,
                                std::span<std::uint8_t> out, std::size_t& bytes) {
  std::array<std::uint8_t, report_bytes> data{};
  ByteWriter writer(data);
  writer.u8(navigation_report_id);
  NavigationSample values = sample;
  for (const NavigationColumn& column : navigation_columns()) {
    if (column.value != nullptr) writer.f64(*column.value(values));
  }
  Telemetry telemetry;
  telemetry.primary.apid = apid;
  telemetry.primary.sequence_count = count % sequence_counts;
  telemetry.service = housekeeping;
  telemetry.subtype = housekeeping_report;
  telemetry.counter = count;
  telemetry.time = utc;
  telemetry.data = data;
  return encode_telemetry(telemetry, vehicle_time, out, bytes);
}

/// The next datagram, when nothing is left of the previous one.
Status VehiclePackets::receive() {
  if (begin_ < end_) return {};
  begin_ = end_ = 0;
  std::size_t bytes = 0;
  ILP_TRY(link_.receive(datagram_, bytes));
  end_ = bytes < datagram_.size() ? bytes : datagram_.size();
  return {};
}

Result<bool> VehiclePackets::take(std::span<const std::uint8_t> packet, TimeNs now, NavigationSample& sample) {
  PrimaryHeader header;
  ILP_TRY(decode_primary(packet, header));
  if (header.apid != mission_.vehicle_apid || header.telecommand) return false;
  Telemetry telemetry;
  ILP_TRY(decode_telemetry(packet, mission_.vehicle_apid, vehicle_time, telemetry));
  if (telemetry.service != housekeeping || telemetry.subtype != housekeeping_report) return false;
  ByteReader in(telemetry.data);
  if (in.u8() != navigation_report_id || !in.ok()) return false;
  if (telemetry.data.size() != report_bytes) {
    return Status{StatusCode::packet_length, static_cast<std::int64_t>(report_bytes),
                  static_cast<std::int64_t>(telemetry.data.size())};
  }
  NavigationSample read;
  read.time_ns = MissionTime(mission_.mission_epoch_s).mission(telemetry.time);
  for (const NavigationColumn& column : navigation_columns()) {
    if (column.value != nullptr) *column.value(read) = in.f64();
  }
  if (read.time_ns > now + most_ahead_ns) return Status{StatusCode::time_in_future, read.time_ns - now};
  if (read.time_ns <= latest_ns_) return Status{StatusCode::time_not_monotonic, 0, latest_ns_ - read.time_ns};
  latest_ns_ = read.time_ns;
  sample = read;
  return true;
}

Status VehiclePackets::next(TimeNs now, NavigationSample& sample) {
  for (int i = 0; i < packets_at_once; ++i) {
    ILP_TRY(receive());
    const std::span<const std::uint8_t> left = std::span(datagram_).subspan(begin_, end_ - begin_);
    std::span<const std::uint8_t> packet;
    const Status cut = first_packet(left, packet);
    begin_ = cut.ok() ? begin_ + packet.size() : end_;
    ILP_TRY(cut);
    ILP_TAKE(const bool ours, take(packet, now, sample));
    if (ours) return {};
  }
  return StatusCode::not_ready;
}

}  // namespace ilp
