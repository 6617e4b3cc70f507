// The keyframe that another one is matched with: the one of the next few of its strip that promises most.
#pragma once

#include "fsw/base/result.hpp"
#include "fsw/records/records.hpp"
#include "fsw/vision/stereo/depth/pose_error.hpp"
#include "fsw/vision/terrain/pair_utility.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

struct Partner {
  PoseRecord pose;
  StepCovariance step;           ///< of the step to it from the keyframe that it is matched with
  bool at_end = false;           ///< the choice has found the end of the strip
  std::int32_t finer_steps = 0;  ///< by which known ground must be seen finer to be claimed again
};

/// Where a strip ends nothing finer will follow: one level of sampling is enough for its last keyframes, if the choice
/// of their partner has looked as far as the end.
inline constexpr std::int32_t finer_steps_at_end = 1;

/// A partner whose step is that from the keyframe before it.
[[nodiscard]] Partner partner_of(const PoseRecord& next, std::int32_t finer_steps);

enum class Successor : std::uint8_t {
  none,  ///< no further keyframe of the strip has a pose
  final,
  not_yet  ///< it is not known yet, or its pose may still change
};

/// The first keyframe after `after_id` that belongs to the same strip as `pose` and has one. Keyframes whose pose
/// failed or whose record is damaged are passed over. The loop is bounded by the keyframes of the strip that failed in
/// a row.
Result<Successor> next_with_pose(Reader<PoseRecord, StripRecord> store, const PoseRecord& pose, std::int64_t after_id,
                                 PoseRecord& successor);

/// Chooses among the keyframe `next`, which follows `pose`, and those after it. The next one is taken at once
/// if its median sigma is at most an eighth of the largest one, as in level flight. Otherwise the choice waits until
/// the poses of `reach` following keyframes are final or the strip has ended, and the pair with the greatest worth is
/// taken, the nearer one of equal ones. The answer is `final`, or `not_yet` while it waits.
Result<Successor> choose_partner(Reader<PoseRecord, StripRecord> store, const CameraModel& camera,
                                 const PoseRecord& pose, const PoseRecord& next, const Coverage& coverage,
                                 const PairUtilityParams& params, std::uint32_t reach, Partner& partner);

}  // namespace ilp
