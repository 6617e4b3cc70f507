// Mission time from the monotonic clock of the board.
#pragma once

#include "hal/clock/clock.hpp"

namespace ilp {

class RealClock final : public Clock {
 public:
  /// Mission time is `start` at the time of the call.
  explicit RealClock(TimeNs start = 0);
  /// Sets mission time to `start`. Only for start-up, because mission time may decrease.
  void set(TimeNs start);
  TimeNs now() override;
  /// Mission time minus the system's monotonic time, constant between two calls of set().
  [[nodiscard]] TimeNs mission_minus_monotonic() const { return -epoch_; }
  /// Waits for an absolute time, so that time spent before the call does not accumulate as drift.
  void sleep_until(TimeNs time) override;
  TimeNs processor_time() override;

 private:
  TimeNs epoch_;  ///< monotonic time at mission time 0
};

}  // namespace ilp
