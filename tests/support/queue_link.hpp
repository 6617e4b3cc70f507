// A packet link whose other end is two queues that a test reads and fills.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "hal/link/packet_link.hpp"

namespace ilp::test {

using Octets = std::vector<std::uint8_t>;

/// receive() returns the packets of `up` in order; send() appends packets to `down`.
class QueueLink final : public PacketLink {
 public:
  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override {
    if (up.empty()) return StatusCode::not_ready;
    bytes = up.front().size();
    std::copy(up.front().begin(), up.front().end(), buffer.begin());
    up.pop_front();
    return {};
  }
  Status send(std::span<const std::uint8_t> packet) override {
    down.emplace_back(packet.begin(), packet.end());
    return {};
  }
  std::deque<Octets> up;
  std::vector<Octets> down;
};

}  // namespace ilp::test
