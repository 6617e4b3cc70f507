// The only user of the packet link: sorts received packets by application and sends what the pass allows.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "cfg/mission.hpp"
#include "fsw/base/status.hpp"
#include "fsw/packets/authentication.hpp"
#include "fsw/packets/packet_ring.hpp"
#include "hal/clock/clock.hpp"
#include "hal/link/packet_link.hpp"

namespace ilp {

/// The addressee of a packet.
enum class Channel : std::uint8_t {
  commands,  ///< telecommands and telemetry of this package: space packets of its APID
  files,     ///< CFDP PDUs, out of space packets of their APID or as datagrams of a link of their own
  count
};

/// APID of space packets that hold one PDU each: no secondary header, no packet CRC.
inline constexpr std::uint16_t cfdp_apid = 0x7FD;

/// Counts of received and discarded packets, for housekeeping.
struct RouterCounts {
  std::uint32_t received = 0, sent = 0;
  std::uint32_t malformed = 0;     ///< no space packet, or cut short
  std::uint32_t unknown_apid = 0;  ///< for another application
  std::uint32_t refused = 0;       ///< not authenticated
  std::uint32_t dropped = 0;       ///< arrived faster than they were read, or out of contact
};

class PacketRouter {
 public:
  /// `files` is the link for raw PDUs; with the null pointer they travel in space packets on `packets`. `packets` may
  /// be the null pointer if a flight has no packet link at all.
  PacketRouter(PacketLink* packets, PacketLink* files, Clock& clock, const MissionParameters& mission);

  /// Receives a bounded number of datagrams, and of packets in them. The Telecommander calls it in every minor frame.
  /// Out of contact everything received is discarded, because the ground cannot have sent it. A telecommand that cannot
  /// be accepted, because it is cut short, of an unknown APID or otherwise, is still passed to `commands` when its
  /// primary header identifies its source.
  Status pump();
  /// The oldest waiting packet: a space packet for `commands`, a bare PDU for `files`. `not_ready` when there is none,
  /// or when the mission's rate of telecommands does not allow another one yet. `capacity_exceeded` for a buffer that
  /// is too small: it gets the packet's beginning, `bytes` gets the packet's length, and the packet is lost.
  Status receive(Channel channel, std::span<std::uint8_t> out, std::size_t& bytes);
  /// Sends a whole space packet for `commands`, a bare PDU for `files`. `not_ready`: out of contact, no receiver, or
  /// the link's rate does not allow it yet; try again later. Telemetry goes before files when the rate is short.
  Status send(Channel channel, std::span<const std::uint8_t> packet);

  /// Packets must be authenticated as the mission's parameter authentication says. Without keys, authentication is off.
  void authenticate_with(Authenticator& authenticator) { authenticator_ = &authenticator; }
  [[nodiscard]] Authenticator* authenticator() { return authenticator_; }
  [[nodiscard]] bool authentication_wanted() const { return mission_.authentication != Authentication::none; }
  [[nodiscard]] bool authenticating() const;
  /// Releases the waiting authenticated telecommands. TelecommandGuard calls it.
  void release() { released_ = waiting_; }
  /// Telecommands that arrived and were not received yet.
  [[nodiscard]] std::size_t waiting() const { return waiting_; }
  /// The released ones among them, if they are authenticated.
  [[nodiscard]] std::size_t released() const { return released_; }
  /// Why the latest packet that failed authentication was refused.
  [[nodiscard]] Status last_refusal() const { return last_refusal_; }

  [[nodiscard]] bool contact() const;
  [[nodiscard]] bool present() const { return packets_ != nullptr || files_ != nullptr; }
  [[nodiscard]] const RouterCounts& counts() const { return counts_; }

 private:
  /// A credit that grows with time up to a quarter of a second's worth.
  struct Bucket {
    double level = 0;
    TimeNs filled_ns = 0;
    bool begun = false;
    void fill(TimeNs now, double per_s, double most);
  };

  Status drain(PacketLink& link, bool whole_pdus);
  void sort(PacketLink& link, std::span<std::uint8_t> datagram);
  [[nodiscard]] bool take_packet(std::span<std::uint8_t> packet, bool whole);
  [[nodiscard]] bool pdus_protected() const;
  /// Removes security header and trailer from `packet`.
  [[nodiscard]] bool authentic(std::span<std::uint8_t>& packet);
  [[nodiscard]] bool take_pdu(std::span<const std::uint8_t> pdu);
  Status put_out(Channel channel, std::span<const std::uint8_t> packet);

  PacketLink* packets_;
  PacketLink* files_;
  Clock& clock_;
  const MissionParameters& mission_;
  Authenticator* authenticator_ = nullptr;
  Status last_refusal_;
  std::size_t waiting_ = 0;   ///< telecommands
  std::size_t released_ = 0;  ///< the released ones among them, if they are authenticated
  RouterCounts counts_;
  Bucket link_credit_;     ///< bytes; telemetry may overdraw it, and files wait until it is positive
  Bucket command_credit_;  ///< telecommands
  std::uint16_t file_packets_ = 0;
  std::size_t work_ = 0;  ///< of the present pump on one link, in octets
  std::array<std::uint8_t, limits::max_packet_bytes> buffer_{};
  PacketRing<limits::command_ring_bytes> commands_;
  PacketRing<limits::pdu_ring_bytes> pdus_;
};

}  // namespace ilp
