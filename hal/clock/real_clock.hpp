// The monotonic clock of the board.
#pragma once

#include "hal/clock/clock.hpp"

namespace ilp {

class RealClock final : public Clock {
 public:
  /// Sets mission time to `start` now.
  explicit RealClock(TimeNs start = 0);
  /// Sets mission time to `start`, for start-up.
  void set(TimeNs start);
  TimeNs now() override;
  /// The offset from the system's monotonic time to mission time.
  [[nodiscard]] TimeNs mission_minus_monotonic() const { return -epoch_; }
  /// Takes an absolute time, so that the time spent before the call does not accumulate as drift.
  void sleep_until(TimeNs time) override;
  TimeNs processor_time() override;

 private:
  TimeNs epoch_;  ///< monotonic time at mission time 0
};

}  // namespace ilp
