#include <gtest/gtest.h>

#include "fsw/executive/work_level.hpp"

namespace ilp {
namespace {

class WorkLevelTest : public testing::Test {
 protected:
  /// One window of 10 s in 100 minor frames.
  LoadReason judge(double overrun_share, double busy, Backlog backlog = {}) {
    LoadWindow window;
    window.frames = 100;
    window.busy_frames = static_cast<std::uint32_t>(100 * busy);
    window.begin_ns = now;
    window.overrun_ns = static_cast<TimeNs>(overrun_share * 10e9);
    now += 10 * ns_per_s;
    return level.judge(window, now, backlog, mission);
  }
  void calm(int windows) {
    for (int i = 0; i < windows; ++i) EXPECT_EQ(judge(0, 0), LoadReason::none);
  }

  TimeNs now = 0;
  MissionParameters mission;
  WorkLevel level;
};

TEST_F(WorkLevelTest, OverrunsRaiseItStepByStepAndNoFurtherThanTwo) {
  EXPECT_EQ(judge(0.29, 1), LoadReason::none);
  EXPECT_EQ(level.level(), 0);
  EXPECT_EQ(judge(0.31, 0), LoadReason::overruns);
  EXPECT_EQ(level.level(), 1);
  for (std::uint32_t i = 0; i < windows_to_settle; ++i) {
    EXPECT_EQ(judge(0.5, 0), LoadReason::none) << "what was chosen before has to pass through first";
  }
  EXPECT_EQ(level.level(), 1);
  EXPECT_EQ(judge(0.5, 0), LoadReason::overruns);
  EXPECT_EQ(level.level(), 2);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(judge(1, 1), LoadReason::none);
  EXPECT_EQ(level.level(), 2);
}

TEST_F(WorkLevelTest, ABacklogCountsOnlyWhereTheProcessorHasNoRest) {
  EXPECT_EQ(judge(0, 0.5, {1000, 1000}), LoadReason::none) << "it waits for something else, such as a calibration";
  EXPECT_EQ(level.level(), 0);
  EXPECT_EQ(judge(0, 1, {11, 3}), LoadReason::none);
  EXPECT_EQ(judge(0, 1, {12, 0}), LoadReason::frames);
  calm(static_cast<int>(windows_to_settle));
  EXPECT_EQ(judge(0, 1, {0, 4}), LoadReason::keyframes);
  EXPECT_EQ(level.level(), 2);
}

TEST_F(WorkLevelTest, ComesBackAfterEnoughCalmWindowsInARow) {
  level.restore(2);
  const auto windows = static_cast<int>(mission.recovery_windows);
  calm(windows - 1);
  EXPECT_EQ(judge(0.2, 0), LoadReason::none) << "neither overload nor calm";
  calm(windows - 1);
  EXPECT_EQ(level.level(), 2);
  calm(1);
  EXPECT_EQ(level.level(), 1);
  calm(windows - 1);
  EXPECT_EQ(level.level(), 1);
  calm(1);
  EXPECT_EQ(level.level(), 0);
  calm(50);
  EXPECT_EQ(level.level(), 0);
}

TEST_F(WorkLevelTest, BetweenTheLimitsNothingChanges) {
  level.restore(1);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(judge(0, 1, {6 + i % 6, 2 + i % 2}), LoadReason::none);
  EXPECT_EQ(level.level(), 1);
}

TEST_F(WorkLevelTest, SwitchedOffItIsFull) {
  level.restore(2);
  mission.degraded_modes = 0;
  EXPECT_EQ(judge(1, 1, {1000, 1000}), LoadReason::none);
  EXPECT_EQ(level.level(), 0);
}

TEST_F(WorkLevelTest, ARecordThatIsWrongIsNoHigherLevel) {
  level.restore(200);
  EXPECT_EQ(level.level(), max_work_level);
}

}  // namespace
}  // namespace ilp
