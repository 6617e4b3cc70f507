// The pair of cameras that a strip begins with: how well it is suited, and which of two motions it made (paper 3.2;
// decisions.md, 7). Matches on a plane may leave two motions. If the first two keyframes begin, the structure begins
// with one of the motions, and the third camera decides between them, or the fourth one if the third cannot. If a later
// pair begins, the other keyframes at hand decide.
#pragma once

#include <cstdint>

#include "fsw/vision/twoview/third_view.hpp"

namespace ilp {

/// The structure of a strip begins with a pair of its first keyframes, at most so many.
inline constexpr std::size_t max_first_keyframes = 5;

/// Plain numbers, because it is part of a checkpoint.
struct FirstPair {
  struct RivalCamera {
    double rotation[9] = {};     ///< camera from the structure's first one, row-major
    double translation[3] = {};  ///< in baselines
  };
  /// The pair that promises most, by ordinals. `error` is what pairs are ranked by; 0: no pair is usable.
  struct Candidate {
    double error = 0;
    std::uint64_t seed = 0;  ///< of the keyframe at which the pair was ranked
    std::uint32_t a = 0, b = 0;
  };
  Candidate best;
  std::uint32_t next = 0;          ///< the newest keyframe was ranked with those from this ordinal on
  std::uint32_t scale_camera = 1;  ///< ordinal of the camera whose distance from the first one is the unit of length
  std::uint32_t undecided = 0;     ///< keyframes that did not decide between the motion and its rival: at most 1
  bool begun = false;              ///< the cameras of the strip have poses
  bool ambiguous = false;          ///< there is a rival, and no later view has decided
  RivalCamera rival[2];     ///< the second and third camera if the rival is right; `undecided` + 1 of them are valid
  double plane[2][3] = {};  ///< of the motion taken and of its rival: plane . X = 1 in the frame of the newest
                            ///< camera, in baselines
};

/// What a pair promises: the expected relative error of the depth of a point in the middle of the image, by the median
/// parallax, the errors of the matches, and the errors of the relative pose, which fall with the number of matches and
/// are larger over a plane. Infinite for a pair that no structure can begin with: a rotation explains it, many poses
/// do, or it has too few inliers.
[[nodiscard]] double expected_depth_error(const TwoViewResult& pair, double focal_px);

/// The pair is ambiguous if `planes` holds two solutions that differ; the first one belongs to the motion taken. In a
/// descent they hardly differ: both motions lie along the plane's normal.
void remember_rival(const PlaneSolutions& planes, FirstPair& pair);
/// The structure's second (0) or third (1) camera from its first one.
[[nodiscard]] RigidTransform rival_camera(const FirstPair& pair, std::size_t index);

/// What a later view c leaves: the motion taken, its rival, or both. Both remain if c stands where a or b stood, or on
/// the line through them. If neither plane explains c, the ground is no plane, and its relief has already chosen the
/// motion taken.
enum class MotionChoice : std::uint8_t { taken, rival, open };

/// `pairs` are the matches of the newest camera with c. Status and the other arguments as choose_by_third_view.
Status choose_motion(const FirstPair& pair, const PointPairs& pairs, const CameraModel& camera,
                     const RansacParams& params, TwoViewWorkspace& workspace, MotionChoice& choice,
                     ThirdViewChoice& third);

/// The third view did not decide, but joins the structure: its camera is kept for either plane.
void keep_open(const ThirdViewChoice& third, FirstPair& pair);

}  // namespace ilp
