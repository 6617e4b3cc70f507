#include "fsw/packets/cfdp_gaps.hpp"

namespace ilp::cfdp {
namespace {

bool before(const Piece& a, const Piece& b) {
  return a.begin < b.begin;
}

/// Moves the element at `root` down to its place in the heap of the first `size` elements.
void sift_down(std::span<Piece> pieces, std::size_t root, std::size_t size, std::uint32_t& steps) {
  while (2 * root + 1 < size) {  // bound: the levels of the heap
    std::size_t child = 2 * root + 1;
    ++steps;
    if (child + 1 < size && before(pieces[child], pieces[child + 1])) ++child;
    if (!before(pieces[root], pieces[child])) return;
    const Piece moved = pieces[root];
    pieces[root] = pieces[child];
    pieces[child] = moved;
    root = child;
  }
}

/// Heapsort: n log n steps for any order, without recursion.
void put_in_order(std::span<Piece> pieces, std::uint32_t& steps) {
  bool ascending = true;
  for (std::size_t i = 1; i < pieces.size(); ++i) ascending = ascending && !before(pieces[i], pieces[i - 1]);
  steps += static_cast<std::uint32_t>(pieces.size());
  if (ascending) return;
  for (std::size_t i = pieces.size() / 2; i-- > 0;) sift_down(pieces, i, pieces.size(), steps);
  for (std::size_t size = pieces.size(); size-- > 1;) {
    const Piece last = pieces[size];
    pieces[size] = pieces[0];
    pieces[0] = last;
    sift_down(pieces, 0, size, steps);
  }
}

}  // namespace

MergeCounts merge_missing(PieceList& list, std::span<Piece> pieces) {
  MergeCounts counts;
  put_in_order(pieces, counts.steps);
  PieceList merged;
  std::size_t room = PieceList::capacity() - list.size();
  std::size_t held = 0;
  std::uint32_t covered_to = 0;
  // Room for every held piece is reserved, so that these always fit.
  const auto take_held = [&] {
    static_cast<void>(merged.push_back(list[held++]));
    if (merged.back().end > covered_to) covered_to = merged.back().end;
    ++counts.steps;
  };
  for (const Piece& piece : pieces) {
    ++counts.steps;
    Piece part{piece.begin > covered_to ? piece.begin : covered_to, piece.end};
    while (part.begin < piece.end) {  // bound: the pieces of `list` in this one; `begin` grows
      while (held < list.size() && list[held].begin <= part.begin) take_held();
      if (part.begin < covered_to) {
        part.begin = covered_to;
        continue;
      }
      const bool cut = held < list.size() && list[held].begin < piece.end;
      part.end = cut ? list[held].begin : piece.end;
      ++counts.steps;
      if (room > 0) {
        static_cast<void>(merged.push_back(part));
        --room;
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

bool cut_out(PieceList& list, Piece piece) {
  if (piece.begin >= piece.end) return true;
  PieceList left;
  for (const Piece& held : list) {
    if (held.end <= piece.begin || held.begin >= piece.end) {
      if (!left.push_back(held)) return false;
      continue;
    }
    if (held.begin < piece.begin && !left.push_back({held.begin, piece.begin})) return false;
    if (held.end > piece.end && !left.push_back({piece.end, held.end})) return false;
  }
  list = left;
  return true;
}

std::uint32_t octets_in(const PieceList& list) {
  std::uint32_t octets = 0;
  for (const Piece& piece : list) octets += piece.end - piece.begin;
  return octets;
}

}  // namespace ilp::cfdp
