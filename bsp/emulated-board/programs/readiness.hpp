// Functions for programs of the board: reporting that a program is ready (`with` in /flight/run), and the board's time.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <ctime>

namespace board {

/// The descriptor on which init waits for a byte.
inline constexpr int ready_descriptor = 3;

/// Reports to init that the program is ready.
inline void say_ready() {
  if (write(ready_descriptor, "r", 1) == 1) close(ready_descriptor);
}

/// Time since the board has started, s.
inline double uptime_s() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Waits until uptime_s() reaches `uptime`, s.
inline void sleep_until(double uptime) {
  timespec until{};
  until.tv_sec = static_cast<time_t>(uptime);
  until.tv_nsec = static_cast<long>((uptime - static_cast<double>(until.tv_sec)) * 1e9);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace board
