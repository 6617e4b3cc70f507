// Opens the packet links that a command line names: UDP, TCP or both for packets, UDP for bare PDUs of CFDP.
#pragma once

#include "hal/link/joined_link.hpp"
#include "hal/link/tcp/tcp_link.hpp"
#include "hal/link/udp/udp_link.hpp"

namespace ilp {

/// Addresses of the links, each `ADDRESS:PORT`, or the null pointer for none. A UDP link without a peer sends to every
/// accepted sender.
struct PacketLinkOptions {
  const char* udp = nullptr;
  const char* udp_peer = nullptr;
  const char* tcp = nullptr;
  const char* cfdp = nullptr;
  const char* cfdp_peer = nullptr;

  [[nodiscard]] bool any() const { return udp != nullptr || tcp != nullptr || cfdp != nullptr; }
  /// The first address at which other computers can reach a link, which is any but 127.x.x.x. The null pointer: none.
  [[nodiscard]] const char* reached_by_others() const;
};

/// Says what to do about an option that PacketLinks::open() has refused. `status` is that of open().
[[nodiscard]] const char* link_advice(const Status& status);

class PacketLinks {
 public:
  explicit PacketLinks(Clock& clock) : udp_(clock), tcp_(clock), cfdp_(clock) {}

  /// Opens the links. Returns `parse_error` for a malformed address, `invalid_argument` for a peer without its link,
  /// and `io_error` (first value: errno) if an address is in use or is not one of this board's. `culprit` becomes the
  /// text of the option at fault.
  Status open(const PacketLinkOptions& options, const char*& culprit);

  /// The links for packets and for bare PDUs; the null pointer: none.
  [[nodiscard]] PacketLink* packets() { return packets_; }
  [[nodiscard]] PacketLink* files() { return files_; }

  /// Addresses of the open links, with the ports that the system has chosen for port 0. All zero: there is no such
  /// link.
  struct Addresses {
    SocketAddress udp, tcp, cfdp;
  };
  Status addresses(Addresses& addresses) const;

 private:
  UdpLink udp_;
  TcpLink tcp_;
  UdpLink cfdp_;
  JoinedLink joined_{udp_, tcp_};
  PacketLinkOptions options_;
  PacketLink* packets_ = nullptr;
  PacketLink* files_ = nullptr;
};

}  // namespace ilp
