// A queue of packets of any length in a fixed number of bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

namespace ilp {

/// Size of the length field in front of each packet.
inline constexpr std::size_t packet_ring_length_bytes = 4;

template <std::size_t Capacity>
class PacketRing {
 public:
  [[nodiscard]] bool empty() const { return used_ == 0; }
  void clear() { used_ = first_ = 0; }

  /// Appends the packet. Returns false and changes nothing when it does not fit.
  [[nodiscard]] bool push(std::span<const std::uint8_t> packet) {
    if (packet.size() > Capacity || Capacity - used_ < packet.size() + packet_ring_length_bytes) return false;
    for (std::size_t i = 0; i < packet_ring_length_bytes; ++i) put(static_cast<std::uint8_t>(packet.size() >> (8 * i)));
    for (const std::uint8_t byte : packet) put(byte);
    return true;
  }

  /// Takes the oldest packet; `bytes` gets its length. Returns `not_ready` when there is none. Returns
  /// `capacity_exceeded` when `out` is too small: `out` then gets the packet's first bytes, and the packet is lost.
  Status pop(std::span<std::uint8_t> out, std::size_t& bytes) {
    bytes = 0;
    if (empty()) return StatusCode::not_ready;
    for (std::size_t i = 0; i < packet_ring_length_bytes; ++i) bytes |= static_cast<std::size_t>(take()) << (8 * i);
    for (std::size_t i = 0; i < bytes; ++i) {
      const std::uint8_t byte = take();
      if (i < out.size()) out[i] = byte;
    }
    if (bytes <= out.size()) return {};
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(bytes), static_cast<std::int64_t>(out.size())};
  }

 private:
  void put(std::uint8_t byte) { bytes_[(first_ + used_++) % Capacity] = byte; }
  std::uint8_t take() {
    const std::uint8_t byte = bytes_[first_];
    first_ = (first_ + 1) % Capacity;
    --used_;
    return byte;
  }

  std::array<std::uint8_t, Capacity> bytes_{};
  std::size_t first_ = 0, used_ = 0;
};

}  // namespace ilp
