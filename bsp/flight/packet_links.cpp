#include "bsp/flight/packet_links.hpp"

#include <cerrno>

#include "fsw/base/argument.hpp"

namespace ilp {
namespace {

Status open_udp(const char* local, const char* peer, UdpLink& link, const char*& culprit) {
  SocketAddress here, there;
  culprit = local;
  ILP_TRY(parse_address(local, here));
  culprit = peer;
  if (peer != nullptr) ILP_TRY(parse_address(peer, there));
  culprit = local;
  return link.open(here, peer != nullptr ? &there : nullptr);
}

}  // namespace

const char* PacketLinkOptions::reached_by_others() const {
  for (const char* const text : {udp, tcp, cfdp}) {
    SocketAddress address;
    // What is no address is refused when it is opened.
    if (text != nullptr && parse_address(text, address).ok() && address.host >> 24U != 127) return text;
  }
  return nullptr;
}

const char* link_advice(const Status& status) {
  if (status.is(StatusCode::parse_error))
    return "an address is written in numbers: 127.0.0.1:10025, with a port up to 65535";
  if (status.is(StatusCode::invalid_argument)) return "a peer needs its own link beside it: --link-udp or --cfdp-udp";
  if (status.a == EADDRINUSE) return "another program uses this address: end that program, or name another port";
  if (status.a == EADDRNOTAVAIL)
    return "this machine has no such address: name one of its own, or 0.0.0.0 for all of them";
  if (status.a == EACCES) return "this port needs permissions: name one from 1024 on";
  return "the system refuses this address: name another one";
}

Status PacketLinks::open(const PacketLinkOptions& options, const char*& culprit) {
  options_ = options;
  packets_ = files_ = nullptr;
  culprit = options.udp_peer;
  if (options.udp_peer != nullptr && options.udp == nullptr) return out_of_range(Argument::peer);
  culprit = options.cfdp_peer;
  if (options.cfdp_peer != nullptr && options.cfdp == nullptr) return out_of_range(Argument::peer);
  if (options.udp != nullptr) {
    ILP_TRY(open_udp(options.udp, options.udp_peer, udp_, culprit));
    packets_ = &udp_;
  }
  if (options.tcp != nullptr) {
    SocketAddress here;
    culprit = options.tcp;
    ILP_TRY(parse_address(options.tcp, here));
    ILP_TRY(tcp_.open(here));
    packets_ = options.udp != nullptr ? static_cast<PacketLink*>(&joined_) : &tcp_;
  }
  if (options.cfdp != nullptr) {
    ILP_TRY(open_udp(options.cfdp, options.cfdp_peer, cfdp_, culprit));
    files_ = &cfdp_;
  }
  return {};
}

Status PacketLinks::addresses(Addresses& addresses) const {
  addresses = {};
  if (options_.udp != nullptr) ILP_TRY(udp_.address(addresses.udp));
  if (options_.tcp != nullptr) ILP_TRY(tcp_.address(addresses.tcp));
  return options_.cfdp != nullptr ? cfdp_.address(addresses.cfdp) : Status{};
}

}  // namespace ilp
