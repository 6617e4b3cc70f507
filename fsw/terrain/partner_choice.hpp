// Chooses the keyframe with which another one is matched by dense stereo: the best of the next few in its strip.
#pragma once

#include "fsw/base/result.hpp"
#include "fsw/records/records.hpp"
#include "fsw/vision/stereo/depth/pose_error.hpp"
#include "fsw/vision/terrain/pair_utility.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

struct Partner {
  PoseRecord pose;
  StepCovariance step;           ///< covariance of the step from the keyframe to the partner
  bool at_end = false;           ///< the choice has reached the end of the strip
  std::int32_t finer_steps = 0;  ///< levels of sampling by which known ground must be seen finer to be claimed again
};

/// finer_steps for the last keyframes of a strip, if the choice of their partner has reached the end: one level is
/// enough, because no finer view will follow.
inline constexpr std::int32_t finer_steps_at_end = 1;

/// The next keyframe as partner. The covariance of the step is that of its own pose record.
[[nodiscard]] Partner partner_of(const PoseRecord& next, std::int32_t finer_steps);

enum class Successor : std::uint8_t {
  none,    ///< no further keyframe of the strip has a pose
  final,   ///< found, with a final pose
  not_yet  ///< it is not known yet, or its pose may still change
};

/// Finds the first keyframe after `after_id` in the strip of `pose` that has a pose. Keyframes with a failed pose or a
/// damaged record are skipped. The loop is bounded by the keyframes of the strip that failed in a row.
Result<Successor> next_with_pose(Reader<PoseRecord, StripRecord> store, const PoseRecord& pose, std::int64_t after_id,
                                 PoseRecord& successor);

/// Chooses the partner of `pose`: the keyframe `next`, which follows it, or one of those after `next`. `next` is taken
/// at once if its median depth sigma is at most an eighth of the largest allowed one, as in level flight. Otherwise the
/// choice waits until the poses of `reach` following keyframes are final or the strip has ended, and takes the pair
/// with the largest utility; of equal pairs, the nearer one. Returns `final`, or `not_yet` while it waits.
Result<Successor> choose_partner(Reader<PoseRecord, StripRecord> store, const CameraModel& camera,
                                 const PoseRecord& pose, const PoseRecord& next, const Coverage& coverage,
                                 const PairUtilityParams& params, std::uint32_t reach, Partner& partner);

}  // namespace ilp
