// A bounded list of pieces of a file that still have to travel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"

namespace ilp::cfdp {

/// [begin, end) of a file, in octets.
struct Piece {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
};

/// Ascending by `begin`, without overlap.
using PieceList = FixedVector<Piece, limits::max_file_gaps>;

/// What a merge came to.
struct MergeCounts {
  std::uint32_t dropped = 0;  ///< parts that the list had no room for
  std::uint32_t steps = 0;    ///< elementary steps: at most 4 * (pieces held + pieces given) where these ascend
};

/// Adds what of `pieces` the list does not hold yet, in one walk over both. `pieces` may come in any order and overlap;
/// they are put in order, which takes n log n further steps where they do not ascend. Borders that were there stay:
/// pieces are never joined, because receivers expect a retransmission to keep to the borders that they asked for. What
/// the list holds stays in it; where it gets full the last parts are left out.
MergeCounts merge_missing(PieceList& list, std::span<Piece> pieces);

/// Cuts [begin, end) out of the list; `false`, and nothing is changed, when that needs one piece more than the list can
/// hold.
[[nodiscard]] bool cut_out(PieceList& list, Piece piece);

[[nodiscard]] std::uint32_t octets_in(const PieceList& list);

}  // namespace ilp::cfdp
