// The memory that stages share: who keeps it, and who waits for it.
#include <gtest/gtest.h>

#include "tests/unit/executive/executive_fixture.hpp"

namespace ilp {
namespace {

/// `b` and `c` use the memory. `b` works in slices of 40 ms, of which two fit into a minor frame.
class SharedMemory : public test::ExecutiveTest {
 protected:
  SharedMemory() {
    stages[1].step_memory = stages[2].step_memory = true;
    b.on_step = [this] {
      clock.pass(40 * ns_per_ms);
      --slices;
      return StepResult{{}, slices > 0, slices > 0 ? Then::keep : Then::go_on};
    };
  }

  void begin(int count) {
    start();
    slices = count;
    write<FrameRecord>(1);
  }

  int slices = 1;
};

TEST_F(SharedMemory, WhoKeepsItGoesOnBeforeAnyOtherUser) {
  begin(5);
  write<OverlapRecord>(1);
  executive.run_minor_frame();
  EXPECT_EQ(diary, "abb");
  EXPECT_FALSE(executive.idle());
  next_frame();
  run_frames(1);
  EXPECT_EQ(diary, "abbabb");
  run_frames(1);
  EXPECT_EQ(diary, "abbabbabc");
  EXPECT_EQ(executive.frame_overruns(), 0U);
}

TEST_F(SharedMemory, ATimeDrivenUserRunsAsSoonAsItIsFree) {
  begin(7);
  run_frames(3);  // frame 3 is that of `c`
  EXPECT_EQ(diary, "abbabbabb");
  run_frames(1);
  EXPECT_EQ(diary, "abbabbabbabc");
}

TEST_F(SharedMemory, OthersRunMeanwhile) {
  stages[2].step_memory = false;
  begin(5);
  write<OverlapRecord>(1);
  run_frames(1);
  EXPECT_EQ(diary, "abbc");
}

TEST_F(SharedMemory, AWorkThatTakesNoTimeIsDoneAtOnce) {
  b.on_step = [this] {
    --slices;
    return StepResult{{}, slices > 0, slices > 0 ? Then::keep : Then::go_on};
  };
  begin(100);
  write<OverlapRecord>(1);
  executive.run_minor_frame();
  EXPECT_EQ(diary, "a" + std::string(100, 'b') + "c");
}

TEST_F(SharedMemory, ARestartReleasesIt) {
  begin(5);
  write<OverlapRecord>(1);
  run_frames(1);
  diary.clear();
  b.on_step = [] { return StepResult{StatusCode::assertion_failed, true}; };
  run_frames(1);
  EXPECT_EQ(b.restores, 2);
  EXPECT_EQ(diary, "abc");
}

}  // namespace
}  // namespace ilp
