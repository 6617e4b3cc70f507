// Exhaustive search for the similarity between two very small images: every rotation and scale of a grid, every shift.
//
// The template is the whole of image a, turned and scaled: a smaller one could not slide as far as a small overlap asks
// without leaving image b. Positions covered only in part are normalised over the covered part (decisions.md, 2).
#pragma once

#include <array>

#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/image/centred_similarity.hpp"
#include "fsw/vision/image/overlap.hpp"

namespace ilp {

inline constexpr std::int32_t coarse_max_side = 48;  ///< px, of both images
inline constexpr std::size_t coarse_max_candidates = 8;

struct CoarseCandidate {
  CentredSimilarity b_from_a;  ///< px of the coarse images
  double rotation_rad = 0;
  double scale = 1;
  double score = 0;  ///< NCC, or the correlation that the mean absolute difference would have for Gaussian grey values
};
using CoarseCandidates = FixedVector<CoarseCandidate, coarse_max_candidates>;

struct CoarseWorkspace {
  // 48 px turned by 45 degrees and enlarged by coarse_max_scale, rounded up to whole vectors of eight.
  static constexpr std::int32_t canvas_side = 104;
  // b with room left and right for a canvas that just leaves it.
  static constexpr std::int32_t padded_side = coarse_max_side + 2 * canvas_side;
  static constexpr std::int32_t max_shifts = coarse_max_side + canvas_side + 1;

  template <typename T, std::int32_t Side>
  using Square = std::array<T, static_cast<std::size_t>(Side) * static_cast<std::size_t>(Side)>;

  Square<std::int16_t, canvas_side> canvas;  ///< a, turned and scaled, minus its mean; 0 outside
  Square<std::uint8_t, canvas_side> canvas_bytes;
  Square<std::int32_t, canvas_side> canvas_inside;  ///< 0 or 1
  Square<std::int32_t, canvas_side> canvas_squares;
  Square<std::int32_t, canvas_side + 1> inside_sums, value_sums, square_sums;
  std::array<std::int16_t, canvas_side> span_begin, span_end;      ///< inside columns of every canvas row
  std::array<std::int16_t, coarse_max_side * padded_side> padded;  ///< b minus its mean; 0 left and right of it
  std::array<std::uint8_t, coarse_max_side * padded_side> padded_bytes;
  std::array<std::int32_t, coarse_max_side*(padded_side + 1)> prefix, prefix_squares;  ///< along the rows of b
  std::array<std::int32_t, max_shifts> sum_b, sum_bb;                                  ///< per dx of one dy
  std::array<float, static_cast<std::size_t>(max_shifts) * max_shifts> scores;
};

inline constexpr double coarse_max_scale = 1.5;

/// Best distinct peaks, best first. Images have one size, with sides of at most coarse_max_side.
Status search_coarse(GrayView a, GrayView b, const OverlapParams& params, CoarseWorkspace& workspace,
                     CoarseCandidates& candidates);

}  // namespace ilp
