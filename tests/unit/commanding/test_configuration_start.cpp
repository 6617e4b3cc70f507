// The first start of a flight, in which a call of the store fails.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "fsw/commanding/configuration.hpp"
#include "hal/nonvolatile/ram_nonvolatile.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "tests/support/failing_store.hpp"

namespace ilp {
namespace {

class FirstStart : public ::testing::Test {
 protected:
  Status start() {
    FlightMemory memory(medium);
    MissionParameters mission;
    Configuration configuration(memory, mission);
    ConfigurationStart start{.loaded = memory.load(), .utc_s = calendar_s};
    return configuration.begin(store, start);
  }
  /// The database is gone, and another one begins a store epoch.
  IdentityRecord begin_another_store_epoch() {
    EXPECT_TRUE(store.begin().ok());
    static_cast<void>(store.erase(record_info<IdentityRecord>(), 1));
    EXPECT_TRUE(store.commit().ok());
    EXPECT_TRUE(start().ok());
    IdentityRecord identity;
    EXPECT_TRUE(get(store, 1, identity).ok());
    return identity;
  }
  void live_before(std::int64_t store_epoch) {
    FlightMemory memory(medium);
    static_cast<void>(memory.load());
    FlightMemoryContent content = memory.content();
    content.life = store_epoch;
    content.keyframe_base = content.record_base = (store_epoch - 1) * 100'000'000;
    ASSERT_TRUE(memory.keep(content).ok());
  }

  std::vector<std::byte> region = std::vector<std::byte>(std::size_t{4} << 20U);
  const std::unique_ptr<RamStore> ram = std::make_unique<RamStore>(region);
  test::FailingStore store{*ram};
  RamNonvolatile medium;
  std::int64_t calendar_s = 0;
};

TEST_F(FirstStart, AfterAnyCallOfTheStoreFailedTheNextOneIsStillTheFirstStoreEpoch) {
  for (std::int64_t call = 0; call < 4; ++call) {
    const std::int64_t before = store.calls();
    store.fail(before + call);
    EXPECT_TRUE(start().is(StatusCode::store_error)) << call;
    store.recover();
  }
  ASSERT_TRUE(start().ok());
  IdentityRecord identity;
  ASSERT_TRUE(get(store, 1, identity).ok());
  EXPECT_EQ(identity.life, 1);
  EXPECT_EQ(identity.keyframe_base, 0);
  EXPECT_EQ(identity.record_base, 0);
}

TEST_F(FirstStart, ALifeWhoseDatabaseIsGoneIsCounted) {
  ASSERT_TRUE(start().ok());
  ASSERT_TRUE(store.begin().ok());
  ASSERT_TRUE(store.erase(record_info<IdentityRecord>(), 1).ok());
  ASSERT_TRUE(store.commit().ok());
  ASSERT_TRUE(start().ok());
  IdentityRecord identity;
  ASSERT_TRUE(get(store, 1, identity).ok());
  EXPECT_EQ(identity.life, 2);
  EXPECT_GT(identity.keyframe_base, 0);
}

// Behind the 50th store epoch numbers begin by the calendar.

TEST_F(FirstStart, BehindTheLastCountedStoreEpochNoNumberComesAgainWhateverTheCalendarSays) {
  live_before(49);
  constexpr std::int64_t year_s = 31'556'952;
  constexpr std::int64_t in_2026_s = 2'145'916'800;
  // A board without a clock begins in 1970; others jump both ways, up to 2232, the latest that Linux can be set to.
  const std::int64_t calendars[] = {in_2026_s + 60,           in_2026_s + 50,           12 * year_s, 12 * year_s,
                                    in_2026_s + 200 * year_s, in_2026_s + 206 * year_s, in_2026_s,   12 * year_s};
  std::int64_t keyframes = 0, records = 0;
  for (const std::int64_t calendar : calendars) {
    calendar_s = calendar;
    const IdentityRecord identity = begin_another_store_epoch();
    EXPECT_GT(identity.keyframe_base, keyframes) << calendar;
    EXPECT_GT(identity.record_base, records) << calendar;
    if (keyframes > 0 && identity.life > 51) {
      EXPECT_GE(identity.keyframe_base - keyframes, 1'000'000) << "room for the keyframes of the store epoch before";
    }
    EXPECT_LT(identity.keyframe_base, 10'000'000'000) << "names of files have room for ten digits";
    keyframes = identity.keyframe_base;
    records = identity.record_base;
  }
  FlightMemory memory(medium);
  EXPECT_TRUE(memory.load().ok()) << "and what is kept is believed";
}

}  // namespace
}  // namespace ilp
