// Mission time of flights in real time, and the key file.
#include <gtest/gtest.h>

#include <cstddef>
#include <fstream>
#include <string>
#include <vector>

#include "bsp/flight/key_file.hpp"
#include "bsp/flight/mission_epoch.hpp"
#include "hal/nonvolatile/ram_nonvolatile.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "tests/support/store_records.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

// 2026-01-01T00:00:00 is day 24837 since 1958.
constexpr std::int64_t new_year = 24837LL * 86400 * ns_per_s;

class MissionEpochTest : public testing::Test {
 protected:
  Status begin(EpochChoice choice, std::int64_t utc, MissionParameters& mission) {
    MissionTimeBegin begin;
    const Status status = begin_mission_time(store_, memory_, choice, utc, mission, begin);
    now_ = begin.now;
    updates_ = begin.updates;
    return status;
  }
  /// A frame was taken at this mission time.
  void fly_until(TimeNs time) {
    FrameRecord frame{.id = 1, .time_ns = time};
    test::write_records(store_, frame);
  }

  std::vector<std::byte> region_ = std::vector<std::byte>(1 << 20);
  RamStore store_{region_};
  RamNonvolatile medium_;
  FlightMemory memory_{medium_};
  MissionParameters mission_;
  TimeNs now_ = -1;
  Status updates_;
};

TEST_F(MissionEpochTest, BeginsWithTheWholeSecondBeforeTheFirstStart) {
  EXPECT_OK(begin(EpochChoice::first_start, new_year + 10 * ns_per_s + 7, mission_));
  EXPECT_EQ(mission_.mission_epoch_s, 24837.0 * 86400 + 10);
  EXPECT_EQ(now_, 7);
  EXPECT_OK(updates_);
}

TEST_F(MissionEpochTest, RunsOnThroughARestart) {
  EXPECT_OK(begin(EpochChoice::first_start, new_year, mission_));
  MissionParameters again;
  again.mission_epoch_s = 1;
  EXPECT_OK(begin(EpochChoice::mission, new_year + 90 * ns_per_s, again));
  EXPECT_EQ(again.mission_epoch_s, mission_.mission_epoch_s);
  EXPECT_EQ(now_, 90 * ns_per_s);
}

TEST_F(MissionEpochTest, MayCountFromTheMissionsEpoch) {
  EXPECT_OK(begin(EpochChoice::mission, new_year + 3 * ns_per_s, mission_));
  EXPECT_EQ(now_, 3 * ns_per_s) << "the default epoch is 2026";
}

TEST_F(MissionEpochTest, ACalendarClockBeforeTheEpochIsToldAndTheFlightBegins) {
  EXPECT_OK(begin(EpochChoice::mission, new_year - 5 * ns_per_s, mission_));
  EXPECT_EQ(now_, 0);
  EXPECT_STATUS(updates_, clock_behind);
  EXPECT_EQ(updates_.a, 5);
  EXPECT_EQ(mission_.mission_epoch_s, 24837.0 * 86400);
}

TEST_F(MissionEpochTest, AClockThatWentBackDoesNotTakeMissionTimeBack) {
  EXPECT_OK(begin(EpochChoice::first_start, new_year, mission_));
  fly_until(600 * ns_per_s);
  EXPECT_OK(begin(EpochChoice::first_start, new_year + 200 * ns_per_s, mission_));
  EXPECT_EQ(now_, 600 * ns_per_s);
  EXPECT_STATUS(updates_, clock_behind);
  EXPECT_EQ(updates_.a, 400);
  EXPECT_EQ(updates_.b, 600);
  EXPECT_OK(begin(EpochChoice::first_start, new_year - 1000 * ns_per_s, mission_));
  EXPECT_EQ(now_, 600 * ns_per_s) << "a day before the epoch likewise";
  EXPECT_OK(begin(EpochChoice::first_start, new_year + 700 * ns_per_s, mission_));
  EXPECT_EQ(now_, 700 * ns_per_s);
  EXPECT_OK(updates_);
}

TEST_F(MissionEpochTest, ANewStoreGoesOnInTheTimeOfTheFlight) {
  FlightMemoryContent content{.latest_ns = 5000 * ns_per_s, .mission_epoch_s = 24837.0 * 86400, .epoch_known = 1};
  ASSERT_TRUE(memory_.keep(content).ok());
  EXPECT_OK(begin(EpochChoice::first_start, new_year + 6000 * ns_per_s, mission_));
  EXPECT_EQ(mission_.mission_epoch_s, 24837.0 * 86400);
  EXPECT_EQ(now_, 6000 * ns_per_s);
  RamStore another(region_);
  MissionTimeBegin begun;
  EXPECT_OK(begin_mission_time(another, memory_, EpochChoice::first_start, new_year + 10, mission_, begun));
  EXPECT_EQ(begun.now, 5000 * ns_per_s) << "its clock is wrong";
}

