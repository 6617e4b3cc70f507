// Interface of the flight's clock: mission time, processor time and waiting.
#pragma once

#include "fsw/base/time.hpp"

namespace ilp {

class Clock {
 public:
  Clock() = default;
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;

  /// Returns mission time, which never decreases.
  virtual TimeNs now() = 0;
  /// Waits until mission time `time`; returns at once if it has passed.
  virtual void sleep_until(TimeNs time) = 0;
  /// Returns the processor time used by this thread. It serves budgets and reports, never decisions.
  virtual TimeNs processor_time() = 0;

 protected:
  ~Clock() = default;
};

}  // namespace ilp
