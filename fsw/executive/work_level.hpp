// Decides the work level, which reduces the work per keyframe under overload. The level depends only on counts of minor
// frames and backlogs.
//
//   0 full --overload--> 1 fewer features --overload--> 2 coarser stereo as well
//          <--recovery--                   <--recovery--
//
// Minor frames are counted in windows of load_window_s. A window is overloaded if overruns took a share of it of at
// least overload_overruns, or if it was busy (busy_share) and at least overload_frames frames or overload_keyframes
// keyframes wait. An overloaded window raises the level by one. The next windows_to_settle windows cannot raise it,
// because the keyframes in work keep the level at which they were chosen. recovery_windows windows in a row below half
// of every limit lower the level by one.
#pragma once

#include <cstdint>

#include "cfg/mission.hpp"
#include "fsw/base/enumeration.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

inline constexpr std::uint8_t max_work_level = 2;
inline constexpr std::uint32_t windows_to_settle = 3;
/// A window is busy if at least this share of its minor frames ended with work left over. Backlogs without work for the
/// processor, such as those that wait for a calibration or for free space in the store, are no overload.
inline constexpr double busy_share = 0.9;

ILP_ENUMERATION(LoadReason, (0, none, ""), (1, overruns, "minor frames overran"),
                (2, frames, "frames wait for the overlap checker"), (3, keyframes, "keyframes wait for their richness"))

/// Inputs that wait for a component.
struct Backlog {
  std::int64_t frames = 0;     ///< wait for the overlap checker
  std::int64_t keyframes = 0;  ///< keyframes without richness, less the length of an adjustment window
};

/// Counts of the minor frames of one window.
struct LoadWindow {
  std::uint32_t frames = 0;
  std::uint32_t busy_frames = 0;  ///< frames that ended with work of the imaging chain left over
  TimeNs begin_ns = 0;
  TimeNs overrun_ns = 0;  ///< total time by which frames ended late
};

class WorkLevel {
 public:
  /// Sets the level to that of an earlier boot.
  void restore(std::uint8_t level) { level_ = level < max_work_level ? level : max_work_level; }
  /// Call it at the end of a window, at `now`. Returns the reason if the level was raised, otherwise `none`, even if
  /// the level was lowered.
  LoadReason judge(const LoadWindow& window, TimeNs now, const Backlog& backlog, const MissionParameters& mission);
  [[nodiscard]] std::uint8_t level() const { return level_; }

 private:
  std::uint8_t level_ = 0;
  std::uint32_t settling_ = 0;  ///< number of the next windows that may not raise the level
  std::uint32_t calm_ = 0;      ///< windows in a row below half of every limit
};

}  // namespace ilp
