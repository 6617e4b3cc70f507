#include <gtest/gtest.h>

#include "fsw/packets/pass_schedule.hpp"

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

TEST(PassScheduleTest, ACommandedPassComesOnTopOfTheSchedule) {
  MissionParameters mission = passes(100, 50, 10);
  open_contact(30 * s, 25, mission);
  EXPECT_FALSE(contact_at(mission, 29 * s).open);
  EXPECT_TRUE(contact_at(mission, 31 * s).open);
  EXPECT_EQ(contact_at(mission, 31 * s).end_ns, 55 * s);
  EXPECT_FALSE(contact_at(mission, 56 * s).open);
  EXPECT_TRUE(contact_at(mission, 100 * s).open);
}

TEST(PassScheduleTest, ACommandedEndLastsUntilTheNextPass) {
  MissionParameters mission = passes(100, 50, 10);
  close_contact(103 * s, mission);
  EXPECT_TRUE(contact_at(mission, 102 * s).open);
  const Contact contact = contact_at(mission, 104 * s);
  EXPECT_FALSE(contact.open);
  EXPECT_EQ(contact.begin_ns, 150 * s);
  EXPECT_TRUE(contact_at(mission, 151 * s).open);
  // Nobody who is always in contact can make the package deaf for good.
  MissionParameters always = passes(0, 0, 600);
  close_contact(10 * s, always);
  EXPECT_FALSE(contact_at(always, 11 * s).open);
  EXPECT_TRUE(contact_at(always, continuous_window_ns + s).open);
}

TEST(PassScheduleTest, ACommandedPassEndsBeforeItsTimeAndBeginsAgain) {
  MissionParameters mission = passes(100, 50, 10);
  open_contact(20 * s, 30, mission);
  close_contact(25 * s, mission);
  EXPECT_TRUE(contact_at(mission, 24 * s).open);
  EXPECT_FALSE(contact_at(mission, 26 * s).open);
  close_contact(105 * s, mission);
  open_contact(106 * s, 10, mission);
  EXPECT_FALSE(contact_at(mission, 105 * s + s / 2).open);
  EXPECT_TRUE(contact_at(mission, 107 * s).open);
}

TEST(PassScheduleTest, CommandedContactCountsAsContact) {
  MissionParameters extra = passes(100, 50, 10), cut = extra, both = extra;
  open_contact(30 * s, 25, extra);
  close_contact(203 * s, cut);
  open_contact(30 * s, 75, both);
  close_contact(152 * s, both);
  for (const auto& mission : {extra, cut, both}) {
    for (int from = 0; from < 130; from += 13) {
      TimeNs counted = 0;
      for (int to = from; to < 320; ++to) {
        EXPECT_NEAR(static_cast<double>(contact_between(mission, from * s, to * s)), static_cast<double>(counted), 10)
            << from << " to " << to;
        if (contact_at(mission, to * s + s / 2).open) counted += s;
      }
    }
  }
}

}  // namespace
}  // namespace ilp
