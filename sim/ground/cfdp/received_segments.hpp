// What has come of a file, in any order: its octets as they came, each once, and what is missing between them. Memory
// and time follow what came, not where in the file it belongs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "fsw/link/cfdp_pdu.hpp"

namespace ilp::sim {

class ReceivedSegments {
 public:
  using Bytes = std::vector<std::uint8_t>;

  /// Keeps the octets of the file from `offset` on that are not held yet; the first that came stand. `offset` + size
  /// must be at most 2^63. Returns how many were new.
  std::uint64_t add(std::uint64_t offset, std::span<const std::uint8_t> bytes);

  /// [0, end) is held.
  [[nodiscard]] bool whole(std::uint64_t end) const;
  /// What is missing of [begin, end), in order, at most so many gaps.
  [[nodiscard]] std::vector<cfdp::Gap> gaps(std::uint64_t begin, std::uint64_t end, std::size_t most) const;
  /// The octets [0, end) of what is whole up to there.
  [[nodiscard]] Bytes file(std::uint64_t end) const;

  /// What it takes, the bookkeeping of each piece included.
  [[nodiscard]] std::uint64_t memory_bytes() const;

 private:
  std::map<std::uint64_t, Bytes> pieces_;        ///< by their beginning; they do not overlap
  std::map<std::uint64_t, std::uint64_t> runs_;  ///< held without a gap: from, to
  std::uint64_t held_bytes_ = 0;
};

}  // namespace ilp::sim
