// The latest fixes of a strip, and which of them count: a fix that is far from where the ones before it lead counts
// only if the next one agrees with it.
#pragma once

#include <cstdint>

#include "fsw/base/fixed_vector.hpp"
#include "fsw/records/words.hpp"
#include "fsw/vision/navigation/strip_frame.hpp"

namespace ilp {

inline constexpr std::size_t kept_fixes = 8;
inline constexpr double farthest_fix_sigmas = 4;   ///< from the prior
inline constexpr double agreeing_fixes_px = 3;     ///< two fixes by odometry, in working pixels
inline constexpr std::uint32_t most_rejected = 3;  ///< in a row: the place is lost

/// Trivially copyable: it is a part of the stage's state. Places are on the map's plane.
struct FixBook {
  std::int64_t strip_id = 0;
  FixedVector<navigation::MeasuredKeyframe, kept_fixes> fixes;  ///< in order; all of them count
  std::uint32_t has_unconfirmed = 0;
  std::uint32_t rejected = 0;  ///< fixes in a row that did not count
  navigation::MeasuredKeyframe unconfirmed;
};

/// What becomes of a new fix. `wants_second`: it counts only where another one agrees, because nothing led there, or it
/// is farther from the prior than that errs. `scratch` carries nothing.
[[nodiscard]] FixState judge_fix(const navigation::MeasuredKeyframe& fix, double pixel_m, bool wants_second,
                                 FixBook& book, navigation::MeasuredKeyframes& scratch);

/// The similarity by these fixes alone.
[[nodiscard]] navigation::StripFrame frame_by_fixes(const FixBook& book, navigation::MeasuredKeyframes& scratch);

/// Horizontal distance between the ground of `fix` and where `other` alone and the poses between lead, and its sigma,
/// m.
struct FixDistance {
  double metres = 0, sigma = 0;
};
[[nodiscard]] FixDistance distance_by_odometry(const navigation::MeasuredKeyframe& other,
                                               const navigation::MeasuredKeyframe& fix,
                                               navigation::MeasuredKeyframes& scratch);

}  // namespace ilp
