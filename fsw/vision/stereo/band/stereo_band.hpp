// Semi-global matching of a band of rows as a job that a compute device may do (docs/compute.md): correlations, paths
// and winners of the rows, without what follows from these. The paths that come from the rows above are part of the
// input, and those that lead to the rows below part of the output, so that a job is a pure function.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/vision/stereo/cost/ncc_cost.hpp"
#include "fsw/vision/stereo/semi_global/path_aggregation.hpp"

namespace ilp {

inline constexpr std::int32_t stereo_band_rows = search_tile;
/// Pairs with more disparities are matched without jobs.
inline constexpr std::int32_t stereo_band_disparities = 128;
/// Rows of the images that a band needs, those of all of its windows.
inline constexpr std::int32_t stereo_band_held_rows = stereo_band_rows + 2 * max_window_radius;
inline constexpr std::int32_t stereo_band_width = limits::max_rectified_width;
inline constexpr std::int32_t stereo_band_peaks = 5;

/// Costs of the handed paths: [path][column][disparity]; 0 beyond the image and the padded disparities.
using StereoBandPaths =
    std::array<std::uint8_t, std::size_t{handed_paths} * stereo_band_width * stereo_band_disparities>;

/// Where the arrays of input and output begin, in words of four bytes: a shader does not know the capacities.
struct StereoBandPlaces {
  std::int32_t large_step, runs, left, right, left_sum, left_inverse_norm, right_mean, right_inverse_norm, paths;
  std::int32_t row_bytes;    ///< of an image row
  std::int32_t row_pixels;   ///< of the other arrays
  std::int32_t paths_given;  ///< in the output
};

struct StereoBandInput {
  std::uint32_t serial;  ///< another one for each job
  std::int32_t width, rows;
  std::int32_t held_rows, first_row;  ///< rows of the images here, and the band's first one among them
  std::int32_t continues;             ///< 1: rows above have handed down paths
  std::int32_t padded, disparities;   ///< as of NccRows and DisparityRange
  std::int32_t radius, min_disparity;
  std::int32_t lead, small_step, out_of_view_cost;
  float damping;
  std::int32_t run_count;
  std::int32_t reserved;
  StereoBandPlaces places;
  std::array<std::uint8_t, 256> large_step;  ///< by grey difference
  std::array<SearchRun, static_cast<std::size_t>(max_search_tiles)> runs;
  using Rows = std::array<std::uint8_t, static_cast<std::size_t>(stereo_band_held_rows) * stereo_band_width>;
  Rows left, right, left_valid, right_valid;
  /// RowMoments of the band's rows.
  using Moments = std::array<float, static_cast<std::size_t>(stereo_band_rows) * stereo_band_width>;
  Moments left_sum, left_inverse_norm, right_mean, right_inverse_norm;
  StereoBandPaths paths;
};

struct StereoBandPixel {
  std::uint32_t winner = 0;  ///< RowWinner: cost, from bit 15 whether it is unique, from bit 16 the index
  /// Correlations at the winner and the two disparities on either side; 0 where these are not searched.
  std::array<std::int16_t, stereo_band_peaks> peaks{};
  std::int16_t reserved = 0;
};
static_assert(sizeof(StereoBandPixel) == 16 && max_path_sum < 1 << 15);

/// Pixels beyond the image and the band's rows are 0.
struct StereoBandOutput {
  std::array<std::array<StereoBandPixel, static_cast<std::size_t>(stereo_band_width)>,
             static_cast<std::size_t>(stereo_band_rows)>
      rows;
  StereoBandPaths paths;
};

/// A unit of the output is a row, or as much of the paths.
inline constexpr std::size_t stereo_band_unit_bytes = sizeof(StereoBandPixel) * stereo_band_width;
inline constexpr std::size_t stereo_band_units = sizeof(StereoBandOutput) / stereo_band_unit_bytes;
static_assert(stereo_band_units * stereo_band_unit_bytes == sizeof(StereoBandOutput));
static_assert(stereo_band_unit_bytes % stereo_band_disparities == 0);

/// What the processor's function needs: the memory of a matcher that is not at work meanwhile.
struct StereoBandWorkspace {
  NccWorkspace* ncc = nullptr;
  PathWorkspace* paths = nullptr;
  std::int16_t* correlations = nullptr;  ///< max_cost_entries
  std::uint8_t* costs = nullptr;         ///< likewise
  float* variance = nullptr;             ///< of a row
  RowWinner* winners = nullptr;          ///< likewise
  // The job at work: its rows are computed in order.
  const StereoBandInput* input = nullptr;
  std::uint32_t serial = 0;
  std::int32_t next_row = 0;
  NccRows rows;
  PathPenalties penalties;
};

/// Fills in what follows from the rest: places, moments of all rows, and the variance of their left windows.
void complete_stereo_band(StereoBandInput& input, NccWorkspace& workspace, float* variance);

/// Unit `unit` of the output. Units are cheap in order: any other one computes the rows before it as well.
void compute_stereo_band_unit(const StereoBandInput& input, std::size_t unit, StereoBandWorkspace& workspace,
                              std::span<std::byte> output);

/// A job with made-up ground, one of many: for comparing a device with the processor.
void make_stereo_band_example(std::uint32_t number, StereoBandWorkspace& workspace, StereoBandInput& input);

}  // namespace ilp
