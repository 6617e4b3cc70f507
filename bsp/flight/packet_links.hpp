// The packet links of a program's command line: UDP, TCP or both for packets, UDP for bare PDUs.
#pragma once

#include "hal/link/joined_link.hpp"
#include "hal/link/tcp/tcp_link.hpp"
#include "hal/link/udp/udp_link.hpp"

namespace ilp {

/// Each is `ADDRESS:PORT`, or the null pointer for none. Without a peer a UDP link answers every accepted sender.
struct PacketLinkOptions {
  const char* udp = nullptr;
  const char* udp_peer = nullptr;
  const char* tcp = nullptr;
  const char* cfdp = nullptr;
  const char* cfdp_peer = nullptr;

  [[nodiscard]] bool any() const { return udp != nullptr || tcp != nullptr || cfdp != nullptr; }
  /// The first address at which other computers can reach a link: any but 127.x.x.x. The null pointer if there is none.
  [[nodiscard]] const char* reached_by_others() const;
};

/// What to do about an option that `PacketLinks::open` has refused, in words; of the statuses of `open` only.
[[nodiscard]] const char* link_advice(const Status& status);

class PacketLinks {
 public:
  explicit PacketLinks(Clock& clock) : udp_(clock), tcp_(clock), cfdp_(clock) {}

  /// `culprit` is the option at fault: `parse_error` for a malformed address, `invalid_argument` for a peer without its
  /// link, `io_error` for an address that is taken or not ours.
  Status open(const PacketLinkOptions& options, const char*& culprit);

  /// Returns the null pointer if there is none.
  [[nodiscard]] PacketLink* packets() { return packets_; }
  [[nodiscard]] PacketLink* files() { return files_; }

  /// Addresses in use, with the ports that the system has chosen for 0; zero if there is none.
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
