// A bounded list of pieces of a file that are still missing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"

namespace ilp::cfdp {

/// [begin, end) of a file, in octets.
struct Segment {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
};

/// Ascending by `begin`, without overlap.
using SegmentList = FixedVector<Segment, limits::max_file_gaps>;

/// Counts of a merge.
struct MergeCounts {
  std::uint32_t dropped = 0;  ///< parts that did not fit into the list
  std::uint32_t steps = 0;    ///< elementary steps: at most 4 * (pieces held + pieces given) if these ascend
};

/// Adds the parts of `pieces` that the list does not hold yet, in one walk over both. `pieces` may come in any order
/// and overlap; sorting them takes n log n further steps if they do not ascend. Existing borders stay: pieces are never
/// joined, because receivers expect a retransmission to keep to the requested borders. The list never loses a piece.
/// When it is full the last parts are left out.
MergeCounts merge_missing(SegmentList& list, std::span<Segment> segments);

/// Cuts [begin, end) out of the list. Returns `false` and changes nothing when the list has no room for the extra piece
/// that this may need.
[[nodiscard]] bool cut_out(SegmentList& list, Segment segment);

[[nodiscard]] std::uint32_t octets_in(const SegmentList& list);

}  // namespace ilp::cfdp
