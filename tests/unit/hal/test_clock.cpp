// Mission time, real and virtual.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "hal/clock/real_clock.hpp"
#include "hal/clock/virtual_clock.hpp"

namespace ilp {
namespace {

TEST(VirtualClock, PassesOnlyWhenAsked) {
  VirtualClock clock(50);
  EXPECT_EQ(clock.now(), 50);
  EXPECT_EQ(clock.now(), 50);
  clock.sleep_until(ns_per_s);
  EXPECT_EQ(clock.now(), ns_per_s);
  clock.sleep_until(10);
  EXPECT_EQ(clock.now(), ns_per_s) << "time never goes back";
}

TEST(RealClock, StartsWhereItIsToldAndKeepsPaceWithTheHost) {
  const auto host_begin = std::chrono::steady_clock::now();
  RealClock clock(5 * ns_per_s);
  const TimeNs begin = clock.now();
  EXPECT_GE(begin, 5 * ns_per_s);
  clock.sleep_until(begin + 20 * ns_per_ms);
  const TimeNs end = clock.now();
  const auto host_end = std::chrono::steady_clock::now();
  EXPECT_GE(end, begin + 20 * ns_per_ms) << "woke up too early";
  const TimeNs host = std::chrono::duration_cast<std::chrono::nanoseconds>(host_end - host_begin).count();
  EXPECT_LE(end - begin, host);
}

TEST(RealClock, DoesNotSleepUntilWhatIsPast) {
  RealClock clock;
  clock.sleep_until(0);
  clock.sleep_until(-1);
  clock.sleep_until(-3'000'000'000'000'000'000);
  EXPECT_GE(clock.now(), 0);
}

TEST(Clocks, ProcessorTimeIsThatOfWorkNotOfSleep) {
  RealClock real;
  VirtualClock virtual_clock;
  for (Clock* clock : {static_cast<Clock*>(&real), static_cast<Clock*>(&virtual_clock)}) {
    const TimeNs begin = clock->processor_time();
    real.sleep_until(real.now() + 30 * ns_per_ms);
    const TimeNs slept = clock->processor_time();
    EXPECT_LT(slept - begin, 20 * ns_per_ms);
    volatile double work = 0;
    for (int i = 0; i < 3'000'000; ++i) work = work + std::sqrt(i);
    EXPECT_GT(clock->processor_time(), slept + ns_per_ms);
  }
}

}  // namespace
}  // namespace ilp
