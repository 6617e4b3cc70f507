#include "hal/watchdog/linux_watchdog.hpp"

#include <fcntl.h>
#include <linux/watchdog.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "fsw/base/argument.hpp"
#include "hal/posix/number.hpp"

namespace ilp {
namespace {

constexpr WatchdogCalls kernel_calls{
    [](const char* path) { return ::open(path, O_WRONLY | O_CLOEXEC); },
    [](int file, unsigned long request, int* value) { return ::ioctl(file, request, value); },
    [](int file, const void* bytes, std::size_t size) -> std::ptrdiff_t { return ::write(file, bytes, size); },
    [](int file) { return ::close(file); },
};

// Any other octet is a kick; this one before closing disarms the watchdog.
constexpr char magic_close = 'V';
constexpr char all_is_well = '\0';

Status refused(int timeout_s) {
  return {StatusCode::watchdog_refused, errno, timeout_s};
}

}  // namespace

const WatchdogCalls& kernel_watchdog_calls() {
  return kernel_calls;
}

bool parse_watchdog(const char* text, WatchdogOptions& options) {
  constexpr std::int64_t longest_s = 86400;
  const char* const colon = std::strrchr(text, ':');
  const std::size_t length = colon != nullptr ? static_cast<std::size_t>(colon - text) : std::strlen(text);
  if (length == 0 || length >= sizeof(options.device)) return false;
  if (colon != nullptr) {
    const char* digits = colon + 1;
    std::int64_t seconds = 0;
    if (!read_digits(digits, 5, seconds) || *digits != '\0' || seconds < 1 || seconds > longest_s) return false;
    options.timeout_s = static_cast<int>(seconds);
  }
  std::memcpy(options.device, text, length);
  options.device[length] = '\0';
  return true;
}

LinuxWatchdog::~LinuxWatchdog() {
  if (file_ >= 0) calls_.close(file_);
}

Status LinuxWatchdog::open(const WatchdogOptions& options) {
  if (file_ >= 0) return out_of_range(Argument::watchdog);
  file_ = calls_.open(options.device);
  if (file_ < 0) return refused(options.timeout_s);
  int boot_status = 0;
  // Not every driver knows; without its answer the board's own report counts.
  if (calls_.control(file_, WDIOC_GETBOOTSTATUS, &boot_status) == 0) bitten_ = (boot_status & WDIOF_CARDRESET) != 0;
  int timeout = options.timeout_s;
  const bool taken = calls_.control(file_, WDIOC_SETTIMEOUT, &timeout) == 0;
  const Status status = taken ? Status{} : refused(options.timeout_s);
  // A driver may round it: the value that it returns is in force.
  if (calls_.control(file_, WDIOC_GETTIMEOUT, &timeout) == 0) timeout_s_ = timeout;
  return status;
}

Status LinuxWatchdog::kick() {
  if (file_ < 0) return {};
  if (calls_.write(file_, &all_is_well, 1) == 1) {
    failing_ = false;
    return {};
  }
  if (failing_) return {};
  failing_ = true;
  return refused(timeout_s_);
}

void LinuxWatchdog::stop() {
  if (file_ < 0) return;
  // If it cannot be disarmed it resets the board after its timeout, and nothing more can be done here.
  static_cast<void>(calls_.write(file_, &magic_close, 1));
  calls_.close(file_);
  file_ = -1;
}

}  // namespace ilp
