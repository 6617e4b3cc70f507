// Timing statistics of minor frames: counts, extremes and histograms, in integers.
#pragma once

#include <cstddef>

#include "cfg/schedule.hpp"
#include "fsw/records/records.hpp"

namespace ilp {

/// Index of the bin for a time in the histograms of TimingRecord: powers of two of a microsecond. Negative times are in
/// bin 0.
[[nodiscard]] std::size_t timing_bin(TimeNs time);

/// Counts one minor frame into `timing`: it began `late` after its nominal time and took `used`, both in ns.
void count_frame(TimeNs late, TimeNs used, bool overran, TimingRecord& timing);

/// Nominal begin of the minor frame that follows the one of `nominal`, at time `now`. Frames whose time has passed are
/// skipped, so that no frame begins more than one frame late.
[[nodiscard]] constexpr TimeNs next_frame_begin(TimeNs nominal, TimeNs now) {
  const TimeNs next = nominal + minor_frame_ns;
  return now < next + minor_frame_ns ? next : next + (now - next) / minor_frame_ns * minor_frame_ns;
}

}  // namespace ilp
