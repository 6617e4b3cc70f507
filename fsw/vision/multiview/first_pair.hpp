// The pair of cameras that a strip begins with: whether it is suited, and which of two motions it made (paper 3.2;
// decisions.md, 7). Matches on a plane may leave two motions. The structure begins with one of them, and the third
// camera decides between them, or the fourth one if the third cannot.
#pragma once

#include <cstdint>

#include "fsw/vision/twoview/third_view.hpp"

namespace ilp {

/// Plain numbers, because it is part of a checkpoint.
struct FirstPair {
  struct RivalCamera {
    double rotation[9] = {};     ///< camera from the structure's first one, row-major
    double translation[3] = {};  ///< in baselines
  };
  std::uint32_t waited = 0;     ///< keyframes skipped because their parallax was small
  std::uint32_t undecided = 0;  ///< keyframes that did not decide between the motion and its rival: at most 1
  bool ambiguous = false;       ///< there is a rival, and no later view has decided
  RivalCamera rival[2];     ///< the second and third camera if the rival is right; `undecided` + 1 of them are valid
  double plane[2][3] = {};  ///< of the motion taken and of its rival: plane . X = 1 in the frame of the newest
                            ///< camera, in baselines
};

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
