// Datagrams to and from ground stations: space packets, one or more whole ones in each, or one bare PDU in each.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "hal/clock/clock.hpp"
#include "hal/link/packet_link.hpp"
#include "hal/posix/socket.hpp"

namespace ilp {

/// What is sent goes to the fixed peer where there is one. Otherwise to every station whose datagrams the router has
/// accepted within the last hour: up to limits::max_stations, then the one that has been silent longest is forgotten.
class UdpLink final : public PacketLink {
 public:
  static constexpr TimeNs station_lifetime_ns = 3600 * ns_per_s;

  explicit UdpLink(Clock& clock) : clock_(clock) {}
  ~UdpLink();

  /// `peer` may be the null pointer. `io_error` when the address is not ours or taken.
  Status open(const SocketAddress& local, const SocketAddress* peer);
  Status address(SocketAddress& local) const { return local_address(socket_, local); }

  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override;
  /// One datagram to each station; ok when the system has taken it for one of them. `capacity_exceeded` beyond what a
  /// datagram holds.
  Status send(std::span<const std::uint8_t> packet) override;
  void accept_sender() override;

 private:
  struct Station {
    SocketAddress address;
    TimeNs heard_ns = 0;
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
