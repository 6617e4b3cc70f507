// Kicks the watchdogs of a flight during long work on its disk.
#pragma once

#include <cstdio>

#include "bsp/flight/flight_store.hpp"
#include "bsp/linux/status_line.hpp"
#include "hal/clock/clock.hpp"
#include "hal/watchdog/linux_watchdog.hpp"
#include "hal/watchdog/service_watchdog.hpp"

namespace ilp {

/// Kicks the board's watchdog and that of the service manager at each callback of DiskWait.
class WatchedWait final : public DiskWait {
 public:
  WatchedWait(Watchdog& watchdog, ServiceWatchdog& manager, Clock& clock)
      : watchdog_(watchdog), manager_(manager), clock_(clock) {}

  /// Call it at the beginning of a start. The watchdog may still run from the previous process; it is opened, and so
  /// kicked, at the first callback.
  void begin_start(LinuxWatchdog& watchdog, const WatchdogOptions& options) {
    starting_ = &watchdog;
    options_ = &options;
  }
  /// Disarms the watchdog, because the rest of a start may take longer than its timeout.
  void end_start() {
    disarm();
    starting_ = nullptr;
  }

  void until_next_attempt(int attempts, const Status& fault) override {
    if (attempts == 1) {
      print_status("the database", fault);
      std::fprintf(stderr, "ilp-onboard: the disk is tried for %d s before the flight has its store in memory\n",
                   start_attempts - 1);
    }
    at_work();
    clock_.sleep_until(clock_.now() + ns_per_s);
    // A check of the database takes its time.
    disarm();
  }
  void at_work() override {
    if (starting_ != nullptr && !armed_) {
      armed_ = true;
      static_cast<void>(starting_->open(*options_));
    }
    static_cast<void>(watchdog_.kick());
    static_cast<void>(manager_.kick(clock_.now()));
  }

 private:
  void disarm() {
    if (armed_) starting_->stop();
    armed_ = false;
  }

  Watchdog& watchdog_;
  ServiceWatchdog& manager_;
  Clock& clock_;
  LinuxWatchdog* starting_ = nullptr;
  const WatchdogOptions* options_ = nullptr;
  bool armed_ = false;
};

}  // namespace ilp
