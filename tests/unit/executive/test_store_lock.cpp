// While another process keeps the lock of the store.
#include <algorithm>

#include "tests/unit/executive/executive_fixture.hpp"

namespace ilp {
namespace {

using test::ExecutiveTest;

TEST_F(ExecutiveTest, WhileAnotherProcessKeepsTheLockOnlyTimeDrivenStagesStepAndNothingIsAFault) {
  start();
  const auto write_or_wait = [&]() -> StepResult {
    Transaction transaction(lockable);
    const Status begun = transaction.begin();
    return {begun, !begun.ok()};
  };
  a.on_step = b.on_step = write_or_wait;
  write<FrameRecord>(1);
  lockable.lock();
  run_frames(20);
  EXPECT_EQ(std::count(diary.begin(), diary.end(), 'a'), 20) << "in every frame, once";
  EXPECT_EQ(std::count(diary.begin(), diary.end(), 'b'), 0) << "it would work in vain";
  EXPECT_FALSE(executive.idle());
  executive.events().report(clock.now(), "camera", {StatusCode::camera_silent, 5});
  executive.events().report(clock.now(), "camera", {StatusCode::frame_gap, 6});
  const TimeNs reported = clock.now();
  lockable.recover();
  diary.clear();
  run_frames(1);
  EXPECT_EQ(std::count(diary.begin(), diary.end(), 'b'), 1) << "at once";
  EXPECT_TRUE(executive.idle());
  EXPECT_EQ(stats(0).faults + stats(1).faults, 0U);
  ASSERT_EQ(events(StatusCode::camera_silent).size(), 1U) << "it waited for the lock";
  EXPECT_EQ(events(StatusCode::camera_silent)[0].time_ns, reported);
  EXPECT_EQ(events(StatusCode::frame_gap)[0].id, events(StatusCode::camera_silent)[0].id + 1);
  ASSERT_EQ(events(StatusCode::store_locked).size(), 1U);
  EXPECT_EQ(events(StatusCode::store_locked)[0].a, 2000);
  EXPECT_TRUE(events(StatusCode::events_lost).empty());
}

TEST_F(ExecutiveTest, AShortLockIsNoEvent) {
  start();
  a.on_step = [&]() -> StepResult {
    Transaction transaction(lockable);
    return {transaction.begin()};
  };
  lockable.lock();
  run_frames(3);
  lockable.recover();
  run_frames(3);
  EXPECT_TRUE(events(StatusCode::store_locked).empty());
}

TEST_F(ExecutiveTest, EventsThatFindNoPlaceToWaitForTheLockAreCounted) {
  lockable.lock();
  EventLog log(lockable);
  for (int i = 1; i <= 20; ++i) log.report(i, "a", {StatusCode::frame_gap, i});
  lockable.recover();
  log.report_due(30);
  const std::vector<EventRecord> reported = events(StatusCode::frame_gap);
  ASSERT_EQ(reported.size(), 16U);
  for (std::size_t i = 0; i < reported.size(); ++i) EXPECT_EQ(reported[i].a, static_cast<std::int64_t>(i) + 1);
  ASSERT_EQ(events(StatusCode::events_lost).size(), 1U);
  EXPECT_EQ(events(StatusCode::events_lost)[0].a, 4);
}

}  // namespace
}  // namespace ilp
