// Matches corners of two images by normalised cross-correlation (paper 3.2, first step), within a search radius around
// the positions that the overlap check predicts.
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/result.hpp"
#include "fsw/vision/features/feature_types.hpp"

namespace ilp {

struct MatcherParams {
  std::int32_t patch_side_px = 15;  ///< odd, 7 to limits::max_patch_side
  float search_radius_px = 48;      ///< around the predicted position; allows for relief and tilt
  float min_score = 0.7F;           ///< least correlation of a match, 0 to 1
};

struct MatcherWorkspace;  // defined in matcher_workspace.hpp
/// Finds mutual best matches and refines them to sub-pixel. `b_from_a` predicts where corners of a appear in b (px of
/// the real images). Patches of a are resampled with the rotation and scale of `b_from_a` before the comparison.
/// Matches are in the order of the corners of a.
///
/// The refined position Match::xb, yb corresponds to the exact position of corner a, which may lie between pixels. A
/// patch around corner a is registered to image b with an affine warp, a gain and an offset (subpixel.hpp), so that
/// errors of the corner detector have no effect. Returns `invalid_argument` if patch side, search radius, score or
/// prediction is out of range, `image_too_large` if an image exceeds the limits.
Status match_corners(GrayView image_a, const Corners& corners_a, GrayView image_b, const Corners& corners_b,
                     const Similarity2& b_from_a, const MatcherParams& params, MatcherWorkspace& workspace,
                     Matches& matches);

/// Does the same as match_corners with a homography (row-major, px to px) as the prediction, such as
/// OverlapResult::plane_b_from_a. A homography is more accurate for tilted cameras.
Status match_corners_by_plane(GrayView image_a, const Corners& corners_a, GrayView image_b, const Corners& corners_b,
                              const double (&plane_b_from_a)[9], const MatcherParams& params,
                              MatcherWorkspace& workspace, Matches& matches);

/// Does the same as match_corners_by_plane, then tracks the corners of a that have no match: it registers them directly
/// to image b, from the position that their nearest matches predict. The detector finds only about six of ten corners
/// again in the next image, so tracks of detected corners alone soon end; tracked corners continue them. A tracked
/// position is matched with an unmatched corner of b within 2 px. If there is none, a new corner (response 0) is
/// appended to `corners_b` while its capacity lasts.
Status match_and_track_corners(GrayView image_a, const Corners& corners_a, GrayView image_b, Corners& corners_b,
                               const double (&plane_b_from_a)[9], const MatcherParams& params,
                               MatcherWorkspace& workspace, Matches& matches);

/// Does the work of match_and_track_corners in slices: call begin_matching once, then match_and_track_slice with the
/// same arguments until it returns false. A slice smooths one image or processes some of the corners.
Status begin_matching(GrayView image_a, GrayView image_b, const double (&plane_b_from_a)[9],
                      const MatcherParams& params, MatcherWorkspace& workspace, Matches& matches);
Result<bool> match_and_track_slice(GrayView image_a, const Corners& corners_a, GrayView image_b, Corners& corners_b,
                                   const double (&plane_b_from_a)[9], const MatcherParams& params,
                                   MatcherWorkspace& workspace, Matches& matches);

}  // namespace ilp
