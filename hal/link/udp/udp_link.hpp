// Datagrams to and from ground stations. Each holds one or more whole space packets, or one bare PDU.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "hal/clock/clock.hpp"
#include "hal/link/packet_link.hpp"
#include "hal/posix/socket.hpp"

namespace ilp {

/// Datagrams are sent to the fixed peer if there is one. Otherwise they go to every station whose datagrams the router
/// has accepted within the last hour: up to limits::max_stations, beyond which the one that has been silent longest is
/// dropped.
class UdpLink final : public PacketLink {
 public:
  static constexpr TimeNs station_lifetime_ns = 3600 * ns_per_s;

  explicit UdpLink(Clock& clock) : clock_(clock) {}
  ~UdpLink();

  /// `peer` may be the null pointer. `io_error` when the address is not ours or already taken.
  Status open(const SocketAddress& local, const SocketAddress* peer);
  Status address(SocketAddress& local) const { return local_address(socket_, local); }

  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override;
  /// Sends one datagram to each station; ok when the system has taken it for one of them. `capacity_exceeded` for a
  /// packet that is too long for a datagram.
  Status send(std::span<const std::uint8_t> packet) override;
  void accept_sender() override;

 private:
  struct Station {
    SocketAddress address;
    TimeNs received_ns = 0;
    bool used = false;
  };
  [[nodiscard]] bool listening(const Station& station, TimeNs now) const;

  Clock& clock_;
  int socket_ = -1;
  bool fixed_ = false;
  SocketAddress sender_;
  std::array<Station, limits::max_stations> stations_{};
};

}  // namespace ilp
