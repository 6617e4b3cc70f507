#include "fsw/executive/work_level.hpp"

#include <algorithm>

namespace ilp {
namespace {

/// The limit, times `scale`, that the window exceeds.
LoadReason exceeded(const LoadWindow& window, TimeNs length, const Backlog& backlog, const MissionParameters& mission,
                    double scale) {
  const double overrun_share =
      static_cast<double>(window.overrun_ns) / static_cast<double>(std::max<TimeNs>(length, 1));
  if (overrun_share >= scale * mission.overload_overruns) return LoadReason::overruns;
  if (window.busy_frames < busy_share * window.frames) return LoadReason::none;
  if (static_cast<double>(backlog.frames) >= scale * mission.overload_frames) return LoadReason::frames;
  if (static_cast<double>(backlog.keyframes) >= scale * mission.overload_keyframes) return LoadReason::keyframes;
  return LoadReason::none;
}

}  // namespace

LoadReason WorkLevel::judge(const LoadWindow& window, TimeNs now, const Backlog& backlog,
                            const MissionParameters& mission) {
  if (!mission.degraded_modes) {
    level_ = 0;
    calm_ = settling_ = 0;
    return LoadReason::none;
  }
  const TimeNs length = now - window.begin_ns;
  const LoadReason reason = exceeded(window, length, backlog, mission, 1);
  const bool settling = settling_ > 0;
  if (settling) --settling_;
  if (reason != LoadReason::none) {
    calm_ = 0;
    if (settling || level_ == max_work_level) return LoadReason::none;
    ++level_;
    settling_ = windows_to_settle;
    return reason;
  }
  const bool calm = exceeded(window, length, backlog, mission, 0.5) == LoadReason::none;
  calm_ = calm && level_ > 0 ? calm_ + 1 : 0;
  if (calm_ >= mission.recovery_windows) {
    --level_;
    calm_ = 0;
  }
  return LoadReason::none;
}

}  // namespace ilp