TEST_F(MissionEpochTest, ACalendarThatBecomesRightTakesMissionTimeForwardsOnly) {
  EXPECT_OK(begin(EpochChoice::first_start, new_year, mission_));
  fly_until(600 * ns_per_s);
  MissionTimeBegin begun;
  ASSERT_TRUE(begin_mission_time(store_, memory_, EpochChoice::first_start, new_year, mission_, begun).ok());
  LateCalendar calendar;
  calendar.begin(begun);
  TimeNs time = 0;
  Status updates;
  EXPECT_FALSE(calendar.caught_up(new_year + 20 * ns_per_s, mission_, 620 * ns_per_s, time, updates));
  EXPECT_TRUE(calendar.caught_up(new_year + 7000 * ns_per_s, mission_, 640 * ns_per_s, time, updates));
  EXPECT_EQ(time, 7000 * ns_per_s);
  EXPECT_STATUS(updates, clock_caught_up);
  EXPECT_EQ(updates.a, 6360);
  EXPECT_FALSE(calendar.caught_up(new_year + 9000 * ns_per_s, mission_, 7001 * ns_per_s, time, updates)) << "once";
  LateCalendar of_a_right_clock;
  of_a_right_clock.begin({});
  EXPECT_FALSE(of_a_right_clock.caught_up(new_year + 9000 * ns_per_s, mission_, 0, time, updates));
}

// The latest second that a Linux clock can be set to is in 2232.
constexpr std::int64_t latest_calendar = (2232LL - 1958) * 31'556'952 * ns_per_s;

TEST_F(MissionEpochTest, ACalendarBehindEveryEpochIsNotBelievedAtTheFirstStart) {
  EXPECT_OK(begin(EpochChoice::first_start, latest_calendar, mission_));
  EXPECT_EQ(mission_.mission_epoch_s, MissionParameters{}.mission_epoch_s);
  EXPECT_EQ(now_, 0);
  EXPECT_STATUS(updates_, time_out_of_range);
  LateCalendar calendar;
  calendar.begin({now_, updates_});
  TimeNs time = 0;
  Status updates;
  EXPECT_FALSE(calendar.caught_up(latest_calendar, mission_, 10 * ns_per_s, time, updates));
  EXPECT_TRUE(calendar.caught_up(new_year + 7000 * ns_per_s, mission_, 20 * ns_per_s, time, updates))
      << "it is right now";
  EXPECT_EQ(time, 7000 * ns_per_s);
}

TEST_F(MissionEpochTest, MissionTimeNeverGoesBeyondWhatTwoDurationsNeed) {
  EXPECT_OK(begin(EpochChoice::first_start, new_year, mission_));
  fly_until(600 * ns_per_s);
  EXPECT_OK(begin(EpochChoice::first_start, latest_calendar, mission_));
  EXPECT_EQ(now_, 600 * ns_per_s) << "as with a clock that went back";
  EXPECT_STATUS(updates_, time_out_of_range);
  EXPECT_EQ(updates_.a, latest_calendar / ns_per_s / 86400);
  EXPECT_OK(begin(EpochChoice::first_start, new_year + longest_duration_ns - ns_per_s, mission_));
  EXPECT_EQ(now_, longest_duration_ns - ns_per_s) << "believed up to there";
  EXPECT_OK(updates_);
}

TEST(KeyFileOnDiskTest, IsReadOrItsFaultNamed) {
  const test::TemporaryFolder folder;
  Authenticator keys;
  EXPECT_STATUS(read_key_file((folder / "none").c_str(), keys), not_found);
  EXPECT_STATUS(read_key_file("/", keys), io_error);
  const auto permit = [](const std::string& path, unsigned bits) {
    std::filesystem::permissions(path, static_cast<std::filesystem::perms>(bits));
  };
  std::ofstream(folder / "long") << std::string(5000, '#');
  permit(folder / "long", 0600);
  EXPECT_STATUS(read_key_file((folder / "long").c_str(), keys), capacity_exceeded);
  std::ofstream(folder / "keys") << "1 " << std::string(32, 'a') << "\n";
  for (const unsigned bits : {0644U, 0640U, 0602U, 0601U, 0660U}) {
    permit(folder / "keys", bits);
    EXPECT_STATUS(read_key_file((folder / "keys").c_str(), keys), file_not_private);
    EXPECT_TRUE(keys.empty());
  }
  permit(folder / "keys", 0600);
  EXPECT_OK(read_key_file((folder / "keys").c_str(), keys));
  EXPECT_FALSE(keys.empty());
}

TEST(LatestKnownTime, IsThatOfTheNewestRecordOfAnyKindThatHasOne) {
  std::vector<std::byte> memory(std::size_t{1} << 20U);
  RamStore store(memory);
  TimeNs time = -1;
  ASSERT_TRUE(latest_known_time(store, time).ok());
  EXPECT_EQ(time, 0);
  FrameRecord frame{.id = 1, .time_ns = 5 * ns_per_s};
  EventRecord event{.id = 1, .time_ns = 7 * ns_per_s};
  test::write_records(store, frame, event);
  ASSERT_TRUE(latest_known_time(store, time).ok());
  EXPECT_EQ(time, 7 * ns_per_s);
}

}  // namespace
}  // namespace ilp
