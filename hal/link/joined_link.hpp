// A packet link made of two links: it receives from both and sends to both.
#pragma once

#include "hal/link/packet_link.hpp"

namespace ilp {

class JoinedLink final : public PacketLink {
 public:
  JoinedLink(PacketLink& first, PacketLink& second) : links_{&first, &second} {}

  /// Each call begins with the link that was not served last, so that a flood on one link leaves half of the calls to
  /// the other.
  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override {
    received_ = 1 - received_;
    Status status = links_[received_]->receive(buffer, bytes);
    if (!status.is(StatusCode::not_ready)) return status;
    received_ = 1 - received_;
    return links_[received_]->receive(buffer, bytes);
  }
  /// Returns ok if at least one link has sent the packet.
  Status send(std::span<const std::uint8_t> packet) override {
    const Status first = links_[0]->send(packet);
    const Status second = links_[1]->send(packet);
    return first.ok() ? first : second;
  }
  void accept_sender() override { links_[received_]->accept_sender(); }

 private:
  PacketLink* links_[2];
  int received_ = 0;
};

}  // namespace ilp
