// Whether the stated position sigmas are honest.
//
// The flight states a keyframe's sigma relative to the gauge of its strip's world: the pose of the strip's first posed
// camera and the length of the first baseline, which define this world and so are without error in it
// (fsw/vision/multiview/sequence_covariance.hpp). The error that is compared is relative to the same: the truth is laid
// onto the strip by
//   rotation  that of the first camera's attitude, W = R_0^T Q_0,
//   scale     of the first baseline, s = |c_1 - c_0| / |C_1 - C_0|,
//   origin    the first camera;
// the error is then e_i = (c_i - c_0) - s W (C_i - C_0), along the strip's axes and in its unit, like sigma. What the
// best alignment of the whole strip would take away, a wrong attitude or scale of the first pair, is in e and in sigma
// alike. The errors of one strip hang together, so shares are worth something over many strips only.
// The first two samples define the gauge, and sigmas of 0 state nothing: both are left out.
#pragma once

#include <map>

#include "sim/tools/score/pose_score.hpp"

namespace ilp::score {

/// With normal errors and exact sigmas 68.3 % are within one and 95.4 % within two, and the normalised error squared is
/// 1; if it is larger, the flight states its errors too small.
struct SigmaScore {
  std::size_t components = 0;  ///< three per sample
  std::size_t within_one = 0, within_two = 0;
  double squared_sum = 0;              ///< of error / sigma
  std::map<std::int64_t, Vec3> error;  ///< e by keyframe, strip axes and unit

  void add(const SigmaScore& other);
  /// NaN where nothing was compared.
  [[nodiscard]] double share_within_one() const;
  [[nodiscard]] double share_within_two() const;
  [[nodiscard]] double normalised_error_squared() const;
};

/// The first two samples must be the first two posed keyframes of the strip (StripTrack::from_the_start): nothing is
/// compared otherwise.
[[nodiscard]] SigmaScore score_sigmas(const StripTrack& track);

}  // namespace ilp::score
