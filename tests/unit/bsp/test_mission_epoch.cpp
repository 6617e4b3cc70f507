// Mission time of flights in real time, and the key file.
#include <gtest/gtest.h>

#include <cstddef>
#include <fstream>
#include <string>
#include <vector>

#include "bsp/flight/key_file.hpp"
#include "bsp/flight/mission_epoch.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

// 2026-01-01T00:00:00 is day 24837 since 1958.
constexpr std::int64_t new_year = 24837LL * 86400 * ns_per_s;

class MissionEpochTest : public testing::Test {
 protected:
  std::vector<std::byte> region_ = std::vector<std::byte>(1 << 20);
  RamStore store_{region_};
  MissionParameters mission_;
  TimeNs now_ = -1;
};

TEST_F(MissionEpochTest, BeginsWithTheWholeSecondBeforeTheFirstStart) {
  EXPECT_OK(begin_mission_time(store_, EpochChoice::first_start, new_year + 10 * ns_per_s + 7, mission_, now_));
  EXPECT_EQ(mission_.mission_epoch_s, 24837.0 * 86400 + 10);
  EXPECT_EQ(now_, 7);
}

TEST_F(MissionEpochTest, RunsOnThroughARestart) {
  EXPECT_OK(begin_mission_time(store_, EpochChoice::first_start, new_year, mission_, now_));
  MissionParameters again;
  again.mission_epoch_s = 1;
  EXPECT_OK(begin_mission_time(store_, EpochChoice::mission, new_year + 90 * ns_per_s, again, now_));
  EXPECT_EQ(again.mission_epoch_s, mission_.mission_epoch_s);
  EXPECT_EQ(now_, 90 * ns_per_s);
}

TEST_F(MissionEpochTest, MayCountFromTheMissionsEpoch) {
  EXPECT_OK(begin_mission_time(store_, EpochChoice::mission, new_year + 3 * ns_per_s, mission_, now_));
  EXPECT_EQ(now_, 3 * ns_per_s) << "the default epoch is 2026";
}

TEST_F(MissionEpochTest, ACalendarClockBeforeTheEpochIsAnErrorAndLeavesNothing) {
  const Status status = begin_mission_time(store_, EpochChoice::mission, new_year - 5, mission_, now_);
  EXPECT_STATUS(status, time_out_of_range);
  EXPECT_EQ(status.b, -5);
  EXPECT_OK(begin_mission_time(store_, EpochChoice::first_start, new_year + 9, mission_, now_));
  EXPECT_EQ(now_, 9);
}

TEST(KeyFileOnDiskTest, IsReadOrItsFaultNamed) {
  const test::TemporaryFolder folder;
  Authenticator keys;
  EXPECT_STATUS(read_key_file((folder / "none").c_str(), keys), not_found);
  EXPECT_STATUS(read_key_file("/", keys), io_error);
  std::ofstream(folder / "long") << std::string(5000, '#');
  EXPECT_STATUS(read_key_file((folder / "long").c_str(), keys), capacity_exceeded);
  std::ofstream(folder / "keys") << "1 " << std::string(32, 'a') << "\n";
  EXPECT_OK(read_key_file((folder / "keys").c_str(), keys));
  EXPECT_FALSE(keys.empty());
}

TEST(LatestKnownTime, IsThatOfTheNewestRecordOfAnyKindThatHasOne) {
  std::vector<std::byte> memory(std::size_t{1} << 20U);
  RamStore store(memory);
  TimeNs time = -1;
  ASSERT_TRUE(latest_known_time(store, time).ok());
  EXPECT_EQ(time, 0);
  FrameRecord frame;
  frame.id = 1;
  frame.time_ns = 5 * ns_per_s;
  EventRecord event;
  event.id = 1;
  event.time_ns = 7 * ns_per_s;
  Transaction transaction(store);
  ASSERT_TRUE(transaction.begin().ok());
  ASSERT_TRUE(put(store, frame).ok());
  ASSERT_TRUE(put(store, event).ok());
  ASSERT_TRUE(transaction.commit().ok());
  ASSERT_TRUE(latest_known_time(store, time).ok());
  EXPECT_EQ(time, 7 * ns_per_s);
}

}  // namespace
}  // namespace ilp
