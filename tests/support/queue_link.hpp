// A packet link whose two ends are queues of the test.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "hal/link/packet_link.hpp"

namespace ilp::test {

using Octets = std::vector<std::uint8_t>;

/// receive() returns the packets of `up` in order. send() appends packets to `down`, unless the link is deaf.
class QueueLink final : public PacketLink {
 public:
  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override {
    if (up.empty()) return StatusCode::not_ready;
    const Octets packet = up.front();
    up.pop_front();
    bytes = packet.size();
    if (bytes > buffer.size()) return StatusCode::capacity_exceeded;
    std::copy(packet.begin(), packet.end(), buffer.begin());
    return {};
  }
  Status send(std::span<const std::uint8_t> packet) override {
    if (deaf) return StatusCode::not_ready;
    down.emplace_back(packet.begin(), packet.end());
    return {};
  }
  std::deque<Octets> up;
  std::vector<Octets> down;
  bool deaf = false;
};

}  // namespace ilp::test
