#include <cerrno>
#include <ctime>

#include "hal/clock/real_clock.hpp"
#include "hal/clock/utc.hpp"
#include "hal/clock/virtual_clock.hpp"

namespace ilp {
namespace {

TimeNs read(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<TimeNs>(time.tv_sec) * ns_per_s + time.tv_nsec;
}

constexpr std::int64_t days_1958_to_1970 = 4383;
constexpr std::int64_t seconds_in_a_day = 86400;

}  // namespace

std::int64_t utc_now() {
  return read(CLOCK_REALTIME) + days_1958_to_1970 * seconds_in_a_day * ns_per_s;
}

TimeNs VirtualClock::processor_time() {
  return read(CLOCK_THREAD_CPUTIME_ID);
}

RealClock::RealClock(TimeNs start) : epoch_(read(CLOCK_MONOTONIC) - start) {}

void RealClock::set(TimeNs start) {
  epoch_ = read(CLOCK_MONOTONIC) - start;
}

TimeNs RealClock::now() {
  return read(CLOCK_MONOTONIC) - epoch_;
}

void RealClock::sleep_until(TimeNs time) {
  const TimeNs absolute = epoch_ + time;
  timespec until{};
  until.tv_sec = static_cast<time_t>(absolute / ns_per_s);
  until.tv_nsec = static_cast<long>(absolute % ns_per_s);
  // A signal may end the sleep early; a bounded number of them is survived.
  for (int i = 0; i < 100 && clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR; ++i) {
  }
}

TimeNs RealClock::processor_time() {
  return read(CLOCK_THREAD_CPUTIME_ID);
}

}  // namespace ilp
