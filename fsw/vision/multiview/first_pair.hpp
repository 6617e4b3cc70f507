// The pair of cameras that a strip begins with: whether it is suited, and which motion it was (paper 3.2; decisions.md,
// 7). Matches on a plane may leave two motions. The structure begins with one of them, and the next camera, the third,
// tells whether it was the other.
#pragma once

#include <cstdint>

#include "fsw/vision/twoview/third_view.hpp"

namespace ilp {

/// Plain numbers, as it is part of a checkpoint.
struct FirstPair {
  std::uint32_t waited = 0;          ///< keyframes passed over because their parallax was small
  std::uint32_t undecided = 0;       ///< keyframes passed over because they did not tell the motion from its rival
  bool ambiguous = false;            ///< there is a rival, and no third view has decided
  double rival_rotation[9] = {};     ///< b_from_a, row-major
  double rival_translation[3] = {};  ///< of unit length
  double plane[2][3] = {};           ///< of the motion taken and of its rival: plane . X = 1 in frame b, in baselines
};

/// Ambiguous if `planes` holds two, of which the first goes with the motion taken, and the other is not much the same:
/// as in a descent, where both lie along the plane's normal.
void remember_rival(const PlaneSolutions& planes, FirstPair& pair);
[[nodiscard]] RigidTransform rival_motion(const FirstPair& pair);

/// Which motion a third view c leaves: the one taken, its rival, or both, where both planes explain c as from the place
/// of a or b. Where neither does the ground is no plane, and what relief there is has chosen the motion taken.
enum class MotionChoice : std::uint8_t { taken, rival, open };

/// `pairs` are the matches of the second camera, b, with c. Status and the other arguments as choose_by_third_view.
Status choose_motion(const FirstPair& pair, const PointPairs& pairs, const CameraModel& camera,
                     const RansacParams& params, TwoViewWorkspace& workspace, MotionChoice& choice);

}  // namespace ilp
