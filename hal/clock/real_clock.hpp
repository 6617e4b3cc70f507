// The monotonic clock of the board.
#pragma once

#include "hal/clock/clock.hpp"

namespace ilp {

class RealClock final : public Clock {
 public:
  /// Mission time is `start` now.
  explicit RealClock(TimeNs start = 0);
  /// Mission time is `start` from now on: for start-up.
  void set(TimeNs start);
  TimeNs now() override;
  /// What a monotonic time of the system needs to become mission time.
  [[nodiscard]] TimeNs mission_minus_monotonic() const { return -epoch_; }
  /// Absolute, so that the time spent before the call does not add up to drift.
  void sleep_until(TimeNs time) override;
  TimeNs processor_time() override;

 private:
  TimeNs epoch_;  ///< monotonic time at mission time 0
};

}  // namespace ilp
