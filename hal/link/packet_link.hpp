// Packets to and from the ground. The link neither repeats packets nor guarantees their order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

namespace ilp {

class PacketLink {
 public:
  PacketLink() = default;
  PacketLink(const PacketLink&) = delete;
  PacketLink& operator=(const PacketLink&) = delete;

  /// The next datagram, which may hold several whole packets, or the next whole packet of a stream. `not_ready` when
  /// none waits; `capacity_exceeded` for one that is larger than the buffer and is lost. Never blocks.
  virtual Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) = 0;
  /// Sends one whole packet. `not_ready` when there is no receiver or the link takes no more at present: nothing was
  /// sent. Never blocks.
  virtual Status send(std::span<const std::uint8_t> packet) = 0;
  /// The last received packet was valid: its sender is a ground station, to which a link without connections sends.
  virtual void accept_sender() {}

 protected:
  ~PacketLink() = default;
};

}  // namespace ilp
