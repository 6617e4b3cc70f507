// The only user of the packet links: sorts received packets by application, and sends packets during contact.
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
  files,     ///< CFDP PDUs, in space packets of cfdp_apid or as datagrams of a separate link
  count
};

/// APID of space packets that hold one PDU each: no secondary header, no packet CRC.
inline constexpr std::uint16_t cfdp_apid = 0x7FD;

/// Counts of received and discarded packets, for housekeeping.
struct RouterCounts {
  std::uint32_t received = 0, sent = 0;
  std::uint32_t malformed = 0;     ///< neither space packet nor PDU, or cut short
  std::uint32_t unknown_apid = 0;  ///< for another application
  std::uint32_t refused = 0;       ///< not authenticated
  std::uint32_t dropped = 0;       ///< the ring was full, or there was no contact
};

class PacketRouter {
 public:
  /// `files` is the link for PDUs without space packets. If it is the null pointer, PDUs travel in space packets on
  /// `packets`. `packets` may be the null pointer if the flight has no link for space packets.
  PacketRouter(PacketLink* packets, PacketLink* files, Clock& clock, const MissionParameters& mission);

  /// Receives a bounded number of datagrams and sorts their packets. The Telecommander calls it in every minor frame.
  /// Out of contact everything received is discarded, because the ground cannot have sent it. A telecommand with an
  /// unknown APID, and without authentication one that is cut short, is still passed to `commands`, where it is
  /// answered with a failure report. Returns the first fault of a link.
  Status pump();
  /// Takes the oldest waiting packet: a space packet for `commands`, a PDU without space packet for `files`. `bytes`
  /// gets its length. Returns `not_ready` when no packet waits, when no authenticated telecommand is released, or when
  /// the mission's rate of telecommands does not allow another one yet. Returns `capacity_exceeded` when `out` is too
  /// small: `out` then gets the packet's beginning, and the packet is lost.
  Status receive(Channel channel, std::span<std::uint8_t> out, std::size_t& bytes);
  /// Sends one complete space packet for `commands`, one PDU for `files`. Returns `not_ready` out of contact, without a
  /// link or receiver, or when the link's rate does not allow it yet; the caller then tries again later. Telemetry has
  /// priority over files when the rate does not suffice for both.
  Status send(Channel channel, std::span<const std::uint8_t> packet);

  /// Sets the keys by which packets are authenticated. The mission's parameter authentication says which packets must
  /// be. Without keys, authentication is off.
  void authenticate_with(Authenticator& authenticator) { authenticator_ = &authenticator; }
  [[nodiscard]] Authenticator* authenticator() { return authenticator_; }
  [[nodiscard]] bool authentication_wanted() const { return mission_.authentication != Authentication::none; }
  /// Authentication is wanted, and there are keys.
  [[nodiscard]] bool authenticating() const;
  /// Lets receive() return the telecommands that wait now. Only authenticated telecommands need a release.
  /// TelecommandGuard calls it.
  void release() { released_ = waiting_; }
  /// Number of telecommands that receive() has not returned yet.
  [[nodiscard]] std::size_t waiting() const { return waiting_; }
  /// Number of waiting telecommands that are released.
  [[nodiscard]] std::size_t released() const { return released_; }
  /// Why the latest packet that failed authentication was refused.
  [[nodiscard]] Status last_refusal() const { return last_refusal_; }

  /// There is contact with the ground now (contact_at).
  [[nodiscard]] bool contact() const;
  /// The flight has a link.
  [[nodiscard]] bool present() const { return packets_ != nullptr || files_ != nullptr; }
  [[nodiscard]] const RouterCounts& counts() const { return counts_; }

 private:
  /// Token bucket: `level` grows with time at a rate, up to a maximum.
  struct Bucket {
    double level = 0;
    TimeNs filled_ns = 0;
    bool begun = false;
    /// Adds what has grown since the last call. The first call fills the bucket to `most`.
    void fill(TimeNs now, double per_s, double most);
  };

  /// Receives datagrams of one link. `whole_pdus`: each datagram is one PDU.
  Status drain(PacketLink& link, bool whole_pdus);
  /// Splits a datagram into space packets and takes each.
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
  std::size_t released_ = 0;  ///< telecommands among the waiting ones that receive() may return
  RouterCounts counts_;
  Bucket link_credit_;     ///< bytes; telemetry may overdraw it, and files wait until it is positive
  Bucket command_credit_;  ///< telecommands
  std::uint16_t file_packets_ = 0;
  std::size_t work_ = 0;  ///< cost of the packets that this pump has taken from one link so far, in octets
  std::array<std::uint8_t, limits::max_packet_bytes> buffer_{};
  PacketRing<limits::command_ring_bytes> commands_;
  PacketRing<limits::pdu_ring_bytes> pdus_;
};

}  // namespace ilp
