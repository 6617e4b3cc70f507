// Strips whose errors are known because they are put in by hand.
#pragma once

#include "sim/tools/score/pose_score.hpp"

namespace ilp::test {

/// The similarity from the truth's world to the strip's own: neither axis is vertical there, its unit is 23.7 of the
/// truth's.
[[nodiscard]] host::Similarity3 strip_from_true();

/// `count` exact poses along x, `step` apart, 100 above the ground, a gentle swing to the sides and in height, cameras
/// nearly nadir. Truth in a world with z up.
[[nodiscard]] score::StripTrack make_track(std::size_t count, double step);

/// Takes a sample's estimate off the truth by `error` (truth's world).
void displace(score::PoseSample& sample, const Vec3& error);

}  // namespace ilp::test
