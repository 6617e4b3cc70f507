// Two ends of a link in memory, with the faults of radio links.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/base/rng.hpp"
#include "hal/clock/clock.hpp"
#include "hal/link/packet_link.hpp"

namespace ilp {

/// Chances are per packet, in either direction. The same seed and the same packets give the same faults.
struct LoopbackFaults {
  std::uint64_t seed = 1;
  double loss = 0;
  double duplication = 0;
  double reordering = 0;  ///< chance to be `late_ns` late and thus after others
  TimeNs delay_ns = 0;
  TimeNs late_ns = 50 * ns_per_ms;
  TimeNs outage_period_ns = 0;  ///< 0: no outages; otherwise packets sent at the end of each period are lost
  TimeNs outage_length_ns = 0;
};

/// A bounded queue of packets in transit. About 2 MiB.
class LoopbackDirection {
 public:
  static constexpr std::size_t capacity = 512;
  static constexpr std::size_t packet_bytes = 4096;

  /// `not_ready` when full; `capacity_exceeded` for a packet beyond packet_bytes.
  Status put(std::span<const std::uint8_t> packet, TimeNs due);
  /// The packet that is due first, in order of sending for equal times.
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

  [[nodiscard]] std::uint64_t lost() const { return lost_; }

 private:
  [[nodiscard]] bool outage(TimeNs now) const;
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
  /// Faults for all packets sent from now on.
  LoopbackFaults& faults() { return faults_; }
  [[nodiscard]] std::uint64_t lost() const { return board_.lost() + ground_.lost(); }

 private:
  LoopbackFaults faults_;
  LoopbackDirection up_, down_;
  LoopbackEnd board_, ground_;
};

}  // namespace ilp
