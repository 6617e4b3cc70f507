// The latest fixes of a strip, and the decision which fixes are accepted: a fix that is far from its prior is accepted
// only if the next fix agrees with it.
#pragma once

#include <cstdint>

#include "fsw/base/fixed_vector.hpp"
#include "fsw/records/words.hpp"
#include "fsw/vision/navigation/strip_frame.hpp"

namespace ilp {

inline constexpr std::size_t kept_fixes = 8;
inline constexpr double farthest_fix_sigmas = 4;   ///< most distance from the prior without a confirmation
inline constexpr double agreeing_fixes_px = 3;     ///< distance by odometry within which two fixes agree, working px
inline constexpr std::uint32_t most_rejected = 3;  ///< rejected fixes in a row after which the position is lost

/// Trivially copyable, because it is a part of the stage's state. Positions are on the map's plane.
struct FixBook {
  std::int64_t strip_id = 0;
  FixedVector<navigation::MeasuredKeyframe, kept_fixes> fixes;  ///< accepted fixes, in order
  std::uint32_t has_unconfirmed = 0;                            ///< 1: `unconfirmed` is valid
  std::uint32_t rejected = 0;                                   ///< fixes in a row that were not accepted
  navigation::MeasuredKeyframe unconfirmed;
};

/// Decides on a new fix and adds it to the book if it is accepted. With `wants_second` it is accepted only if the fix
/// before agrees, because there was no prior or the fix is farther from the prior than the prior's error allows.
/// `pixel_m` is the working pixel.
[[nodiscard]] FixState judge_fix(const navigation::MeasuredKeyframe& fix, double pixel_m, bool wants_second,
                                 FixBook& book, navigation::MeasuredKeyframes& scratch);

/// The strip frame that is estimated from the accepted fixes alone.
[[nodiscard]] navigation::StripFrame frame_by_fixes(const FixBook& book, navigation::MeasuredKeyframes& scratch);

/// Horizontal distance, m, between the ground of `fix` and its prediction from `other` and the poses of both, with the
/// standard deviation.
struct FixDistance {
  double metres = 0, sigma = 0;
};
[[nodiscard]] FixDistance distance_by_odometry(const navigation::MeasuredKeyframe& other,
                                               const navigation::MeasuredKeyframe& fix,
                                               navigation::MeasuredKeyframes& scratch);

}  // namespace ilp
