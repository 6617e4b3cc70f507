// The received octets of a file, in any order, and the gaps between them. Memory and time depend on the received data,
// not on its place in the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "fsw/packets/cfdp_pdu.hpp"

namespace ilp::ground_cfdp {

class ReceivedSegments {
 public:
  using Bytes = std::vector<std::uint8_t>;

  /// Keeps the octets from `offset` on that are not held yet; octets held before are not replaced. `offset` + size must
  /// be at most 2^63. Returns the number of new octets.
  std::uint64_t add(std::uint64_t offset, std::span<const std::uint8_t> bytes);

  /// True when [0, end) is held.
  [[nodiscard]] bool whole(std::uint64_t end) const;
  /// The gaps of [begin, end), in order, at most `most` of them.
  [[nodiscard]] std::vector<cfdp::Gap> gaps(std::uint64_t begin, std::uint64_t end, std::size_t most) const;
  /// The octets [0, end), which must be whole.
  [[nodiscard]] Bytes file(std::uint64_t end) const;

  /// Memory in bytes, the bookkeeping of each piece included.
  [[nodiscard]] std::uint64_t memory_bytes() const;

 private:
  std::map<std::uint64_t, Bytes> pieces_;        ///< by their beginning; they do not overlap
  std::map<std::uint64_t, std::uint64_t> runs_;  ///< held without a gap: from, to
  std::uint64_t held_bytes_ = 0;
};

}  // namespace ilp::ground_cfdp
