// Corner matching by normalised cross correlation (paper 3.2, first step), in the window that the overlap check predicts.
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/features/feature_types.hpp"

namespace ilp {

struct MatcherParams {
  std::int32_t patch_side_px = 15;     ///< odd, at most limits::max_patch_side
  float search_radius_px = 48;         ///< around the position predicted by the similarity: relief and tilt
  float min_score = 0.7F;              ///< weaker correlations are not matches
  float max_second_ratio = 0.95F;      ///< second best / best correlation inside the window, above it is ambiguous
};

struct MatcherWorkspace;  // defined in matcher_workspace.hpp
/// Mutual best matches. `b_from_a` predicts where corners of a appear in b (real pixels); patches of a are resampled with
/// its rotation and scale before they are compared. Matches come in order of corner a.
Status match_corners(GrayView image_a, const Corners& corners_a, GrayView image_b, const Corners& corners_b,
                     const Similarity2& b_from_a, const MatcherParams& params, MatcherWorkspace& workspace,
                     Matches& matches);

}  // namespace ilp
