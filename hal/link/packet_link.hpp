// Interface of a link that carries packets to and from the ground. The link neither repeats lost packets nor guarantees
// their order.
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

  /// Reads the next datagram, which may hold several complete packets, or the next complete packet of a stream. `bytes`
  /// is its length. Never blocks. Returns `not_ready` if none has arrived, and `capacity_exceeded` for one that does
  /// not fit into `buffer`; it is lost.
  virtual Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) = 0;
  /// Sends one complete packet. Never blocks. Returns `not_ready` if there is no receiver or the link's queue is full;
  /// nothing was sent then.
  virtual Status send(std::span<const std::uint8_t> packet) = 0;
  /// The caller reports that the last received packet was valid. Its sender counts as a ground station from then on; a
  /// link without connections sends to such stations.
  virtual void accept_sender() {}

 protected:
  ~PacketLink() = default;
};

}  // namespace ilp
