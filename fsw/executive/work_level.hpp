// How much work a keyframe gets, by rule: less rather than late. Pure: counts in, level out.
//
//   0 full --overload--> 1 fewer features --overload--> 2 coarser stereo as well
//          <--recovery--                   <--recovery--
//
// Minor frames are counted in windows of load_window_s. A window is overloaded when overruns took more than their share
// of it, or when it had no rest and frames or keyframes wait in larger numbers than allowed. An overloaded window
// raises the level by one; then the next settle_windows cannot, since the keyframes on their way keep the level that
// they were chosen under. recovery_windows in a row below half of every limit lower it by one. What lies between
// changes nothing.
#pragma once

#include <cstdint>

#include "cfg/mission.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

inline constexpr std::uint8_t max_work_level = 2;
inline constexpr std::uint32_t settle_windows = 3;
/// Of the minor frames of a window that ended with work left over: it had no rest. Waiting for something else than the
/// processor, such as a calibration or room in the store, is no overload.
inline constexpr double busy_share = 0.9;

enum class LoadReason : std::uint8_t { none, overruns, frames, keyframes };

/// Inputs that nobody has worked on yet.
struct Backlog {
  std::int64_t frames = 0;     ///< wait for the overlap checker
  std::int64_t keyframes = 0;  ///< without richness, beyond those of an adjustment window
};

/// What the minor frames of one window showed.
struct LoadWindow {
  std::uint32_t frames = 0;
  std::uint32_t busy_frames = 0;  ///< that ended with work of the imaging chain left over
  TimeNs begin_ns = 0;
  TimeNs overrun_ns = 0;  ///< by which frames ended late, in all
};

class WorkLevel {
 public:
  /// Goes on at the level of an earlier life.
  void restore(std::uint8_t level) { level_ = level < max_work_level ? level : max_work_level; }
  /// At the end of a window at `now`. Says what had it raised; `none` when it was not. level() may have fallen.
  LoadReason judge(const LoadWindow& window, TimeNs now, const Backlog& backlog, const MissionParameters& mission);
  [[nodiscard]] std::uint8_t level() const { return level_; }

 private:
  std::uint8_t level_ = 0;
  std::uint32_t settling_ = 0;  ///< windows that may not raise it
  std::uint32_t calm_ = 0;      ///< windows in a row
};

}  // namespace ilp
