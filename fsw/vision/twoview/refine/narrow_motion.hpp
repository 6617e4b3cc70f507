// Relative pose in parameters that suit a narrow field of view. Rays that are nearly parallel determine four of the
// five parameters well. They determine the fifth poorly: the angle by which the direction of view turns, and its sign
// above all. The opposite sign belongs to the mirror image of the scene in depth (the Necker cube). Only the
// perspective within the field decides between them. Sources: J. Koenderink, A. van Doorn, "Affine structure from
// motion", JOSA A 1991; R. Szeliski, S. B. Kang, "Shape ambiguities in structure from motion", PAMI 1997.
#pragma once

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

struct NarrowMotion {
  Vec3 middle_a = Vec3::UnitZ(), middle_b = Vec3::UnitZ();  ///< mean rays of the matches, z = 1
  /// Rotation to the camera from a frame whose z is the mean ray and whose x is the axis of the turn.
  Mat3 frame_a = Mat3::Identity(), frame_b = Mat3::Identity();
  double depth_ratio = 1;  ///< depth of the middle in a divided by its depth in b
  double offset = 0;       ///< displacement of the middle along the axis of the turn, divided by its depth in b
  double turn_rad = 0;     ///< angle between the two directions of view, with sign

  [[nodiscard]] Mat3 rotation() const;
  /// Unit: depth of the middle in b.
  [[nodiscard]] Vec3 translation() const;
};

/// Converts a pose to these parameters. Returns false if the field is not narrow: the RMS spread of an image's rays is
/// 0.1 rad or more, and perspective determines the motion. Also returns false if the motion is towards the matches. The
/// magnitude of the turn is clamped to 0.005 to 1 rad.
[[nodiscard]] bool narrow_motion(const NormalisedPairs& pairs, const PairSelection& selection,
                                 const RigidTransform& b_from_a, NarrowMotion& motion);
/// The pose, with |t| = 1.
[[nodiscard]] RigidTransform pose_of(const NarrowMotion& motion);

}  // namespace ilp
