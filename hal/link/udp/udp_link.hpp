// A packet link over UDP to ground stations. A datagram holds one or more complete space packets, or one bare PDU.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "hal/clock/clock.hpp"
#include "hal/link/packet_link.hpp"
#include "hal/posix/socket.hpp"

namespace ilp {

/// Datagrams are sent to the fixed peer if there is one. Otherwise they go to every station from which the router has
/// accepted a datagram (accept_sender) within the last hour. A station beyond limits::max_stations replaces the one
/// that has been silent longest.
class UdpLink final : public PacketLink {
 public:
  static constexpr TimeNs station_lifetime_ns = 3600 * ns_per_s;

  explicit UdpLink(Clock& clock) : clock_(clock) {}
  ~UdpLink();

  /// Binds the link to an address of this board. `peer` is the fixed peer, or the null pointer. Returns `io_error`
  /// (first value: errno) if the address is not one of this board's or is in use.
  Status open(const SocketAddress& local, const SocketAddress* peer);
  /// Reads the address to which the link is bound.
  Status address(SocketAddress& local) const { return local_address(socket_, local); }

  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override;
  /// Sends one datagram to each station. Returns ok if the system has accepted it for at least one, `capacity_exceeded`
  /// if the packet is too long for a datagram.
  Status send(std::span<const std::uint8_t> packet) override;
  void accept_sender() override;

 private:
  struct Station {
    SocketAddress address;
    TimeNs received_ns = 0;
    bool used = false;
  };
  /// Whether datagrams are sent to the station.
  [[nodiscard]] bool listening(const Station& station, TimeNs now) const;

  Clock& clock_;
  int socket_ = -1;
  bool fixed_ = false;    ///< the first station is the fixed peer
  SocketAddress sender_;  ///< sender of the datagram that was received last
  std::array<Station, limits::max_stations> stations_{};
};

}  // namespace ilp
