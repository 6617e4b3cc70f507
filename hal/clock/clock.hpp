// Mission time and processor time.
#pragma once

#include "fsw/base/time.hpp"

namespace ilp {

class Clock {
 public:
  Clock() = default;
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;

  /// Monotonic mission time.
  virtual TimeNs now() = 0;
  virtual void sleep_until(TimeNs time) = 0;
  /// Processor time used by this thread, for budgets and reports, never for decisions.
  virtual TimeNs processor_time() = 0;

 protected:
  ~Clock() = default;
};

}  // namespace ilp
