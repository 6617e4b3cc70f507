// A bounded list of the segments of a file that are still missing.
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
  std::uint32_t dropped = 0;  ///< parts of given segments that did not fit into the list
  std::uint32_t steps = 0;    ///< elementary steps: at most 4 * (listed + given segments) if the given ones ascend
};

/// Adds to `list` those parts of `segments` that it does not hold yet. `segments` may overlap and are sorted in place;
/// this takes n log n further steps if they do not ascend. The list keeps all its segments and their borders: segments
/// are never joined, because receivers expect a retransmission to keep to the requested borders. When the list is full
/// the last parts are left out.
MergeCounts merge_missing(SegmentList& list, std::span<Segment> segments);

/// Removes the range of `segment` from the list. Returns `false` and changes nothing if that divides a segment in two
/// and the list has no capacity for the second part.
[[nodiscard]] bool cut_out(SegmentList& list, Segment segment);

/// Total length of all segments.
[[nodiscard]] std::uint32_t octets_in(const SegmentList& list);

}  // namespace ilp::cfdp
