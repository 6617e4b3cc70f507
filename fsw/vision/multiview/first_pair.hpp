// The pair of cameras that a strip's structure begins with: how well a pair is suited, and which of two possible
// motions it made (paper 3.2; decisions.md, 7). Matches on a plane may allow two motions. If the first two keyframes
// are the pair, the structure begins with one of the motions; the third camera decides between them, or the fourth if
// the third cannot. If a later pair begins, the other available keyframes decide.
#pragma once

#include <cstdint>

#include "fsw/vision/twoview/third_view.hpp"

namespace ilp {

/// Largest number of first keyframes among which the pair is chosen.
inline constexpr std::size_t max_first_keyframes = 5;

/// State of the choice. It has only plain numbers, because it is part of a checkpoint.
struct FirstPair {
  struct RivalCamera {
    double rotation[9] = {};     ///< rotation to this camera from the structure's first camera, row-major
    double translation[3] = {};  ///< in units of the first pair's baseline
  };
  /// The best pair so far; a and b are ordinals. Pairs are ranked by `error`, smaller first: the expected relative
  /// depth error, plus a penalty if the pair gives few points. 0: no pair is usable.
  struct Candidate {
    double error = 0;
    std::uint64_t seed = 0;  ///< seed of the keyframe at which the pair was ranked
    std::uint32_t a = 0, b = 0;
  };
  Candidate best;
  std::uint32_t next = 0;  ///< the newest keyframe has been ranked with the keyframes from this ordinal on
  /// Ordinal of the camera whose distance from the first camera is the unit of length.
  std::uint32_t scale_camera = 1;
  /// Number of later keyframes that did not decide between the motion and its rival: 0 or 1.
  std::uint32_t undecided = 0;
  bool begun = false;      ///< the structure has begun: the cameras of the strip have poses
  bool ambiguous = false;  ///< there is a rival motion, and no later view has decided
  /// The second and third camera if the rival motion is right; the first `undecided` + 1 elements are valid.
  RivalCamera rival[2];
  /// Planes of the motion taken and of its rival: plane . X = 1 in the frame of the newest camera, in units of the
  /// first pair's baseline.
  double plane[2][3] = {};
};

/// Returns the expected relative error of the depth of a point in the middle of the image. It follows from the median
/// parallax, the errors of the matches and the errors of the relative pose, which decrease with the number of matches
/// and are larger over a plane. Returns infinity for a pair that cannot begin a structure: a rotation explains it, many
/// poses explain it, or it has too few inliers.
[[nodiscard]] double expected_depth_error(const TwoViewResult& pair, double focal_px);

/// Stores the rival motion. The pair becomes ambiguous if `planes` holds two different solutions; the first one belongs
/// to the motion taken. In a descent the solutions hardly differ, because both motions lie along the normal of the
/// plane.
void remember_rival(const PlaneSolutions& planes, FirstPair& pair);
/// Returns the pose of the structure's second (index 0) or third (index 1) camera, from its first camera, if the rival
/// motion is right.
[[nodiscard]] RigidTransform rival_camera(const FirstPair& pair, std::size_t index);

/// Result for a later view c: the motion taken, its rival, or no decision (`open`). There is no decision if c is at the
/// position of a or b, or on the line through them. If neither plane explains c, the ground is not a plane; its relief
/// has then already confirmed the motion taken.
enum class MotionChoice : std::uint8_t { taken, rival, open };

/// Decides between the motion taken and its rival. `pairs` are the matches between the newest camera and c. Status and
/// the other arguments are those of choose_by_third_view.
Status choose_motion(const FirstPair& pair, const PointPairs& pairs, const CameraModel& camera,
                     const RansacParams& params, TwoViewWorkspace& workspace, MotionChoice& choice,
                     ThirdViewChoice& third);

/// Call it if the third view did not decide but joins the structure: stores its camera for either plane.
void keep_open(const ThirdViewChoice& third, FirstPair& pair);

}  // namespace ilp
