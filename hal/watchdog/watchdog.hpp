// The board's watchdog: resets the board when nobody has told it for its timeout that all is well.
#pragma once

#include "fsw/base/status.hpp"

namespace ilp {

class Watchdog {
 public:
  Watchdog() = default;
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// Tells it that all is well: once per minor frame, behind its end. A failure is told once; it is tried again
  /// each time.
  virtual Status kick() = 0;
  /// Disarms it, for an ordered end.
  virtual void stop() = 0;
  /// Did it reset the board before this start?
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
