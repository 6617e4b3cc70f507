// Normalised cross correlation of a small window for every pixel of a row and every disparity, by running sums.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/vision/stereo/cost/search_range.hpp"
#include "fsw/vision/stereo/stereo_params.hpp"

namespace ilp {

inline constexpr std::int32_t max_window_radius = 4;
/// Correlations are stored as integers: ncc_one is a correlation of 1.
inline constexpr std::int32_t ncc_one = 16384;

inline constexpr std::size_t max_padded_width =
    static_cast<std::size_t>(limits::max_rectified_width) + std::size_t{2} * max_window_radius;
inline constexpr std::size_t max_run_columns =
    static_cast<std::size_t>(limits::max_rectified_width) + std::size_t{2} * max_window_radius * max_search_tiles;
inline constexpr std::size_t max_cost_entries =
    static_cast<std::size_t>(limits::max_rectified_width) * max_padded_disparities;

struct NccWorkspace {
  template <typename T>
  using LeftRow = std::array<T, max_padded_width>;
  /// Mirrored, so that growing disparity is growing index.
  template <typename T>
  using RightRow = std::array<T, max_padded_width + max_padded_disparities>;

  /// Products of left and right grey, summed over the window's rows: [run][column][disparity]. Runs overlap by the
  /// window's border. Sums over a window stay below 2^24: exact as float.
  alignas(64) std::array<std::int32_t, max_run_columns * max_padded_disparities> column_products;
  LeftRow<std::uint8_t> left_new, left_old;
  RightRow<std::uint8_t> right_new, right_old;
  /// Centred grey of the row that enters the window and of the one that leaves it, 16 bits each. The latter is negated
  /// on the left, so that the sum of both products is the change of a column's products.
  LeftRow<std::int32_t> left_pairs;
  RightRow<std::int32_t> right_pairs;
  LeftRow<std::int32_t> left_sums, left_squares;
  RightRow<std::int32_t> right_sums, right_squares;
  RightRow<std::int32_t> window_sums, window_squares;
  RightRow<float> right_mean, right_inverse_norm;
  RightRow<std::uint8_t> right_usable, right_discount;
  LeftRow<float> left_sum, left_inverse_norm;
};

/// The images and the row state. Rows must be computed in order, from row 0 or from a `next_row` with `begun` = false.
struct NccRows {
  GrayView left, right;
  MaskView left_valid, right_valid;
  std::int32_t min_disparity = 0;
  std::int32_t padded_disparities = 0;  ///< multiple of disparity_block
  std::int32_t radius = 1;
  float damping = 0;  ///< noise variance times window area, grey^2
  int out_of_view_cost = max_matching_cost;
  std::int32_t next_row = 0;
  bool begun = false;
  SearchRow search;  ///< of the latest row
};

/// Computes row `rows.next_row`: `ncc[x * padded + i]` = correlation at disparity min_disparity + i, scaled by ncc_one,
/// 0 if either centre pixel is invalid or outside; `cost` = the matching cost in [0, max_matching_cost],
/// `out_of_view_cost` if only the right one is invalid. Outside the image the border is repeated. Disparities that
/// `search` leaves out are not written. `cost` may be null. `variance[x]`: grey variance of the left window.
///   ncc = (S_lr - S_l S_r / n) / sqrt((V_l + n s^2)(V_r + n s^2)), V = S_xx - S_x^2 / n, s = noise_grey.
void compute_ncc_row(NccRows& rows, const SearchRow& search, NccWorkspace& workspace, std::int16_t* ncc,
                     std::uint8_t* cost, float* variance);

}  // namespace ilp
