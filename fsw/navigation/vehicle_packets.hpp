// Navigation samples out of housekeeping packets of the vehicle's computer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "cfg/limits.hpp"
#include "cfg/mission.hpp"
#include "fsw/base/navigation_sample.hpp"
#include "fsw/base/result.hpp"
#include "fsw/packets/pus.hpp"
#include "fsw/packets/space_packet.hpp"
#include "fsw/packets/time_code.hpp"
#include "hal/link/packet_link.hpp"
#include "hal/navigation/navigation.hpp"

namespace ilp {

/// SID of the report that holds a sample, among the reports of the vehicle's computer.
inline constexpr std::uint8_t navigation_report_id = 1;
/// CDS with microseconds; a P-field says so.
inline constexpr TimeFormat vehicle_time{.sub_ms_octets = 2};
inline constexpr std::size_t max_navigation_packet_bytes = primary_header_bytes + telemetry_header_bytes +
                                                           max_time_bytes + 1 + 8 * (navigation_column_count - 1) +
                                                           crc16_bytes;

/// Makes TM[3,25] of ECSS-E-ST-70-41C with one sample, measured at `utc`: time as CDS with P-field, SID, then the
/// values of navigation_columns() but the time, as IEEE doubles. A quantity whose sigma is 0 was not measured. The
/// interface control document describes the packet. `capacity_exceeded`, `time_out_of_range`.
Status encode_navigation_packet(const NavigationSample& sample, UtcNs utc, std::uint16_t apid, std::uint16_t count,
                                std::span<std::uint8_t> out, std::size_t& bytes);

/// The link belongs to the vehicle's computer alone, because the link to the ground is heard in contact only. Packets
/// of other applications, and other packets of this one, are passed over.
class VehiclePackets final : public NavigationSource {
 public:
  /// A clock of the vehicle may be ahead of the mission's clock by this much.
  static constexpr TimeNs most_ahead_ns = ns_per_s;

  /// The mission says which APID is the vehicle's, and when mission time began.
  VehiclePackets(PacketLink& link, const MissionParameters& mission) : link_(link), mission_(mission) {}

  [[nodiscard]] bool recorded() const override { return false; }
  /// Besides the statuses of the interface: those of decode_telemetry for a packet that was left out, `packet_length`
  /// also for a report of another size, `time_in_future` (a = ns), `time_not_monotonic` (b = ns) for one that is not
  /// later than its predecessor, and faults of the link.
  Status next(TimeNs now, NavigationSample& sample) override;

 private:
  Status receive();
  /// False for a packet that is not meant for the flight.
  Result<bool> take(std::span<const std::uint8_t> packet, TimeNs now, NavigationSample& sample);

  PacketLink& link_;
  const MissionParameters& mission_;
  std::array<std::uint8_t, limits::max_vehicle_datagram_bytes> datagram_{};
  std::size_t begin_ = 0, end_ = 0;  ///< of what is left of the datagram
  TimeNs latest_ns_ = std::numeric_limits<TimeNs>::min();
};

}  // namespace ilp
