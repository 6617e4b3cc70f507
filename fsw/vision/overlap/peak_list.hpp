// The best distinct peaks of an exhaustive search over similarities.
#pragma once

#include <cstddef>

#include "fsw/base/fixed_vector.hpp"
#include "fsw/vision/overlap/centred_similarity.hpp"

namespace ilp {

/// Capacity of a list of peaks. On such small images the right peak is among the best, but often not the best.
inline constexpr std::size_t coarse_max_candidates = 48;

struct CoarseCandidate {
  CentredSimilarity b_from_a;  ///< px of the coarse images
  double rotation_rad = 0;
  double scale = 1;
  double score = 0;  ///< NCC, or the correlation that the mean absolute difference would have for Gaussian grey values
};
using CoarseCandidates = FixedVector<CoarseCandidate, coarse_max_candidates>;

/// Inserts the candidate into a list that has one entry for each peak, best first. `same_peak(entry)` says whether an
/// entry belongs to the candidate's peak; the better of the two stays. A full list drops its last entry.
template <typename SamePeak>
void insert_peak(const CoarseCandidate& candidate, const SamePeak& same_peak, CoarseCandidates& list) {
  std::size_t last = list.size();
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (!same_peak(list[i])) continue;
    if (list[i].score >= candidate.score) return;
    last = i;
    break;
  }
  if (last == list.size() && !list.push_back(candidate)) {
    if (list.back().score >= candidate.score) return;
    last = list.size() - 1;
  }
  for (; last > 0 && list[last - 1].score < candidate.score; --last) list[last] = list[last - 1];
  list[last] = candidate;
}

}  // namespace ilp
