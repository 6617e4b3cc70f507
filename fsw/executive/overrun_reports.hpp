// Overruns in every minor frame must not flood the event table: the first is told, then how many came after it.
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

/// Asked in every minor frame; answers with the event that is due, if any.
class OverrunReports {
 public:
  static constexpr TimeNs interval_ns = 60 * ns_per_s;  ///< between two events, at least

  /// `over` is by how much the frame ended late, in ns; not positive: it did not.
  [[nodiscard]] Status note(std::int64_t frame, TimeNs over, TimeNs now) {
    if (over > 0) {
      if (!open_) {
        open_ = true;
        told_ns_ = now;
        return {StatusCode::frame_overrun, frame, over / ns_per_us};
      }
      ++untold_;
      if (over > worst_ns_) worst_ns_ = over;
    }
    if (!open_ || now - told_ns_ < interval_ns) return {};
    // A quiet interval: the next overrun is news again.
    open_ = untold_ != 0;
    const Status told = open_ ? Status{StatusCode::frames_overran, untold_, worst_ns_ / ns_per_us} : Status{};
    told_ns_ = now;
    untold_ = 0;
    worst_ns_ = 0;
    return told;
  }

 private:
  bool open_ = false;
  TimeNs told_ns_ = 0;
  std::int64_t untold_ = 0;
  TimeNs worst_ns_ = 0;
};

}  // namespace ilp
