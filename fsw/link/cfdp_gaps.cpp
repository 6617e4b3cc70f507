#include "fsw/link/cfdp_gaps.hpp"

namespace ilp::cfdp {
namespace {

/// The first part of `piece` that the list does not hold; an empty one (begin == end) when it holds all.
Piece first_missing(const PieceList& list, Piece piece) {
  // Each turn moves `begin` behind one piece of the list: no more turns than pieces.
  for (std::size_t turn = 0; turn <= list.size(); ++turn) {
    bool moved = false;
    for (const Piece& held : list) {
      if (held.begin <= piece.begin && piece.begin < held.end) {
        piece.begin = held.end;
        moved = true;
      }
    }
    if (!moved) break;
  }
  if (piece.begin >= piece.end) return {piece.end, piece.end};
  for (const Piece& held : list) {
    if (held.begin > piece.begin && held.begin < piece.end) piece.end = held.begin;
  }
  return piece;
}

}  // namespace

bool add_missing(PieceList& list, Piece piece) {
  while (piece.begin < piece.end) {
    const Piece part = first_missing(list, piece);
    if (part.begin >= part.end) return true;
    if (!list.push_back(part)) return false;
    piece.begin = part.end;
  }
  return true;
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
