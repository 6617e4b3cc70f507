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

/// Parses DEVICE or DEVICE:SECONDS. Returns false for other text, or if the seconds are not 1 to 86400.
[[nodiscard]] bool parse_watchdog(const char* text, WatchdogOptions& options);

/// The kernel calls of the watchdog; a test replaces them. As in POSIX: -1 and errno on failure.
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
  /// Leaves it armed: a program that ends without stop() has died.
  ~LinuxWatchdog();

  /// Opening arms it. `watchdog_refused` (a = errno, b = timeout in s): there is none, another process holds it, or it
  /// does not take the timeout. In the last case it stays armed with the driver's own timeout and must be kicked,
  /// because a driver may not allow disarming.
  Status open(const WatchdogOptions& options);

  Status kick() override;
  void stop() override;
  [[nodiscard]] bool bitten() const override { return bitten_; }
  /// Timeout in force, s; 0 when none is known.
  [[nodiscard]] int timeout_s() const { return timeout_s_; }

 private:
  const WatchdogCalls& calls_;
  int file_ = -1;
  int timeout_s_ = 0;
  bool bitten_ = false;
  bool failing_ = false;
};

}  // namespace ilp
