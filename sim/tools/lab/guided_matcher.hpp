// A second pass of matching, once the relation of the two images is estimated. Corners are searched where that relation
// allows them, and matches that contradict it are removed (R. Hartley, A. Zisserman, "Multiple View Geometry", 2nd ed.,
// algorithm 11.4, step "guided matching").
#pragma once

#include "fsw/vision/features/matcher.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {

enum class GuideKind : std::uint8_t {
  line,  ///< fundamental matrix: corner b lies on the epipolar line of corner a
  plane  ///< homography: corner b lies at the image of corner a
};

/// In ideal pixels of the two cameras (fsw/vision/geometry/camera.hpp); corners are in real pixels.
struct MatchGuide {
  GuideKind kind = GuideKind::line;
  double matrix[9] = {};  ///< row-major; line: b^T F a = 0; plane: b ~ H a
  CameraModel camera_a, camera_b;
};

/// The epipolar lines of a relative pose. The length of its translation does not matter, but it must not be zero.
[[nodiscard]] MatchGuide guide_of_pose(const RigidTransform& b_from_a, const CameraModel& camera_a,
                                       const CameraModel& camera_b);

struct GuidedParams {
  float max_distance_px = 1;       ///< from match to guide: Sampson's distance (line), transfer error in b (plane)
  float search_radius_px = 24;     ///< along the line, about the place predicted by the neighbouring matches
  float min_score = 0.7F;          ///< normalised cross correlation
  float max_second_ratio = 0.98F;  ///< second best / best: a line has few rivals
};

/// `matches`, in and out, are those of match_corners_by_plane or match_and_track_corners on the same images, corners
/// and prediction. Matches farther from the guide than max_distance_px are removed. Corners of a without a match are
/// then compared with the free corners of b near their line (or place), mutual best. If there was no detected corner,
/// they are searched along the line; such a match ends at a free corner of b or at a new one (response 0) appended to
/// `corners_b` as long as there is room. Matches are in order of corner a, refined as in match_corners.
///
/// `invalid_argument`: as in match_corners, the guide (not finite, or nothing but zeros), a value of
/// GuidedParams, a match with an index out of range or a corner used twice. `image_too_large`; the Status
/// of validate() for a camera.
Status match_guided(GrayView image_a, const Corners& corners_a, GrayView image_b, Corners& corners_b,
                    const double (&plane_b_from_a)[9], const MatchGuide& guide, const MatcherParams& params,
                    const GuidedParams& guided, MatcherWorkspace& workspace, Matches& matches);

}  // namespace ilp
