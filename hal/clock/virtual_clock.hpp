// A clock for software in the loop: mission time advances only in sleep_until().
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
