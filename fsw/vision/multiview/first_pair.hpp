// The pair of cameras that a strip begins with: whether it is suited, and which motion it was (paper 3.2; decisions.md,
// 7). Matches on a plane may leave two motions. The structure begins with one of them, and the next camera, the third,
// tells whether it was the other, or the fourth.
#pragma once

#include <cstdint>

#include "fsw/vision/twoview/third_view.hpp"

namespace ilp {

/// Plain numbers, as it is part of a checkpoint.
struct FirstPair {
  struct RivalCamera {
    double rotation[9] = {};     ///< camera from the structure's first one, row-major
    double translation[3] = {};  ///< in baselines
  };
  std::uint32_t waited = 0;     ///< keyframes passed over because their parallax was small
  std::uint32_t undecided = 0;  ///< keyframes that did not tell the motion from its rival: 1 at most
  bool ambiguous = false;       ///< there is a rival, and no later view has decided
  RivalCamera rival[2];         ///< the second camera and the third, if the rival is right; `undecided` + 1 are meant
  double plane[2][3] = {};      ///< of the motion taken and of its rival: plane . X = 1 in the frame of the newest
                                ///< camera, in baselines
};

/// Ambiguous if `planes` holds two, of which the first goes with the motion taken, and the other is not much the same:
/// as in a descent, where both lie along the plane's normal.
void remember_rival(const PlaneSolutions& planes, FirstPair& pair);
/// The structure's second (0) or third (1) camera from its first one.
[[nodiscard]] RigidTransform rival_camera(const FirstPair& pair, std::size_t index);

/// Which motion a later view c leaves: the one taken, its rival, or both, where both planes explain c as from the place
/// of a or b, or from the line through them. Where neither does the ground is no plane, and what relief there is has
/// chosen the motion taken.
enum class MotionChoice : std::uint8_t { taken, rival, open };

/// `pairs` are the matches of the newest camera with c. Status and the other arguments as choose_by_third_view.
Status choose_motion(const FirstPair& pair, const PointPairs& pairs, const CameraModel& camera,
                     const RansacParams& params, TwoViewWorkspace& workspace, MotionChoice& choice,
                     ThirdViewChoice& third);

/// The third view was left open and joins the structure all the same: it stands where either plane puts it.
void keep_open(const ThirdViewChoice& third, FirstPair& pair);

}  // namespace ilp
