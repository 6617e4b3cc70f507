#include "bsp/flight/self_test.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "fsw/base/heap_gate.hpp"
#include "hal/clock/virtual_clock.hpp"
#include "hal/store/ram/ram_store.hpp"

namespace ilp {
namespace {

constexpr std::uint32_t bit(SelfTest test) {
  return std::uint32_t{1} << static_cast<unsigned>(test);
}

std::vector<std::byte>& memory() {
  static std::vector<std::byte> bytes(std::size_t{1} << 20U);
  return bytes;
}

TEST(SelfTests, AGoodBoardPassesAndItsStoreIsLeftEmpty) {
  RamStore store(memory());
  VirtualClock clock;
  const SelfTestResults results = run_self_tests(store, clock);
  EXPECT_EQ(results.failed, 0U);
  EXPECT_EQ(results.tested, bit(SelfTest::arithmetic) | bit(SelfTest::checksums) | bit(SelfTest::clock) |
                                bit(SelfTest::store) | bit(SelfTest::codec));
  std::int64_t starts = -1;
  ASSERT_TRUE(store.count(record_info(RecordType::start), starts).ok());
  EXPECT_EQ(starts, 0);
}

TEST(SelfTests, AClockThatStandsOrGoesBackFails) {
  class Stopped final : public Clock {
   public:
    TimeNs now() override { return back ? -++reads : 0; }
    void sleep_until(TimeNs) override {}
    TimeNs processor_time() override { return 0; }
    bool back = false;
    TimeNs reads = 0;
  };
  RamStore store(memory());
  Stopped clock;
  EXPECT_EQ(run_self_tests(store, clock).failed, bit(SelfTest::clock));
  clock.back = true;
  const SelfTestResults results = run_self_tests(store, clock);
  EXPECT_EQ(results.failed, bit(SelfTest::clock));
  EXPECT_LT(results.values[static_cast<std::size_t>(SelfTest::clock)], 0);
}

TEST(SelfTests, AStoreWithoutRoomFails) {
  RamStore store({memory().data(), 64});
  VirtualClock clock;
  EXPECT_EQ(run_self_tests(store, clock).failed, bit(SelfTest::store));
}

TEST(SelfTests, ACodecThatCannotCodeFails) {
  RamStore store(memory());
  VirtualClock clock;
  install_heap_gate({nullptr, nullptr, [](HeapRegion) { return true; }});
  const SelfTestResults results = run_self_tests(store, clock);
  install_heap_gate({});
  EXPECT_EQ(results.failed, bit(SelfTest::codec));
  EXPECT_EQ(results.values[static_cast<std::size_t>(SelfTest::codec)], 0);
}

}  // namespace
}  // namespace ilp
