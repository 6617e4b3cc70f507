// Numbers telemetry packets, gives them their time, and keeps them until they can be sent.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/packets/link_settings.hpp"
#include "fsw/packets/packet_ring.hpp"
#include "fsw/packets/packet_router.hpp"
#include "fsw/packets/pus.hpp"

namespace ilp {

/// Packets are sent in the order in which they were made. Packets that the router does not take wait in a ring of
/// limits::telemetry_ring_bytes. When the ring is full the oldest packets are lost, which leaves a gap in the sequence
/// counts. Housekeeping and events have destination 0, which addresses every receiver.
class TelemetryWriter {
 public:
  TelemetryWriter(PacketRouter& router, Clock& clock, const MissionParameters& mission);

  /// Takes [link] from the present mission parameters, and resets the sequence count and the message counts to 0.
  void configure();
  [[nodiscard]] const LinkSettings& settings() const { return settings_; }
  [[nodiscard]] UtcNs now() const { return stamp(clock_.now()); }
  /// Mission time as UTC, clamped to the range of the tailoring's time format.
  [[nodiscard]] UtcNs stamp(TimeNs mission) const {
    return nearest_time(settings_.tailoring.time, settings_.time.utc(mission));
  }

  /// Makes a packet of the source data and sends it, or keeps it until it can be sent. Without a link it does nothing.
  /// Returns `capacity_exceeded` for a packet larger than limits::max_report_bytes.
  Status report(std::uint8_t service, std::uint8_t subtype, std::uint16_t destination,
                std::span<const std::uint8_t> data);
  /// Passes packets to the router as long as it takes them. Call it in every minor frame.
  void flush();

  /// Numbers of packets: sent and lost since the start, and waiting now.
  [[nodiscard]] std::uint32_t sent() const { return sent_; }
  [[nodiscard]] std::uint32_t lost() const { return lost_; }
  [[nodiscard]] std::uint32_t waiting() const { return waiting_; }

 private:
  /// Message count of one type to one destination. The counter that was not used for the longest time is replaced.
  struct Counter {
    std::uint32_t key = 0;   ///< destination, service, subtype
    std::uint64_t used = 0;  ///< value of uses_ at the latest use; 0: free
    std::uint16_t next = 0;  ///< the next message count
  };
  std::uint16_t count(std::uint8_t service, std::uint8_t subtype, std::uint16_t destination);
  void push(std::span<const std::uint8_t> packet);

  PacketRouter& router_;
  Clock& clock_;
  const MissionParameters& mission_;
  LinkSettings settings_;
  std::array<Counter, limits::message_counters> counters_{};
  std::uint64_t uses_ = 0;
  std::uint16_t sequence_ = 0;
  std::uint32_t sent_ = 0, lost_ = 0, waiting_ = 0;
  std::array<std::uint8_t, limits::max_report_bytes> next_{};  ///< the oldest waiting packet
  std::size_t next_bytes_ = 0;                                 ///< 0: none
  PacketRing<limits::telemetry_ring_bytes> ring_;
};

}  // namespace ilp
