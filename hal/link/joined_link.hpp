// Two links as one: receives from both, sends to both.
#pragma once

#include "hal/link/packet_link.hpp"

namespace ilp {

class JoinedLink final : public PacketLink {
 public:
  JoinedLink(PacketLink& first, PacketLink& second) : links_{&first, &second} {}

  /// The two take turns, so that a flood on one of them leaves half of the places to the other.
  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override {
    heard_ = 1 - heard_;
    Status status = links_[heard_]->receive(buffer, bytes);
    if (!status.is(StatusCode::not_ready)) return status;
    heard_ = 1 - heard_;
    return links_[heard_]->receive(buffer, bytes);
  }
  /// Returns ok when one of them has taken it.
  Status send(std::span<const std::uint8_t> packet) override {
    const Status first = links_[0]->send(packet);
    const Status second = links_[1]->send(packet);
    return first.ok() ? first : second;
  }
  void accept_sender() override { links_[heard_]->accept_sender(); }

 private:
  PacketLink* links_[2];
  int heard_ = 0;
};

}  // namespace ilp
