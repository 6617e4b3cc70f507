// Clocks that a test sets.
#pragma once

#include "hal/clock/clock.hpp"

namespace ilp::test {

class FakeClock final : public Clock {
 public:
  TimeNs now() override { return now_; }
  void sleep_until(TimeNs time) override {
    if (time > now_) now_ = time;
  }
  TimeNs processor_time() override { return now_; }
  void set(TimeNs time) { now_ = time; }
  void pass(TimeNs time) { now_ += time; }

 private:
  TimeNs now_ = 0;
};

/// Takes no processor's time.
class StillClock final : public Clock {
 public:
  TimeNs now() override { return now_; }
  void sleep_until(TimeNs time) override {
    if (time > now_) now_ = time;
  }
  TimeNs processor_time() override { return 0; }
  /// Any time, also an earlier one.
  void set(TimeNs time) { now_ = time; }

 private:
  TimeNs now_ = 0;
};

}  // namespace ilp::test
