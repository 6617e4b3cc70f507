#include "fsw/packets/cfdp_gaps.hpp"

namespace ilp::cfdp {
namespace {

bool before(const Segment& a, const Segment& b) {
  return a.begin < b.begin;
}

/// Moves the element at `root` down to its place in the heap of the first `size` elements.
void sift_down(std::span<Segment> segments, std::size_t root, std::size_t size, std::uint32_t& steps) {
  while (2 * root + 1 < size) {  // bound: the levels of the heap
    std::size_t child = 2 * root + 1;
    ++steps;
    if (child + 1 < size && before(segments[child], segments[child + 1])) ++child;
    if (!before(segments[root], segments[child])) return;
    const Segment moved = segments[root];
    segments[root] = segments[child];
    segments[child] = moved;
    root = child;
  }
}

/// Heapsort: n log n steps for any order, without recursion.
void put_in_order(std::span<Segment> segments, std::uint32_t& steps) {
  bool ascending = true;
  for (std::size_t i = 1; i < segments.size(); ++i) ascending = ascending && !before(segments[i], segments[i - 1]);
  steps += static_cast<std::uint32_t>(segments.size());
  if (ascending) return;
  for (std::size_t i = segments.size() / 2; i-- > 0;) sift_down(segments, i, segments.size(), steps);
  for (std::size_t size = segments.size(); size-- > 1;) {
    const Segment last = segments[size];
    segments[size] = segments[0];
    segments[0] = last;
    sift_down(segments, 0, size, steps);
  }
}

}  // namespace

MergeCounts merge_missing(SegmentList& list, std::span<Segment> segments) {
  MergeCounts counts;
  put_in_order(segments, counts.steps);
  SegmentList merged;
  std::size_t free_slots = SegmentList::capacity() - list.size();
  std::size_t held = 0;
  std::uint32_t covered_to = 0;
  // Room for every held piece is reserved, so that these always fit.
  const auto take_held = [&] {
    static_cast<void>(merged.push_back(list[held++]));
    if (merged.back().end > covered_to) covered_to = merged.back().end;
    ++counts.steps;
  };
  for (const Segment& segment : segments) {
    ++counts.steps;
    Segment part{segment.begin > covered_to ? segment.begin : covered_to, segment.end};
    while (part.begin < segment.end) {  // bound: the pieces of `list` in this one; `begin` grows
      while (held < list.size() && list[held].begin <= part.begin) take_held();
      if (part.begin < covered_to) {
        part.begin = covered_to;
        continue;
      }
      const bool cut = held < list.size() && list[held].begin < segment.end;
      part.end = cut ? list[held].begin : segment.end;
      ++counts.steps;
      if (free_slots > 0) {
        static_cast<void>(merged.push_back(part));
        --free_slots;
      } else {
        ++counts.dropped;
      }
      covered_to = part.begin = part.end;
    }
  }
  while (held < list.size()) take_held();
  list = merged;
  return counts;
}

bool cut_out(SegmentList& list, Segment segment) {
  if (segment.begin >= segment.end) return true;
  SegmentList left;
  for (const Segment& held : list) {
    if (held.end <= segment.begin || held.begin >= segment.end) {
      if (!left.push_back(held)) return false;
      continue;
    }
    if (held.begin < segment.begin && !left.push_back({held.begin, segment.begin})) return false;
    if (held.end > segment.end && !left.push_back({segment.end, held.end})) return false;
  }
  list = left;
  return true;
}

std::uint32_t octets_in(const SegmentList& list) {
  std::uint32_t octets = 0;
  for (const Segment& segment : list) octets += segment.end - segment.begin;
  return octets;
}

}  // namespace ilp::cfdp
