// The motion of two views in the terms of a narrow field of view. Rays that are nearly parallel determine four of its
// five parameters. They say little about the fifth, the angle by which the view of the scene turns, and hardly tell it
// from its negative: the scene from its mirror image in depth, which turns the other way (the Necker cube). Perspective
// within the field alone does. Sources: J. Koenderink, A. van Doorn, "Affine structure from motion", JOSA A 1991;
// R. Szeliski, S. B. Kang, "Shape ambiguities in structure from motion", PAMI 1997.
#pragma once

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

struct NarrowMotion {
  Vec3 middle_a = Vec3::UnitZ(), middle_b = Vec3::UnitZ();  ///< mean rays of the matches, z = 1
  /// Camera from a frame whose z is the direction to the middle of the matches and whose x is the axis of the turn.
  Mat3 frame_a = Mat3::Identity(), frame_b = Mat3::Identity();
  double depth_ratio = 1;  ///< of the middle in a / in b
  double offset = 0;       ///< of the middle in b along the axis / depth
  double turn_rad = 0;     ///< between the two directions of view

  [[nodiscard]] Mat3 rotation() const;
  /// In depths of the middle in b.
  [[nodiscard]] Vec3 translation() const;
};

/// False where the field is not narrow, so that perspective leaves one motion: the rays of an image spread by more than
/// a tenth of a radian (root mean square). False also where the motion is towards the matches. The turn is kept between
/// 0.3 and 60 degrees.
[[nodiscard]] bool narrow_motion(const NormalisedPairs& pairs, const PairSelection& selection,
                                 const RigidTransform& b_from_a, NarrowMotion& motion);
/// With |t| = 1.
[[nodiscard]] RigidTransform pose_of(const NarrowMotion& motion);

}  // namespace ilp
