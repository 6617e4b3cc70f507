#include "sim/ground/cfdp/received_segments.hpp"

#include <algorithm>
#include <iterator>

namespace ilp::ground_cfdp {
namespace {

/// What a piece takes besides its octets: a node in each of the two maps, two blocks of the heap.
constexpr std::uint64_t piece_overhead_bytes = 192;

}  // namespace

std::uint64_t ReceivedSegments::add(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return 0;
  std::uint64_t begin = offset, end = offset + bytes.size(), at = offset, added = 0;
  auto run = runs_.upper_bound(offset);
  if (run != runs_.begin() && std::prev(run)->second >= offset) --run;
  // All runs that the segment touches become one with it.
  while (at < end || (run != runs_.end() && run->first <= end)) {
    const std::uint64_t next = run != runs_.end() ? std::min(run->first, end) : end;
    if (at < next) {
      const auto part = bytes.subspan(at - offset, next - at);
      pieces_.emplace(at, Bytes(part.begin(), part.end()));
      added += part.size();
      at = next;
    }
    if (run == runs_.end() || run->first > end) break;
    begin = std::min(begin, run->first);
    at = std::max(at, run->second);
    run = runs_.erase(run);
  }
  runs_[begin] = std::max(at, end);
  held_bytes_ += added;
  return added;
}

bool ReceivedSegments::whole(std::uint64_t end) const {
  return end == 0 || (!runs_.empty() && runs_.begin()->first == 0 && runs_.begin()->second >= end);
}

std::vector<cfdp::Gap> ReceivedSegments::gaps(std::uint64_t begin, std::uint64_t end, std::size_t most) const {
  std::vector<cfdp::Gap> list;
  auto run = runs_.upper_bound(begin);
  if (run != runs_.begin() && std::prev(run)->second > begin) begin = std::prev(run)->second;
  while (begin < end && list.size() < most) {
    const std::uint64_t stop = run == runs_.end() ? end : std::min(end, run->first);
    if (begin < stop) list.push_back({begin, stop});
    if (run == runs_.end()) break;
    begin = run->second;
    ++run;
  }
  return list;
}

ReceivedSegments::Bytes ReceivedSegments::file(std::uint64_t end) const {
  Bytes file;
  file.reserve(end);
  for (const auto& [begin, bytes] : pieces_) {
    if (begin >= end) break;
    file.insert(file.end(), bytes.begin(), bytes.end());
  }
  file.resize(end);
  return file;
}

std::uint64_t ReceivedSegments::memory_bytes() const {
  return held_bytes_ + piece_overhead_bytes * pieces_.size();
}

}  // namespace ilp::ground_cfdp
