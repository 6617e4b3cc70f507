// Limits the reports of overruns, which could flood the event table: the first overrun is reported, then the number of
// further ones.
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

/// Call note() in every minor frame: it returns the event that is due, or ok.
class OverrunReports {
 public:
  static constexpr TimeNs interval_ns = 60 * ns_per_s;  ///< shortest time between two events

  /// `over` is the time in ns by which the frame ended late. It is an overrun if it is positive.
  [[nodiscard]] Status note(std::int64_t frame, TimeNs over, TimeNs now) {
    if (over > 0) {
      if (!open_) {
        open_ = true;
        reported_ns_ = now;
        return {StatusCode::frame_overrun, frame, over / ns_per_us};
      }
      ++untold_;
      if (over > worst_ns_) worst_ns_ = over;
    }
    if (!open_ || now - reported_ns_ < interval_ns) return {};
    // After a quiet interval the next overrun is reported at once.
    open_ = untold_ != 0;
    const Status reported = open_ ? Status{StatusCode::frames_overran, untold_, worst_ns_ / ns_per_us} : Status{};
    reported_ns_ = now;
    untold_ = 0;
    worst_ns_ = 0;
    return reported;
  }

 private:
  bool open_ = false;
  TimeNs reported_ns_ = 0;
  std::int64_t untold_ = 0;
  TimeNs worst_ns_ = 0;
};

}  // namespace ilp
