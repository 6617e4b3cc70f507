// Timing statistics of minor frames: counts, extremes and histograms, in integers.
#pragma once

#include <cstddef>

#include "cfg/schedule.hpp"
#include "fsw/records/records.hpp"

namespace ilp {

/// Bin of a histogram of TimingRecord. A negative time (early) counts as on time.
[[nodiscard]] std::size_t timing_bin(TimeNs time);

/// Counts one minor frame into `timing`: it began `late` after its nominal time and took `used`, both in ns.
void count_frame(TimeNs late, TimeNs used, bool overran, TimingRecord& timing);

/// Begin of the next minor frame on the grid of `nominal`. Frames whose time has passed are skipped, so that no frame
/// begins more than one frame late.
[[nodiscard]] constexpr TimeNs next_frame_begin(TimeNs nominal, TimeNs now) {
  const TimeNs next = nominal + minor_frame_ns;
  return now < next + minor_frame_ns ? next : next + (now - next) / minor_frame_ns * minor_frame_ns;
}

}  // namespace ilp
