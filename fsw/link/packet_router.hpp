// The one place that touches the packet link: sorts what comes in by its application, lets out what the pass allows.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "cfg/mission.hpp"
#include "fsw/base/status.hpp"
#include "hal/clock/clock.hpp"
#include "hal/link/packet_link.hpp"

namespace ilp {

/// Who a packet is for.
enum class Channel : std::uint8_t {
  commands,  ///< telecommands and telemetry of this package: space packets of its APID
  files,     ///< CFDP PDUs, out of space packets of their APID or as datagrams of a link of their own
  count
};

/// What came in and what was thrown away, for housekeeping.
struct RouterCounts {
  std::uint32_t received = 0, sent = 0;
  std::uint32_t malformed = 0;     ///< no space packet, or cut short
  std::uint32_t unknown_apid = 0;  ///< for nobody here
  std::uint32_t refused = 0;       ///< not authenticated, or beyond the rate limit
  std::uint32_t dropped = 0;       ///< came faster than they were read
};

class PacketRouter {
 public:
  /// `files` is the link for raw PDUs; may be the null pointer: then they travel in space packets on `packets`, which
  /// may be the null pointer where a flight has no packet link at all.
  PacketRouter(PacketLink* packets, PacketLink* files, Clock& clock, const MissionParameters& mission);

  /// Takes in a bounded number of packets. Out of contact what comes is thrown away: nobody can have sent it.
  Status pump();
  /// The oldest that waits: for `commands` a whole space packet, for `files` a bare PDU. `not_ready` when there is
  /// none, `capacity_exceeded` for a buffer that is too small (the packet is gone).
  Status receive(Channel channel, std::span<std::uint8_t> out, std::size_t& bytes);
  /// For `commands` a whole space packet, for `files` a bare PDU. `not_ready`: out of contact, nobody listens, or the
  /// link's rate does not allow it yet; try again later. Telemetry goes before files when the rate is short.
  Status send(Channel channel, std::span<const std::uint8_t> packet);

  [[nodiscard]] bool contact() const;
  [[nodiscard]] bool present() const { return packets_ != nullptr; }
  [[nodiscard]] const RouterCounts& counts() const { return counts_; }

 private:
  PacketLink* packets_;
  PacketLink* files_;
  Clock& clock_;
  const MissionParameters& mission_;
  RouterCounts counts_;
};

}  // namespace ilp
