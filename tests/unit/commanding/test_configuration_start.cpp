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
    ConfigurationStart start;
    start.loaded = memory.load();
    return configuration.begin(store, start);
  }

  std::vector<std::byte> region = std::vector<std::byte>(std::size_t{4} << 20U);
  const std::unique_ptr<RamStore> ram = std::make_unique<RamStore>(region);
  test::FailingStore store{*ram};
  RamNonvolatile medium;
};

TEST_F(FirstStart, AfterAnyCallOfTheStoreFailedTheNextOneIsStillTheFirstLife) {
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

}  // namespace
}  // namespace ilp
