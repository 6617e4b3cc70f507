// Corner matching by normalised cross correlation (paper 3.2, first step), in the window that the overlap check
// predicts.
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/result.hpp"
#include "fsw/vision/features/feature_types.hpp"

namespace ilp {

struct MatcherParams {
  std::int32_t patch_side_px = 15;  ///< odd, 7 to limits::max_patch_side
  float search_radius_px = 48;      ///< around the predicted position: relief and tilt
  float min_score = 0.7F;           ///< weaker correlations are not matches
};

struct MatcherWorkspace;  // defined in matcher_workspace.hpp
/// Finds mutual best matches, refined to sub-pixel. `b_from_a` predicts where corners of a appear in b (real pixels).
/// Patches of a are resampled with its rotation and scale before the comparison. Matches are in order of corner a.
///
/// The refined position Match::xb, yb belongs to corner a's own position, which may lie between pixels: a patch around
/// it is registered to image b with an affine warp, a gain and an offset (subpixel.hpp), so that errors of the corner
/// detector have no effect. `invalid_argument` (patch side, search radius, prediction, score), `image_too_large`.
Status match_corners(GrayView image_a, const Corners& corners_a, GrayView image_b, const Corners& corners_b,
                     const Similarity2& b_from_a, const MatcherParams& params, MatcherWorkspace& workspace,
                     Matches& matches);

/// As match_corners with a homography (row-major) as prediction, such as OverlapResult::plane_b_from_a, which is more
/// accurate for tilted cameras.
Status match_corners_by_plane(GrayView image_a, const Corners& corners_a, GrayView image_b, const Corners& corners_b,
                              const double (&plane_b_from_a)[9], const MatcherParams& params,
                              MatcherWorkspace& workspace, Matches& matches);

/// As match_corners_by_plane; then corners of a without a partner are registered directly to image b, starting where
/// their nearest matches lead. The detector finds about six of ten corners again in the next image, so that tracks of
/// detected corners alone soon end, while these go on. The result becomes the match of a corner of b within 2 px that
/// has none yet; otherwise a new corner (response 0) is appended to `corners_b` as long as there is room.
Status match_and_track_corners(GrayView image_a, const Corners& corners_a, GrayView image_b, Corners& corners_b,
                               const double (&plane_b_from_a)[9], const MatcherParams& params,
                               MatcherWorkspace& workspace, Matches& matches);

/// The same in slices: one call of begin_matching, then of match_and_track_slice with the same arguments while there
/// is more. A slice smooths an image, or works on some of the corners.
Status begin_matching(GrayView image_a, GrayView image_b, const double (&plane_b_from_a)[9],
                      const MatcherParams& params, MatcherWorkspace& workspace, Matches& matches);
Result<bool> match_and_track_slice(GrayView image_a, const Corners& corners_a, GrayView image_b, Corners& corners_b,
                                   const double (&plane_b_from_a)[9], const MatcherParams& params,
                                   MatcherWorkspace& workspace, Matches& matches);

}  // namespace ilp
