// A bounded list of pieces of a file that still have to travel.
#pragma once

#include <cstddef>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"

namespace ilp::cfdp {

/// [begin, end) of a file, in octets.
struct Piece {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
};

using PieceList = FixedVector<Piece, limits::max_file_gaps>;

/// Appends what of `piece` the list does not hold yet. Borders that were there stay: pieces are never joined, because
/// receivers expect a retransmission to keep to the borders that they asked for. `false` when the list is full and a
/// part was left out.
[[nodiscard]] bool add_missing(PieceList& list, Piece piece);

/// Cuts [begin, end) out of an ascending list of pieces; `false`, and nothing is changed, when that needs one piece
/// more than the list can hold.
[[nodiscard]] bool cut_out(PieceList& list, Piece piece);

[[nodiscard]] std::uint32_t octets_in(const PieceList& list);

}  // namespace ilp::cfdp
