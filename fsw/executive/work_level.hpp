// The level of work per keyframe, by rule: less work rather than late work. Pure: counts in, level out.
//
//   0 full --overload--> 1 fewer features --overload--> 2 coarser stereo as well
//          <--recovery--                   <--recovery--
//
// Minor frames are counted in windows of load_window_s. A window is overloaded when overruns took more than their share
// of it, or when it had no rest and more frames or keyframes wait than allowed. An overloaded window raises the level
// by one. The next windows_to_settle cannot raise it, since the keyframes at work keep the level that they were chosen
// under. recovery_windows in a row below half of every limit lower it by one. Any other window changes nothing.
#pragma once

#include <cstdint>

#include "cfg/mission.hpp"
#include "fsw/base/enumeration.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

inline constexpr std::uint8_t max_work_level = 2;
inline constexpr std::uint32_t windows_to_settle = 3;
/// A window had no rest if this share of its minor frames ended with work left over. Waiting for something other than
/// the processor, such as a calibration or room in the store, is no overload.
inline constexpr double busy_share = 0.9;

ILP_ENUMERATION(LoadReason, (0, none, ""), (1, overruns, "minor frames overran"),
                (2, frames, "frames wait for the overlap checker"), (3, keyframes, "keyframes wait for their richness"))

/// Inputs that wait for a component.
struct Backlog {
  std::int64_t frames = 0;     ///< wait for the overlap checker
  std::int64_t keyframes = 0;  ///< without richness, beyond those of an adjustment window
};

/// What the minor frames of one window showed.
struct LoadWindow {
  std::uint32_t frames = 0;
  std::uint32_t busy_frames = 0;  ///< frames that ended with work of the imaging chain left over
  TimeNs begin_ns = 0;
  TimeNs overrun_ns = 0;  ///< total time by which frames ended late
};

class WorkLevel {
 public:
  /// Takes the level of an earlier boot.
  void restore(std::uint8_t level) { level_ = level < max_work_level ? level : max_work_level; }
  /// Call it at the end of a window, at `now`. Returns the reason for a raised level, `none` otherwise; the level may
  /// have fallen.
  LoadReason judge(const LoadWindow& window, TimeNs now, const Backlog& backlog, const MissionParameters& mission);
  [[nodiscard]] std::uint8_t level() const { return level_; }

 private:
  std::uint8_t level_ = 0;
  std::uint32_t settling_ = 0;  ///< windows that may not raise the level
  std::uint32_t calm_ = 0;      ///< calm windows in a row
};

}  // namespace ilp
