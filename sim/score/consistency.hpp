// Whether the stated position sigmas are honest.
//
// The flight states a keyframe's sigma when it last adjusts it, relative to the cameras before the adjustment window,
// which it holds fixed (fsw/vision/multiview/sequence.hpp): what has accumulated before is not in it. So the error that
// is compared is relative too. With n samples and a window of w, sample i was last adjusted in the window that begins
// at sample b = min(i, n - w): the oldest camera of its own window, or a camera of the strip's last window, which
// becomes final as a whole (a strip that was cut short has none: b = i). The truth is laid onto the strip at the
// samples before b, up to w of them:
//   rotation  the mean attitude difference of those samples (align_attitudes),
//   scale     the least-squares one of their positions under this rotation,
//   origin    sample b - 1;
// the error is then e_i = (c_i - c_{b-1}) - s W (C_i - C_{b-1}), along the strip's axes and in its unit, like sigma.
// Samples with b < 2 have no scale to compare with, sigmas of 0 state nothing: both are left out.
#pragma once

#include <map>

#include "sim/score/pose_score.hpp"

namespace ilp::score {

/// Of normal errors with exact sigmas 68.3 % are within one and 95.4 % within two, and the normalised error squared is
/// 1; larger means that the flight believes too much in itself.
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

[[nodiscard]] SigmaScore score_sigmas(const StripTrack& track);

}  // namespace ilp::score
