#include "fsw/executive/frame_timing.hpp"

#include <algorithm>
#include <bit>

namespace ilp {

std::size_t timing_bin(TimeNs time) {
  const auto us = static_cast<std::uint64_t>(std::max<TimeNs>(time, 0) / ns_per_us);
  return std::min<std::size_t>(static_cast<std::size_t>(std::bit_width(us)), limits::timing_bins - 1);
}

void count_frame(TimeNs late, TimeNs used, bool overran, TimingRecord& timing) {
  ++timing.frames;
  timing.overruns += overran ? 1 : 0;
  timing.longest_ns = std::max(timing.longest_ns, used);
  timing.latest_ns = std::max(timing.latest_ns, late);
  ++timing.late[timing_bin(late)];
  ++timing.used[timing_bin(used)];
}

}  // namespace ilp
