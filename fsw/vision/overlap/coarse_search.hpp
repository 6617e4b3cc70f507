// Exhaustive search for the similarity between two images of at most 32 px: every rotation and scale of a grid, every
// shift.
//
// The template is the complete image a, rotated and scaled: at a small overlap, a smaller template would leave image b.
// At each shift, the correlation is normalised over the part of the template that covers b (decisions.md, 2).
#pragma once

#include <array>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/overlap/overlap.hpp"
#include "fsw/vision/overlap/peak_list.hpp"

namespace ilp {

inline constexpr std::int32_t coarse_max_side = 32;  ///< px, of both images
inline constexpr double coarse_max_scale = 1.5;
/// Fractional bits of the grey values: after averaging over many pixels, flat ground has little contrast.
inline constexpr int coarse_value_bits = 2;

using CoarseView = ImageView<const std::int16_t>;

struct CoarseWorkspace {
  // 32 px turned by 45 degrees and enlarged by coarse_max_scale, rounded up to whole vectors of 16 bytes.
  static constexpr std::int32_t canvas_side = 80;
  static constexpr std::int32_t byte_vector_px = 16;
  // b with padding on the left and right for a canvas at its border, and for the canvas's last vector.
  static constexpr std::int32_t padded_side = coarse_max_side + 2 * canvas_side + 16;
  static constexpr std::int32_t max_shifts = coarse_max_side + canvas_side + 1;
  template <typename T, std::int32_t Rows, std::int32_t Columns>
  using Grid = std::array<T, static_cast<std::size_t>(Rows) * static_cast<std::size_t>(Columns)>;

  // Rows of the canvas may be read one vector past their end.
  Grid<std::int16_t, canvas_side + 1, canvas_side> canvas;  ///< a, rotated and scaled, minus its mean; 0 outside
  Grid<std::uint8_t, canvas_side + 1, canvas_side> canvas_bytes, canvas_mask;  ///< mask: 255 inside, 0 outside
  std::array<std::int16_t, canvas_side> span_begin, span_end;  ///< columns inside a, for each row of the canvas
  /// a, each pixel in one word with its right neighbour, which is the upper half.
  Grid<std::uint32_t, coarse_max_side, coarse_max_side> pairs;
  static constexpr std::int32_t most_lanes = 8;                ///< sums that are computed at once
  std::array<std::int32_t, canvas_side + byte_vector_px> row;  ///< the present row of the canvas

  /// Sums over the canvas left of x and above y: pixels inside, values, squares. Each row begins with the sum over the
  /// full width and ends with 0, followed by padding for a vector.
  static constexpr std::int32_t sums_stride = canvas_side + 1 + most_lanes;
  Grid<std::int32_t, canvas_side + 1, sums_stride> inside_sums, value_sums, square_sums;
  /// b minus its mean, each pixel in one word with its right neighbour, which is the upper half; 0 left and right of b.
  Grid<std::uint32_t, coarse_max_side, padded_side> padded;
  Grid<std::uint8_t, coarse_max_side, padded_side> padded_bytes, padded_mask;
  Grid<std::int32_t, coarse_max_side, padded_side + 1> prefix, prefix_squares;  ///< running sums along the rows of b
  /// Sums over the covered rows of the canvas, left of a column; each element is for the column one to the left of the
  /// previous one.
  struct ColumnSums {
    std::array<std::int32_t, max_shifts + coarse_max_side + 2 * most_lanes> inside, value, square;
  } column_sums;
  /// For each shift along x, at one shift along y, with padding for a vector.
  std::array<std::int32_t, max_shifts + 16> count, sum_a, sum_aa, sum_b, sum_bb, sum_ab;
  Grid<float, max_shifts + 1, max_shifts> scores;  ///< with padding for a vector
};

/// Finds the best distinct peaks, best first. Both images have the same size, with sides of at most coarse_max_side,
/// and grey values in units of 2^-coarse_value_bits. Returns `invalid_argument` if they are larger,
/// `image_size_changed` if their sizes differ.
Status search_coarse(CoarseView a, CoarseView b, const OverlapParams& params, CoarseWorkspace& workspace,
                     CoarseCandidates& candidates);

}  // namespace ilp
