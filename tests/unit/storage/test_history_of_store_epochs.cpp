// A new store epoch counts from far above the previous store epoch; its records do not count as old for that.
#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "fsw/storage/record_history.hpp"
#include "hal/store/ram/ram_store.hpp"

namespace ilp {
namespace {

constexpr std::int64_t base = 100'000'000;

class HistoryOfStoreEpochsTest : public testing::Test {
 protected:
  void add_frames(std::int64_t first, std::int64_t count) {
    ASSERT_TRUE(store.begin().ok());
    for (std::int64_t id = first; id < first + count; ++id) {
      FrameRecord frame{.id = id};
      CommandRecord command{.id = id};
      ASSERT_TRUE(put(store, frame).ok() && put(store, command).ok());
    }
    ASSERT_TRUE(store.commit().ok());
    newest = first + count - 1;
  }
  void keep_house() {
    RecordHistory history;
    std::int64_t erased = 0;
    for (int i = 0; i < 200; ++i) {
      ASSERT_TRUE(store.begin().ok());
      ASSERT_TRUE(erase_past(store, mission, newest, history, erased).ok());
      ASSERT_TRUE(store.commit().ok());
    }
  }
  template <typename Record>
  std::int64_t oldest() {
    Record record;
    return next(store, 0, record).ok() ? record.id : 0;
  }

  std::vector<std::byte> region = std::vector<std::byte>(std::size_t{8} << 20U);
  RamStore store{region};
  MissionParameters mission;
  std::int64_t newest = 0;
};

TEST_F(HistoryOfStoreEpochsTest, WhatTheStoreEpochBeforeLeftStaysUntilThisOneHasAHistoryOfItsOwn) {
  mission.history_frames = 100;
  add_frames(1, 12);
  store.number_from(base, base);
  keep_house();
  EXPECT_EQ(oldest<FrameRecord>(), 1);
  EXPECT_EQ(oldest<CommandRecord>(), 1);
  add_frames(base + 1, 50);
  keep_house();
  EXPECT_EQ(oldest<FrameRecord>(), 1);
  add_frames(base + 51, 60);
  keep_house();
  EXPECT_EQ(oldest<FrameRecord>(), base + 11) << "every table stays bounded";
  EXPECT_EQ(oldest<CommandRecord>(), 1);
}

}  // namespace
}  // namespace ilp
