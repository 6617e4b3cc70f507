// Reads navigation samples from housekeeping packets of the vehicle's computer.
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

/// SID of the vehicle's report that contains a sample.
inline constexpr std::uint8_t navigation_report_id = 1;
/// Time format of the vehicle's packets: CDS with microseconds and P-field.
inline constexpr TimeFormat vehicle_time{.sub_ms_octets = 2};
inline constexpr std::size_t max_navigation_packet_bytes = primary_header_bytes + telemetry_header_bytes +
                                                           max_time_bytes + 1 + 8 * (navigation_column_count - 1) +
                                                           crc16_bytes;

/// Encodes TM[3,25] of ECSS-E-ST-70-41C with one sample that was measured at `utc`: time as CDS with P-field, SID, then
/// the values of navigation_columns() without the time, as IEEE doubles. `count` is the sequence count. The interface
/// control document describes the packet. Returns the faults of encode_telemetry.
Status encode_navigation_packet(const NavigationSample& sample, UtcNs utc, std::uint16_t apid, std::uint16_t count,
                                std::span<std::uint8_t> out, std::size_t& bytes);

/// The link is used by the vehicle's computer only, because the link to the ground is read only during contact. Packets
/// of other applications, and other packets of the vehicle's application, are ignored.
class VehiclePackets final : public NavigationSource {
 public:
  /// Most time by which the vehicle's clock may be ahead of the mission's clock.
  static constexpr TimeNs most_ahead_ns = ns_per_s;

  /// `mission` gives the vehicle's APID and the mission epoch.
  VehiclePackets(PacketLink& link, const MissionParameters& mission) : link_(link), mission_(mission) {}

  [[nodiscard]] bool recorded() const override { return false; }
  /// Returns the statuses of the interface, faults of the link, and, for a packet that was left out, the faults of
  /// decode_telemetry, `packet_length` also for a report of another size, `time_in_future` (first value: ns), or
  /// `time_not_monotonic` (second value: ns) for a sample that is not later than its predecessor.
  Status next(TimeNs now, NavigationSample& sample) override;

 private:
  Status receive();
  /// Decodes one packet. Returns false if it contains no sample.
  Result<bool> take(std::span<const std::uint8_t> packet, TimeNs now, NavigationSample& sample);

  PacketLink& link_;
  const MissionParameters& mission_;
  std::array<std::uint8_t, limits::max_vehicle_datagram_bytes> datagram_{};
  std::size_t begin_ = 0, end_ = 0;  ///< range of the datagram that was not read yet
  TimeNs latest_ns_ = std::numeric_limits<TimeNs>::min();
};

}  // namespace ilp
