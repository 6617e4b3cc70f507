// Interface of the board's watchdog, which resets the board if it is not kicked within its timeout.
#pragma once

#include "fsw/base/status.hpp"

namespace ilp {

class Watchdog {
 public:
  Watchdog() = default;
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// Restarts the timeout. Call it once per minor frame, after the frame's work. Every call tries again after a
  /// failure, but only the first failure in a row is returned, as `watchdog_refused`.
  virtual Status kick() = 0;
  /// Disarms the watchdog, for an ordered end of the software.
  virtual void stop() = 0;
  /// Whether the watchdog reset the board before this start.
  [[nodiscard]] virtual bool bitten() const = 0;

 protected:
  ~Watchdog() = default;
};

/// For boards without a watchdog.
class NullWatchdog final : public Watchdog {
 public:
  Status kick() override { return {}; }
  void stop() override {}
  [[nodiscard]] bool bitten() const override { return false; }
};

}  // namespace ilp
