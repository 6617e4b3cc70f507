// A clock that only the caller advances, for software in the loop.
#pragma once

#include "hal/clock/clock.hpp"

namespace ilp {

class VirtualClock final : public Clock {
 public:
  explicit VirtualClock(TimeNs start = 0) : now_(start) {}
  TimeNs now() override { return now_; }
  void sleep_until(TimeNs time) override {
    if (time > now_) now_ = time;
  }
  TimeNs processor_time() override;

 private:
  TimeNs now_;
};

}  // namespace ilp
