// The board's watchdog, which resets the board when it was not kicked within its timeout.
#pragma once

#include "fsw/base/status.hpp"

namespace ilp {

class Watchdog {
 public:
  Watchdog() = default;
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// Resets the timeout: call it once per minor frame, after the frame's work. A failure is reported once, and every
  /// call tries again.
  virtual Status kick() = 0;
  /// Disarms it, for an ordered end.
  virtual void stop() = 0;
  /// Whether it reset the board before this start.
  [[nodiscard]] virtual bool bitten() const = 0;

 protected:
  ~Watchdog() = default;
};

/// For boards without one.
class NullWatchdog final : public Watchdog {
 public:
  Status kick() override { return {}; }
  void stop() override {}
  [[nodiscard]] bool bitten() const override { return false; }
};

}  // namespace ilp
