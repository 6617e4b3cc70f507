// A link in memory with two ends and the faults of radio links: loss, duplication, reordering, delay and outages.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/base/rng.hpp"
#include "hal/clock/clock.hpp"
#include "hal/link/packet_link.hpp"

namespace ilp {

/// Probabilities are for each packet, in either direction. The same seed and the same packets give the same faults.
struct LoopbackFaults {
  std::uint64_t seed = 1;
  double loss = 0;                  ///< probability that a packet is lost
  double duplication = 0;           ///< probability that it arrives twice
  double reordering = 0;            ///< probability that it is delayed by `late_ns` more, and thus arrives after others
  TimeNs delay_ns = 0;              ///< delay of every packet
  TimeNs late_ns = 50 * ns_per_ms;  ///< additional delay of a reordered packet
  TimeNs outage_period_ns = 0;      ///< period of outages; 0: no outages
  TimeNs outage_length_ns = 0;      ///< time at the end of each period during which all packets are lost
};

/// A bounded queue of packets in transit in one direction. An object has about 2 MiB.
class LoopbackDirection {
 public:
  static constexpr std::size_t capacity = 512;
  static constexpr std::size_t packet_bytes = 4096;

  /// Enters a packet that arrives at `due`. Returns `not_ready` if the queue is full, and `capacity_exceeded` if the
  /// packet exceeds packet_bytes.
  Status put(std::span<const std::uint8_t> packet, TimeNs due);
  /// Removes the packet that is due first, if it is due at `now`. Packets with equal times come in the order of
  /// sending.
  Status take(std::span<std::uint8_t> out, std::size_t& bytes, TimeNs now);

 private:
  struct Slot {
    std::array<std::uint8_t, packet_bytes> bytes;
    std::size_t size;
    TimeNs due;
    std::uint64_t number;
    bool used;
  };
  std::array<Slot, capacity> slots_{};
  std::uint64_t next_ = 0;
};

class LoopbackEnd final : public PacketLink {
 public:
  LoopbackEnd(LoopbackDirection& in, LoopbackDirection& out, Clock& clock, const LoopbackFaults& faults,
              std::uint64_t stream);
  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override;
  /// Also returns ok for a packet that is lost in transit.
  Status send(std::span<const std::uint8_t> packet) override;

  /// Number of packets from this end that were lost.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

 private:
  [[nodiscard]] bool outage(TimeNs now) const;
  /// Draws the arrival time of a packet.
  TimeNs due(TimeNs now);

  LoopbackDirection& in_;
  LoopbackDirection& out_;
  Clock& clock_;
  const LoopbackFaults& faults_;
  Rng rng_;
  std::uint64_t lost_ = 0;
};

class LoopbackLink {
 public:
  LoopbackLink(Clock& clock, const LoopbackFaults& faults);
  PacketLink& board() { return board_; }
  PacketLink& ground() { return ground_; }
  /// Faults of packets; changes apply to packets that are sent later.
  LoopbackFaults& faults() { return faults_; }
  [[nodiscard]] std::uint64_t lost() const { return board_.lost() + ground_.lost(); }

 private:
  LoopbackFaults faults_;
  LoopbackDirection up_, down_;
  LoopbackEnd board_, ground_;
};

}  // namespace ilp
