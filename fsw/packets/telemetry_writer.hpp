// Numbers and stamps telemetry packets, and keeps them until they can be sent.
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

/// Packets are sent in the order in which they were made. Those that the router does not take wait in a ring of
/// limits::telemetry_ring_bytes. When it is full the oldest are lost, which leaves a gap in the sequence counts.
/// Destination 0 is everybody: housekeeping and events.
class TelemetryWriter {
 public:
  TelemetryWriter(PacketRouter& router, Clock& clock, const MissionParameters& mission);

  /// Takes [link] from the present mission parameters, and counts from 0 again.
  void configure();
  [[nodiscard]] const LinkSettings& settings() const { return settings_; }
  [[nodiscard]] UtcNs now() const { return stamp(clock_.now()); }
  /// The nearest UTC that the time format of the tailoring can hold.
  [[nodiscard]] UtcNs stamp(TimeNs mission) const {
    return nearest_time(settings_.tailoring.time, settings_.time.utc(mission));
  }

  /// `capacity_exceeded` for source data that does not fit into limits::max_report_bytes.
  Status report(std::uint8_t service, std::uint8_t subtype, std::uint16_t destination,
                std::span<const std::uint8_t> data);
  /// Passes packets to the router as long as it takes them. Call it in every minor frame.
  void flush();

  [[nodiscard]] std::uint32_t sent() const { return sent_; }
  [[nodiscard]] std::uint32_t lost() const { return lost_; }
  [[nodiscard]] std::uint32_t waiting() const { return waiting_; }

 private:
  /// Message count of one type to one destination.
  struct Counter {
    std::uint32_t key = 0;  ///< destination, service, subtype
    std::uint64_t used = 0;
    std::uint16_t next = 0;
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
