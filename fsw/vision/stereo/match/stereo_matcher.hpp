// Dense matching of a rectified pair (paper 3.3): normalised cross-correlation over a small window, dynamic programming
// along scanlines, sub-pixel disparities with their errors. Pixels that cannot be matched are invalid, except in small
// gaps that the ground around them supports and the images confirm.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/base/image_view.hpp"
#include "fsw/base/result.hpp"
#include "fsw/vision/stereo/cost/coarse_level.hpp"
#include "fsw/vision/stereo/cost/ncc_cost.hpp"
#include "fsw/vision/stereo/disparity_map.hpp"
#include "fsw/vision/stereo/disparity_range.hpp"
#include "fsw/vision/stereo/match/disparity_border.hpp"
#include "fsw/vision/stereo/match/disparity_selection.hpp"
#include "fsw/vision/stereo/match/disparity_smoothing.hpp"
#include "fsw/vision/stereo/match/edge_surfaces.hpp"
#include "fsw/vision/stereo/match/gap_support.hpp"
#include "fsw/vision/stereo/match/segment_filter.hpp"
#include "fsw/vision/stereo/ordered/ordered_rows.hpp"
#include "fsw/vision/stereo/semi_global/ordering_filter.hpp"
#include "fsw/vision/stereo/semi_global/path_aggregation.hpp"
#include "fsw/vision/stereo/stereo_params.hpp"

namespace ilp {

/// Memory of the row matchers. Only one of them is in use, and each initialises what it reads.
union RowMatcherWorkspace {
  RowMatcherWorkspace() : semi_global() {}

  struct SemiGlobal {
    PathWorkspace paths;
    OrderingWorkspace ordering;
  } semi_global;
  OrderedWorkspace ordered;
};

/// Largest number of rows that a matcher processes at once. MatchedRow holds the correlations of one of them and the
/// chosen disparities.
inline constexpr std::int32_t max_rows_at_once = row_lanes;
static_assert(search_tile % max_rows_at_once == 0, "rows at once have one search");
struct MatchedRow {
  alignas(64) std::array<std::int16_t, max_cost_entries + std::size_t{2} * disparity_block> padded_ncc;
  std::array<float, static_cast<std::size_t>(limits::max_rectified_width)> variance;
  std::array<RowWinner, static_cast<std::size_t>(limits::max_rectified_width)> winners;

  /// The correlations. Spare elements before and after them allow loads of whole vectors.
  [[nodiscard]] std::int16_t* ncc() { return padded_ncc.data() + disparity_block; }
  [[nodiscard]] const std::int16_t* ncc() const { return padded_ncc.data() + disparity_block; }
};

struct StereoWorkspace {
  union {
    NccWorkspace ncc;
    /// Kinds of the result's pixels, written after all rows are matched. They are valid until another pair is matched.
    std::array<DisparityKind, limits::max_rectified_pixels> kinds;
  };
  RowMatcherWorkspace matcher;
  SelectionWorkspace selection;
  PixelForest segments;
  BorderWorkspace border;
  EdgeWorkspace edges;
  SmoothingWorkspace smoothing;
  GapWorkspace gaps;
  std::array<MatchedRow, static_cast<std::size_t>(max_rows_at_once)> rows;
  alignas(64) std::array<std::uint8_t, max_cost_entries> cost_row;
  /// Search of each band of search_tile rows.
  std::array<SearchRow, static_cast<std::size_t>(max_search_bands)> search;
};

/// Matches one pair at a time, some scanlines per step: first at a quarter of the resolution, to find the disparities
/// to search, then at full resolution. The views given to `begin` must outlive the last step. Until then the result
/// holds intermediate values.
class StereoMatcher {
 public:
  /// Begins a pair. Images, masks and result must have the same size; the kinds of the result are kept in `workspace`.
  /// Grey values outside a mask should continue the image, as resample_rows leaves them. Returns `invalid_argument` if
  /// the sizes differ, the range is empty or a parameter is out of range; `image_too_large` if the image exceeds the
  /// limits; `disparity_range_exceeded` if the range holds more than limits::max_disparities.
  Status begin(GrayView left, GrayView right, MaskView left_valid, MaskView right_valid, const DisparityRange& range,
               const StereoParams& params, StereoWorkspace& workspace, const DisparityView& result);

  /// Processes up to `rows` scanlines. Returns true while work is left; after false, the result is final.
  Result<bool> step(std::int32_t rows);
  [[nodiscard]] const DisparityView& result() const { return result_; }

 private:
  enum class Phase : std::uint8_t {
    reduce,
    match_coarse,
    clean_coarse,
    narrow,
    match,
    filter,
    propose,
    connect,
    accept,
    done
  };

  [[nodiscard]] std::int32_t rows_at_once() const;
  void match_row(NccRows& rows, const SearchRow& search, const DisparityRange& range, const DisparityView& result);
  void finish_row(const NccRows& rows, std::int32_t y, const DisparityRange& range, const MatchedRow& row,
                  const float* variance, const DisparityView& result);
  void choose(const NccRows& rows, std::int32_t y, std::int32_t count, std::int32_t disparities);
  void filter_row(std::int32_t y);
  void do_row();
  void advance();
  [[nodiscard]] std::int32_t rows_of(Phase phase) const;

  Phase phase_ = Phase::done;
  std::int32_t row_ = 0;  ///< next row of the phase
  CoarsePair coarse_;
  NccRows coarse_rows_, rows_;
  DisparityRange coarse_range_;
  DisparityView coarse_result_;  ///< in the top left corner of the result's memory
  DisparityRange range_;
  StereoParams params_;
  PathPenalties penalties_;
  StereoWorkspace* workspace_ = nullptr;
  DisparityView result_;
};

}  // namespace ilp
