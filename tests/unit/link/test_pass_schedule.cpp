#include <gtest/gtest.h>

#include "fsw/link/pass_schedule.hpp"

namespace ilp {
namespace {

constexpr TimeNs s = ns_per_s;

MissionParameters passes(double start, double period, double length) {
  MissionParameters mission;
  mission.pass_start_s = start;
  mission.pass_period_s = period;
  mission.pass_length_s = length;
  return mission;
}

TEST(PassScheduleTest, APassHoldsItsFirstInstantAndNotItsEnd) {
  const MissionParameters mission = passes(100, 50, 10);
  EXPECT_FALSE(contact_at(mission, 0).open);
  EXPECT_EQ(contact_at(mission, 0).begin_ns, 100 * s);
  EXPECT_FALSE(contact_at(mission, 100 * s - 1).open);
  EXPECT_TRUE(contact_at(mission, 100 * s).open);
  EXPECT_EQ(contact_at(mission, 100 * s).pass, 0);
  EXPECT_TRUE(contact_at(mission, 110 * s - 1).open);
  EXPECT_FALSE(contact_at(mission, 110 * s).open);
  EXPECT_EQ(contact_at(mission, 110 * s).pass, 1);
  EXPECT_EQ(contact_at(mission, 205 * s).pass, 2);
  EXPECT_EQ(contact_at(mission, 205 * s).end_ns, 210 * s);
}

TEST(PassScheduleTest, AfterTheLastPassTheLinkIsOver) {
  MissionParameters mission = passes(100, 50, 10);
  mission.pass_count = 2;
  EXPECT_TRUE(contact_at(mission, 159 * s).open);
  EXPECT_FALSE(contact_at(mission, 159 * s).over);
  EXPECT_TRUE(contact_at(mission, 160 * s).over);
  EXPECT_FALSE(contact_at(mission, 205 * s).open);
  EXPECT_EQ(contact_between(mission, 0, 10000 * s), 20 * s);
}

TEST(PassScheduleTest, ContactBetweenIsTheSumOfItsInstants) {
  for (const auto& mission : {passes(100, 50, 10), passes(0, 7, 7), passes(3, 11, 1), passes(0, 0, 600)}) {
    for (int from = 0; from < 130; from += 13) {
      TimeNs counted = 0;
      for (int to = from; to < 320; ++to) {
        EXPECT_EQ(contact_between(mission, from * s, to * s), counted) << from << " to " << to;
        if (contact_at(mission, to * s).open) counted += s;
      }
    }
  }
}

TEST(PassScheduleTest, TimeThatRunsBackwardsBringsNoContact) {
  EXPECT_EQ(contact_between(passes(0, 0, 600), 50 * s, 20 * s), 0);
  EXPECT_EQ(contact_between(passes(10, 20, 5), 50 * s, 50 * s), 0);
}

TEST(PassScheduleTest, WithoutPassesThereIsAlwaysContactInWindows) {
  const MissionParameters mission = passes(500, 0, 10);
  EXPECT_TRUE(contact_at(mission, 0).open);
  EXPECT_TRUE(contact_at(mission, 12345 * s + 7).open);
  EXPECT_NE(contact_at(mission, 0).pass, contact_at(mission, continuous_window_ns).pass);
}

}  // namespace
}  // namespace ilp
