// Normalised cross-correlation (NCC) of a small window for every pixel of a row and every disparity, by running sums.
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
  /// Mirrored, so that the index grows with the disparity.
  template <typename T>
  using RightRow = std::array<T, max_padded_width + max_padded_disparities>;

  /// Products of left and right grey values, summed over the rows of the window: [run][column][disparity]. Runs overlap
  /// by the border of the window. Sums over a window stay below 2^24, so that they are exact as float.
  alignas(64) std::array<std::int32_t, max_run_columns * max_padded_disparities> column_products;
  LeftRow<std::uint8_t> left_new, left_old;
  RightRow<std::uint8_t> right_new, right_old;
  /// Centred grey values of the row that enters the window and of the row that leaves it, 16 bits each. On the left
  /// side the leaving row is negated, so that the sum of both products is the change of a column's products.
  LeftRow<std::int32_t> left_pairs;
  RightRow<std::int32_t> right_pairs;
  LeftRow<std::int32_t> left_sums, left_squares;
  RightRow<std::int32_t> right_sums, right_squares;
  RightRow<std::int32_t> window_sums, window_squares;
  RightRow<float> right_mean, right_inverse_norm;
  RightRow<std::uint8_t> right_usable, right_discount;
  LeftRow<float> left_sum, left_inverse_norm;
};

/// The images, the parameters and the progress. Rows must be computed in order, from row 0, or from another `next_row`
/// if `begun` is false.
struct NccRows {
  GrayView left, right;
  MaskView left_valid, right_valid;
  std::int32_t min_disparity = 0;
  std::int32_t padded_disparities = 0;  ///< number of disparities, rounded up to a multiple of disparity_block
  std::int32_t radius = 1;
  float damping = 0;  ///< noise variance times the number of pixels of the window, grey levels squared
  int out_of_view_cost = max_matching_cost;
  std::int32_t next_row = 0;
  bool begun = false;
  SearchRow search;  ///< disparities that the latest row searched
};

/// Computes row `rows.next_row`. With padded = `rows.padded_disparities`:
/// - `ncc[x * padded + i]` is the correlation at disparity min_disparity + i, times ncc_one; 0 if either centre pixel
///   is invalid or outside its image.
/// - `cost`, at the same index, is the matching cost, 0 to max_matching_cost; `out_of_view_cost` if only the right
///   pixel is invalid. `cost` may be null.
/// - `variance[x]` is the grey variance of the left window.
/// Disparities that `search` leaves out are not written. Outside the image, border pixels are repeated.
///   ncc = (S_lr - S_l S_r / n) / sqrt((V_l + n s^2)(V_r + n s^2)), V = S_xx - S_x^2 / n, s = noise_grey.
void compute_ncc_row(NccRows& rows, const SearchRow& search, NccWorkspace& workspace, std::int16_t* ncc,
                     std::uint8_t* cost, float* variance);

}  // namespace ilp
