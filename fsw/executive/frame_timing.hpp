// How minor frames keep their time: counts, extremes and histograms, in integers.
#pragma once

#include <cstddef>

#include "cfg/schedule.hpp"
#include "fsw/records/records.hpp"

namespace ilp {

/// Bin of a histogram of TimingRecord; what is early counts as on time.
[[nodiscard]] std::size_t timing_bin(TimeNs time);

/// Counts one minor frame into `timing`: it began `late` behind its time and took `used`, both in ns.
void count_frame(TimeNs late, TimeNs used, bool overran, TimingRecord& timing);

/// Begin of the next minor frame on the grid of `nominal`: a frame that took the time of others leaves them out, so
/// that none begins more than a frame behind its time.
[[nodiscard]] constexpr TimeNs next_frame_begin(TimeNs nominal, TimeNs now) {
  const TimeNs next = nominal + minor_frame_ns;
  return now < next + minor_frame_ns ? next : next + (now - next) / minor_frame_ns * minor_frame_ns;
}

}  // namespace ilp
