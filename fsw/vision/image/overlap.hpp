// How much of one image is seen again in another (paper 3.1; decisions.md, 1 and 2).
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

enum class OverlapMethod : std::uint8_t { ncc, sad };

/// A verdict is an answer, not a fault (decisions.md, 13). `ok` is the only one with a trustworthy overlap.
enum class OverlapVerdict : std::uint8_t { ok, overlap_unknown, texture_poor, too_dark, blurred, count };
[[nodiscard]] const char* overlap_verdict_name(OverlapVerdict verdict);

struct OverlapParams {
  OverlapMethod method = OverlapMethod::ncc;
  double min_overlap = 0.5;          ///< smallest overlap that must be measurable: sets template size and search range
  double max_rotation_rad = 0.35;    ///< searched on both sides of the prediction; pi is a full turn
  double max_scale = 1.25;           ///< searched from 1 / max_scale to max_scale
  double min_ncc = 0.4;              ///< of the best peak at the finest level
  double min_peak_margin = 0.05;     ///< best minus second best peak
  double min_stddev = 4;             ///< grey levels, of the whole image: below is texture_poor
  double min_mean = 8;               ///< grey levels: below is too_dark
};

struct OverlapResult {
  OverlapVerdict verdict = OverlapVerdict::overlap_unknown;
  double overlap = 0;                ///< area of a seen in b / area of a, in [0, 1], of the two footprints
  Similarity2 b_from_a;              ///< full-resolution pixels
  double ncc = 0;                    ///< best peak
  double ncc_second = 0;             ///< best peak outside the neighbourhood of the first
  double sigma_px = 0;               ///< one-sigma error of the shift, full-resolution pixels
};

struct OverlapWorkspace;  // defined in overlap_workspace.hpp
/// Both images have the same size. Coarse to fine over subsampled images; deterministic, integer sums.
Status measure_overlap(GrayView image_a, GrayView image_b, const OverlapParams& params, OverlapWorkspace& workspace,
                       OverlapResult& result);

/// Area of the footprint intersection under a similarity, as a fraction of the area of image a (width x height each).
[[nodiscard]] double footprint_overlap(std::int32_t width, std::int32_t height, const Similarity2& b_from_a);

}  // namespace ilp
