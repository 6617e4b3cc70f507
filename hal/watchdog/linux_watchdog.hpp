// The watchdog of a Linux board through the kernel's watchdog API (Documentation/watchdog/watchdog-api.rst).
#pragma once

#include <cstddef>

#include "cfg/limits.hpp"
#include "hal/watchdog/watchdog.hpp"

namespace ilp {

struct WatchdogOptions {
  char device[limits::max_path_bytes] = {};
  int timeout_s = 30;
};

/// Parses DEVICE or DEVICE:SECONDS. Returns false if the seconds are not a number from 1 to 86400, or the device's path
/// is empty or too long.
[[nodiscard]] bool parse_watchdog(const char* text, WatchdogOptions& options);

/// The system calls of the watchdog, which tests replace. They return -1 and set errno on failure.
struct WatchdogCalls {
  int (*open)(const char* path);
  int (*control)(int file, unsigned long request, int* value);
  std::ptrdiff_t (*write)(int file, const void* bytes, std::size_t size);
  int (*close)(int file);
};
[[nodiscard]] const WatchdogCalls& kernel_watchdog_calls();

class LinuxWatchdog final : public Watchdog {
 public:
  explicit LinuxWatchdog(const WatchdogCalls& calls = kernel_watchdog_calls()) : calls_(calls) {}
  /// Leaves the watchdog armed, because a program that ends without stop() has failed.
  ~LinuxWatchdog();

  /// Opens and thereby arms the watchdog. Returns `watchdog_refused` (first value: errno, second: timeout in s) if
  /// there is no device, another process holds it, or it refuses the timeout. After a refused timeout the watchdog
  /// stays armed with the driver's own timeout and must be kicked, because a driver may not allow disarming.
  Status open(const WatchdogOptions& options);

  Status kick() override;
  void stop() override;
  [[nodiscard]] bool bitten() const override { return bitten_; }
  /// Timeout that the driver reports, s; 0: not reported.
  [[nodiscard]] int timeout_s() const { return timeout_s_; }

 private:
  const WatchdogCalls& calls_;
  int file_ = -1;
  int timeout_s_ = 0;
  bool bitten_ = false;   ///< the watchdog caused the latest reset of the board
  bool failing_ = false;  ///< the latest kick() failed and was reported
};

}  // namespace ilp
