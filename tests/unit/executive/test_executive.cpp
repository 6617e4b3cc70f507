#include <gtest/gtest.h>

#include <vector>

#include "fsw/executive/frame_timing.hpp"
#include "fsw/shared/checkpoint.hpp"
#include "tests/unit/executive/executive_fixture.hpp"
#include "tests/unit/executive/refusing_store.hpp"

namespace ilp {
namespace {

using test::ExecutiveTest;
using test::FakeClock;
using test::FakeComponent;

TEST_F(ExecutiveTest, AtTheStartEveryComponentIsRestoredAndStepsOnceInTableOrder) {
  ASSERT_TRUE(executive.start().ok());
  EXPECT_EQ(a.restores + b.restores + c.restores, 3);
  EXPECT_EQ(diary, "");
  executive.run_minor_frame();
  EXPECT_EQ(diary, "abc");
}

TEST_F(ExecutiveTest, WithoutChangesOnlyTheTimeDrivenComponentsRun) {
  start();
  run_frames(6);  // frames 1 to 6
  EXPECT_EQ(diary, "aaacaaac");
}

TEST_F(ExecutiveTest, AChangedTableWakesItsReadersOnly) {
  start();
  write<FrameRecord>(1);
  executive.run_minor_frame();
  EXPECT_EQ(diary, "ab");
  next_frame();
  diary.clear();
  write<OverlapRecord>(1);
  executive.run_minor_frame();
  EXPECT_EQ(diary, "ac");
}

TEST_F(ExecutiveTest, WhatAComponentWritesWakesTheNextInTheSameFrame) {
  start();
  a.on_step = [&] {
    write<FrameRecord>(1);
    return StepResult{};
  };
  b.on_step = [&] {
    write<OverlapRecord>(1);
    return StepResult{};
  };
  executive.run_minor_frame();
  EXPECT_EQ(diary, "abc");
}

TEST_F(ExecutiveTest, ARolledBackChangeWakesNobody) {
  start();
  a.on_step = [&] {
    Transaction transaction(store);
    EXPECT_TRUE(transaction.begin().ok());
    FrameRecord frame{.id = 1};
    EXPECT_TRUE(put(store, frame).ok());
    return StepResult{};
  };
  executive.run_minor_frame();
  EXPECT_EQ(diary, "a");
}

TEST_F(ExecutiveTest, PendingWorkGetsTheRestOfTheFrameAndNoMore) {
  start();
  b.on_step = [&] {
    clock.pass(15 * ns_per_ms);
    return StepResult{{}, true};
  };
  write<FrameRecord>(1);
  executive.run_minor_frame();
  // A seventh step of 15 ms would end after 100 ms.
  EXPECT_EQ(b.steps, 1 + 6);
  EXPECT_EQ(executive.frame_overruns(), 0U);
  EXPECT_EQ(a.steps, 2) << "one in the start frame, one in this";
  EXPECT_FALSE(executive.idle());

  b.on_step = nullptr;
  next_frame();
  executive.run_minor_frame();
  EXPECT_EQ(b.steps, 1 + 6 + 1) << "what is pending runs on in the next frame, until it is done";
  EXPECT_TRUE(executive.idle());
}

TEST_F(ExecutiveTest, AStepThatIsLongerThanTheLatestOnesMakesNoFrameLate) {
  start();
  b.on_step = [&] {
    const TimeNs in_frame = clock.now() % minor_frame_ns;
    clock.pass(in_frame >= 75 * ns_per_ms ? 20 * ns_per_ms : 5 * ns_per_ms);
    return StepResult{{}, true};
  };
  write<FrameRecord>(1);
  run_frames(20);
  EXPECT_GE(b.steps, 20 * 10);
  EXPECT_EQ(executive.frame_overruns(), 0U);
}

TEST_F(ExecutiveTest, AComponentThatWaitsForADeviceIsAskedOncePerFrame) {
  start();
  b.on_step = [&] { return StepResult{{}, true, Then::wait}; };
  write<FrameRecord>(1);
  executive.run_minor_frame();
  EXPECT_EQ(b.steps, 1 + 1);
  EXPECT_FALSE(executive.idle());
  next_frame();
  executive.run_minor_frame();
  EXPECT_EQ(b.steps, 1 + 2) << "without being woken";
  EXPECT_EQ(b.restores, 1);
  b.on_step = nullptr;
  next_frame();
  executive.run_minor_frame();
  EXPECT_TRUE(executive.idle());
}

TEST_F(ExecutiveTest, WhatNeverFitsIntoAFrameRunsAllTheSameAndInTurn) {
  start();
  // Both are longer than a frame; neither may starve, nor the time-driven one.
  b.on_step = [&] {
    clock.pass(3 * minor_frame_ns / 2);
    return StepResult{{}, true};
  };
  c.on_step = b.on_step;
  stages[2].period = 0;
  write<FrameRecord>(1);
  write<OverlapRecord>(1);
  for (int i = 0; i < 20; ++i) {
    executive.run_minor_frame();
    next_frame();
  }
  EXPECT_EQ(a.steps, 1 + 20);
  EXPECT_GE(b.steps, 1 + 9);
  EXPECT_GE(c.steps, 1 + 9);
  EXPECT_LE(b.steps + c.steps, 2 + 22) << "one of them in each frame, once it is known how long they take";
}

TEST_F(ExecutiveTest, ALongStepWaitsForAFrameThatHasRoomForIt) {
  start();
  b.on_step = [&] {
    clock.pass(40 * ns_per_ms);
    return StepResult{{}, true};
  };
  c.on_step = [&] {
    clock.pass(70 * ns_per_ms);
    return StepResult{{}, true};
  };
  stages[2].period = 0;
  write<FrameRecord>(1);
  write<OverlapRecord>(1);
  run_frames(1);
  const std::uint32_t learning = executive.frame_overruns();
  run_frames(30);
  EXPECT_LE(learning, 1U);
  EXPECT_EQ(executive.frame_overruns() - learning, 0U);
  EXPECT_GE(b.steps, 15);
  EXPECT_GE(c.steps, 10);
}

TEST_F(ExecutiveTest, PendingComponentsTakeTurns) {
  start();
  int b_left = 3, c_left = 3;
  b.on_step = [&] { return StepResult{{}, --b_left > 0}; };
  c.on_step = [&] { return StepResult{{}, --c_left > 0}; };
  write<FrameRecord>(1);
  write<OverlapRecord>(1);
  executive.run_minor_frame();
  EXPECT_EQ(diary, "abcbcbc");
}

TEST_F(ExecutiveTest, StepsOfAFrameAreBoundedWhenTimeStandsStill) {
  start();
  b.on_step = [] { return StepResult{{}, true}; };
  c.on_step = [] { return StepResult{{}, true}; };
  write<FrameRecord>(1);
  write<OverlapRecord>(1);
  executive.run_minor_frame();
  const auto steps = static_cast<std::uint32_t>(b.steps + c.steps);
  EXPECT_GE(steps, max_steps_per_frame);
  EXPECT_LE(steps, max_steps_per_frame + 2 * stages.size());
  EXPECT_EQ(executive.frames_run(), 2);
}

TEST_F(ExecutiveTest, ALateStepIsAnOverrunOfItsComponentAndNotOfTheFrame) {
  start();
  const std::uint32_t steps_before = stats(0).steps;
  a.on_step = [&] {
    clock.pass(budget + 1);
    return StepResult{};
  };
  executive.run_minor_frame();
  EXPECT_EQ(stats(0).overruns, 1U);
  EXPECT_EQ(stats(0).longest_ns, budget + 1);
  EXPECT_EQ(stats(0).busy_ns, budget + 1);
  EXPECT_EQ(stats(0).steps, steps_before + 1);
  EXPECT_EQ(stats(1).overruns, 0U);
  EXPECT_EQ(executive.frame_overruns(), 0U);

  a.on_step = [&] {
    clock.pass(budget);
    return StepResult{};
  };
  next_frame();
  executive.run_minor_frame();
  EXPECT_EQ(stats(0).overruns, 1U) << "the whole budget may be used";
}

TEST_F(ExecutiveTest, AFrameThatEndsLateIsCountedAndReportedWithItsNumberAndDelay) {
  start();
  a.on_step = [&] {
    clock.pass(minor_frame_ns + 2500 * ns_per_us);
    return StepResult{};
  };
  executive.run_minor_frame();
  EXPECT_EQ(executive.frame_overruns(), 1U);
  const std::vector<EventRecord> late = events(StatusCode::frame_overrun);
  ASSERT_EQ(late.size(), 1U);
  EXPECT_EQ(late[0].a, 1);
  EXPECT_EQ(late[0].b, 2500);
}

TEST_F(ExecutiveTest, OverrunsInEveryFrameAreToldOnceAMinuteWithTheirNumber) {
  start();
  a.on_step = [&] {
    clock.pass(minor_frame_ns + 3 * ns_per_ms);
    return StepResult{};
  };
  // 103 ms each: 1200 of them take 123.6 s.
  for (int i = 0; i < 1200; ++i) executive.run_minor_frame();
  EXPECT_EQ(executive.frame_overruns(), 1200U);
  EXPECT_EQ(events(StatusCode::frame_overrun).size(), 1U);
  const std::vector<EventRecord> more = events(StatusCode::frames_overran);
  ASSERT_EQ(more.size(), 2U);
  EXPECT_EQ(more[0].a, 583) << "in 60 s";
  EXPECT_EQ(more[0].b, 3000);
  a.on_step = nullptr;
  for (int i = 0; i < 1300; ++i) {
    clock.sleep_until(clock.now() + minor_frame_ns);
    executive.run_minor_frame();
  }
  ASSERT_EQ(events(StatusCode::frames_overran).size(), 3U);
  EXPECT_EQ(1 + more[0].a + more[1].a + events(StatusCode::frames_overran)[2].a, 1200) << "none is hidden";
  a.on_step = [&] {
    clock.pass(minor_frame_ns + 1);
    return StepResult{};
  };
  executive.run_minor_frame();
  EXPECT_EQ(events(StatusCode::frame_overrun).size(), 2U) << "after a quiet minute it is news again";
}

TEST_F(ExecutiveTest, TimingTellsHowLateFramesBeginAndHowLongTheyTake) {
  assemble({.parameters = &mission, .real_time = true});
  ASSERT_TRUE(executive.start().ok());
  // On time and empty; 5 us late; 300 us late and 100 ms long, which is too long.
  executive.run_minor_frame(0);
  clock.pass(minor_frame_ns + 5 * ns_per_us);
  executive.run_minor_frame(minor_frame_ns);
  clock.sleep_until(2 * minor_frame_ns + 300 * ns_per_us);
  a.on_step = [&] {
    clock.pass(minor_frame_ns);
    return StepResult{};
  };
  executive.run_minor_frame(2 * minor_frame_ns);
  ASSERT_TRUE(executive.write_housekeeping().ok());
  TimingRecord timing;
  ASSERT_TRUE(get(store, 1, timing).ok());
  EXPECT_EQ(timing.frames, 3);
  EXPECT_EQ(timing.overruns, 1U);
  EXPECT_EQ(timing.latest_ns, 300 * ns_per_us);
  EXPECT_EQ(timing.longest_ns, minor_frame_ns);
  EXPECT_EQ(timing.late[0], 1U);
  EXPECT_EQ(timing.late[3], 1U) << "4 to 8 us";
  EXPECT_EQ(timing.late[9], 1U) << "256 to 512 us";
  EXPECT_EQ(timing.used[0], 2U);
  EXPECT_EQ(timing.used[17], 1U) << "65.5 to 131 ms";
}

TEST_F(ExecutiveTest, HousekeepingIsWrittenEverySoOftenInRealTimeOnly) {
  mission.housekeeping_period_s = 2;
  start();
  run_frames(50);
  std::int64_t count = -1;
  ASSERT_TRUE(store.count(record_info<ComponentRecord>(), count).ok());
  EXPECT_EQ(count, 0) << "its processor times would make flights differ";
  assemble({.parameters = &mission, .real_time = true});
  start();
  TimingRecord timing;
  ASSERT_TRUE(get(store, 1, timing).ok());
  const std::int64_t first = timing.frames;
  run_frames(19);
  ASSERT_TRUE(get(store, 1, timing).ok());
  EXPECT_EQ(timing.frames, first);
  run_frames(1);
  ASSERT_TRUE(get(store, 1, timing).ok());
  EXPECT_EQ(timing.frames, first + 20);
  ASSERT_TRUE(store.count(record_info<ComponentRecord>(), count).ok());
  EXPECT_EQ(count, 3);
}

TEST_F(ExecutiveTest, OverloadLowersTheLevelOfWorkAndRestRestoresIt) {
  mission.recovery_windows = 2;
  assemble({.parameters = &mission, .real_time = true});
  start();
  TimingRecord timing;
  a.on_step = [&] {
    clock.pass(2 * minor_frame_ns);
    return StepResult{};
  };
  for (int i = 0; i < 52; ++i) executive.run_minor_frame();
  ASSERT_TRUE(get(store, 1, timing).ok());
  EXPECT_EQ(timing.degraded, 1);
  EXPECT_EQ(timing.degraded_changes, 1U);
  const std::vector<EventRecord> reduced = events(StatusCode::work_reduced);
  ASSERT_EQ(reduced.size(), 1U);
  EXPECT_EQ(reduced[0].a, 1);
  EXPECT_EQ(reduced[0].b, static_cast<std::int64_t>(LoadReason::overruns));
  a.on_step = nullptr;
  run_frames(1);
  run_frames(350);
  ASSERT_TRUE(get(store, 1, timing).ok());
  EXPECT_EQ(timing.degraded, 0);
  EXPECT_EQ(timing.degraded_changes, 2U);
  EXPECT_EQ(events(StatusCode::work_restored).size(), 1U);
}

TEST_F(ExecutiveTest, FramesThatWaitWithoutRestLowerTheLevelOfWorkInRealTimeOnly) {
  stages[2].period = 0;
  for (const bool real_time : {false, true}) {
    assemble({.parameters = &mission, .real_time = real_time});
    start();
    write<FrameRecord>(20);
    b.on_step = [&] {
      clock.pass(30 * ns_per_ms);
      return StepResult{{}, true};
    };
    run_frames(103);
    EXPECT_EQ(events(StatusCode::work_reduced).size(), real_time ? 1U : 0U);
  }
  EXPECT_EQ(events(StatusCode::work_reduced)[0].b, static_cast<std::int64_t>(LoadReason::frames));
}

TEST_F(ExecutiveTest, TheLevelOfWorkOutlivesARestartInRealTimeAndIsNoneInVirtualTime) {
  TimingRecord timing{.degraded = 2};
  test::write_records(store, timing);
  Executive on_board(stages, components, store, clock, {.parameters = &mission, .real_time = true});
  ASSERT_TRUE(on_board.start().ok());
  EXPECT_EQ(on_board.timing().degraded, 2);
  ASSERT_TRUE(get(store, 1, timing).ok());
  EXPECT_EQ(timing.degraded, 2);
  ASSERT_TRUE(executive.start().ok());
  EXPECT_EQ(executive.timing().degraded, 0);
  ASSERT_TRUE(get(store, 1, timing).ok());
  EXPECT_EQ(timing.degraded, 0);
}

TEST(FrameTiming, BinsArePowersOfTwoOfAMicrosecond) {
  EXPECT_EQ(timing_bin(-5), 0U);
  EXPECT_EQ(timing_bin(ns_per_us - 1), 0U);
  EXPECT_EQ(timing_bin(ns_per_us), 1U);
  EXPECT_EQ(timing_bin(2 * ns_per_us), 2U);
  EXPECT_EQ(timing_bin(4 * ns_per_us - 1), 2U);
  EXPECT_EQ(timing_bin(3600 * ns_per_s), limits::timing_bins - 1);
}

TEST(FrameTiming, FramesThatWereSleptThroughAreLeftOut) {
  EXPECT_EQ(next_frame_begin(500, 500), 500 + minor_frame_ns);
  EXPECT_EQ(next_frame_begin(0, minor_frame_ns + 1), minor_frame_ns) << "a little late: the next one follows at once";
  EXPECT_EQ(next_frame_begin(0, 2 * minor_frame_ns - 1), minor_frame_ns);
  EXPECT_EQ(next_frame_begin(0, 2 * minor_frame_ns), 2 * minor_frame_ns);
  EXPECT_EQ(next_frame_begin(7, 7 + 93 * minor_frame_ns + 5), 7 + 93 * minor_frame_ns);
}

TEST_F(ExecutiveTest, AFaultIsCountedAndReportedAndTheComponentGoesOn) {
  start();
  write<FrameRecord>(1);
  b.on_step = [&] {
    b.on_step = nullptr;
    return StepResult{{StatusCode::too_few_matches, 7, 20}, true};
  };
  executive.run_minor_frame();
  EXPECT_EQ(diary, "abb");
  EXPECT_EQ(stats(1).faults, 1U);
  EXPECT_EQ(stats(1).restarts, 0U);
  const std::vector<EventRecord> reported = events(StatusCode::too_few_matches);
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_STREQ(reported[0].component, "b");
  EXPECT_EQ(reported[0].a, 7);
  EXPECT_EQ(reported[0].b, 20);
  EXPECT_EQ(reported[0].severity, static_cast<std::uint8_t>(Severity::medium));
}

/// Counts its inputs in memory and in its checkpoint; its third input brings a wrong state and an assertion with it.
class Counter final : public Component {
 public:
  explicit Counter(Store& store) : store_(store) {}
  [[nodiscard]] const char* name() const override { return "counter"; }
  Status restore() override {
    cursor_ = {};
    count = 0;
    const Status status = load_checkpoint(store_, form, cursor_, count);
    return status.is(StatusCode::not_found) ? Status{} : status;
  }
  StepResult step() override {
    FrameRecord frame;
    if (!next(store_, cursor_.first, frame).ok()) return {};
    ++count;
    cursor_.first = frame.id;
    if (frame.id == 3 && !recovered) {
      recovered = true;
      count = -1000;
      assertion_line = __LINE__ + 1;
      ILP_ASSERT_STEP(count > 0, count);
    }
    Transaction transaction(store_);
    Status status = transaction.begin();
    if (status.ok()) status = save_checkpoint(store_, form, cursor_, count);
    if (status.ok()) status = transaction.commit();
    return {status, true};
  }

  std::int64_t count = 0;
  int assertion_line = 0;
  bool recovered = false;

 private:
  static constexpr CheckpointForm form = checkpoint_form<std::int64_t>(ComponentId{1}, 1);

  Store& store_;
  Cursor cursor_;
};

TEST_F(ExecutiveTest, AFailedAssertionRestartsTheComponentFromItsCheckpoint) {
  Counter counter(store);
  components[1] = &counter;
  start();
  for (std::int64_t id = 1; id <= 5; ++id) write<FrameRecord>(id);
  executive.run_minor_frame();
  EXPECT_EQ(counter.count, 2) << "two inputs are in the checkpoint; what failed waits for the next frame";
  EXPECT_EQ(stats(1).restarts, 1U);
  EXPECT_EQ(stats(1).faults, 1U);
  next_frame();
  executive.run_minor_frame();
  EXPECT_EQ(counter.count, 5);
  EXPECT_EQ(stats(1).restarts, 1U);

  const std::vector<EventRecord> failed = events(StatusCode::assertion_failed);
  ASSERT_EQ(failed.size(), 1U);
  EXPECT_STREQ(failed[0].component, "counter");
  EXPECT_STREQ(failed[0].place, "test_executive.cpp");
  EXPECT_EQ(failed[0].a, counter.assertion_line);
  EXPECT_EQ(failed[0].b, -1000);
  const std::vector<EventRecord> restarted = events(StatusCode::component_restarted);
  ASSERT_EQ(restarted.size(), 1U);
  EXPECT_EQ(restarted[0].a, 2) << "as in the component table, from 1";
}

TEST_F(ExecutiveTest, AComponentThatAssertsForEverIsTriedOnceAFrameAndStopsNobody) {
  start();
  b.on_step = [] { return StepResult{assertion_failure(__FILE__, __LINE__, 5), true}; };
  a.on_step = [&] {
    write<FrameRecord>(executive.frames_run());
    return StepResult{};
  };
  c.on_step = [&] { return StepResult{}; };
  run_frames(9);
  EXPECT_EQ(a.steps, 1 + 9);
  EXPECT_EQ(b.steps, 1 + 9);
  EXPECT_EQ(c.steps, 1 + 3);
  EXPECT_EQ(stats(1).restarts, 9U);
  EXPECT_EQ(b.restores, 1 + 9);
}

TEST_F(ExecutiveTest, AComponentThatFailsForEverWithoutProgressDoesNotFloodTheEventLog) {
  start();
  b.on_step = [] { return StepResult{{StatusCode::too_few_matches, 5}, true}; };
  write<FrameRecord>(1);
  run_frames(10);
  EXPECT_EQ(a.steps, 1 + 10);
  EXPECT_EQ(c.steps, 1 + 3);
  EXPECT_EQ(events(StatusCode::too_few_matches).size(), static_cast<std::size_t>(EventLog::burst));
  EXPECT_LE(stats(1).faults, 10U * max_faults_in_a_row);
  EXPECT_GE(stats(1).faults, 10U) << "it is tried again in every frame";
  ASSERT_TRUE(executive.end().ok());
  const std::vector<EventRecord> more = events(StatusCode::events_repeated);
  ASSERT_EQ(more.size(), 1U);
  EXPECT_EQ(EventLog::burst + more[0].a, stats(1).faults);
}

TEST_F(ExecutiveTest, ManyFaultsThatAreFollowedByProgressAllPass) {
  // Every second input is bad: nothing of it may wait for a later frame.
  start();
  int left = 1000;
  b.on_step = [&] {
    --left;
    return StepResult{left % 2 == 0 ? Status{StatusCode::overlap_unknown, left} : Status{}, left > 0};
  };
  write<FrameRecord>(1);
  executive.run_minor_frame();
  EXPECT_EQ(left, 0);
}

TEST_F(ExecutiveTest, HousekeepingTellsWhatTheStatisticsSay) {
  start();
  a.on_step = [&] {
    clock.pass(budget + 1);
    return StepResult{{StatusCode::frame_gap, 1, 2}, false};
  };
  executive.run_minor_frame();
  ASSERT_TRUE(executive.write_housekeeping().ok());
  std::int64_t count = 0;
  ASSERT_TRUE(store.count(record_info<ComponentRecord>(), count).ok());
  EXPECT_EQ(count, 3);
  ComponentRecord record;
  ASSERT_TRUE(get(store, 1, record).ok());
  EXPECT_STREQ(record.name, "a");
  EXPECT_EQ(record.steps, 2U);
  EXPECT_EQ(record.overruns, 1U);
  EXPECT_EQ(record.faults, 1U);
  EXPECT_EQ(record.busy_ns, budget + 1);
  EXPECT_EQ(record.longest_ns, budget + 1);
}

TEST_F(ExecutiveTest, EventNumbersGoOnAfterARestart) {
  start();
  executive.events().report(5, "a", StatusCode::io_error);
  Executive again(stages, components, store, clock);
  ASSERT_TRUE(again.start().ok());
  again.events().report(6, "a", StatusCode::io_error);
  EventRecord newest;
  ASSERT_TRUE(last(store, newest).ok());
  EXPECT_EQ(newest.id, 2);
  EXPECT_EQ(newest.time_ns, 6);
  EXPECT_EQ(again.events().lost(), 0U);
}

TEST_F(ExecutiveTest, EventsOfTwoProcessesDoNotReplaceEachOther) {
  EventLog one(store), other(store);
  one.report(1, "a", StatusCode::io_error);
  other.report(2, "b", StatusCode::io_error);
  one.report(3, "a", StatusCode::io_error);
  EXPECT_EQ(events(StatusCode::io_error).size(), 3U);
}

TEST_F(ExecutiveTest, APartOfTheScheduleKeepsTheNumbersOfTheWhole) {
  const Stage row = stage_of(ComponentId::dense_matcher);
  constexpr auto number = static_cast<std::int64_t>(ComponentId::dense_matcher);
  Component* const part[] = {&c};
  Executive node(std::span(&row, 1), part, store, clock, {.shares_flight = true});
  ASSERT_TRUE(node.start().ok());
  c.on_step = [] { return StepResult{StatusCode::assertion_failed, true}; };
  node.run_minor_frame();
  const std::vector<EventRecord> restarted = events(StatusCode::component_restarted);
  ASSERT_FALSE(restarted.empty());
  EXPECT_EQ(restarted[0].a, number);
  ASSERT_TRUE(node.write_housekeeping().ok());
  TimingRecord timing;
  EXPECT_TRUE(get(store, number, timing).ok());
  EXPECT_FALSE(get(store, 1, timing).ok()) << "that is the head's";
}

TEST_F(ExecutiveTest, WhatOtherProcessesWaitForGoesBeforeTheRest) {
  stages[1].writes = mask_of(RecordType::pose);
  stages[2].period = 0;
  assemble({.shares_flight = true});
  start();
  int left_of_b = 2, left_of_c = 3;
  b.on_step = [&] { return StepResult{{}, --left_of_b > 0}; };
  c.on_step = [&] {
    if (left_of_c == 3) write<FrameRecord>(1);
    return StepResult{{}, --left_of_c > 0};
  };
  write<OverlapRecord>(1);
  executive.run_minor_frame();
  EXPECT_EQ(diary, "acbbcc");
}

TEST_F(ExecutiveTest, WhatNobodyWaitsForCanBePutOff) {
  stages[1].writes = mask_of(RecordType::pose);
  stages[2].period = 0;
  assemble({.shares_flight = true});
  start();
  write<OverlapRecord>(1);
  write<FrameRecord>(1);
  executive.put_off(true);
  run_frames(2);
  EXPECT_EQ(diary, "aba");
  EXPECT_FALSE(executive.idle()) << "its work is not done";
  executive.put_off(false);
  run_frames(1);
  EXPECT_EQ(diary, "abaac");
  EXPECT_TRUE(executive.idle());
}

TEST_F(ExecutiveTest, WhoFoundTheStoreFullTriesAgainWithoutBeingWoken) {
  start();
  write<OverlapRecord>(1);
  int refusals = 2;
  c.on_step = [&] { return refusals-- > 0 ? StepResult{{StatusCode::store_full, 1}, true} : StepResult{}; };
  stages[2].period = 0;
  executive.run_minor_frame();
  next_frame();
  EXPECT_EQ(events(StatusCode::store_full).size(), 1U) << "not again and again in one minor frame";
  EXPECT_FALSE(executive.idle()) << "its work is not done";
  run_frames(2 * static_cast<int>(full_store_retry_frames) + 1);
  EXPECT_LT(refusals, 0);
  EXPECT_TRUE(executive.idle());
}

TEST_F(ExecutiveTest, TheGroundRestartsAComponentOnce) {
  start();
  const int restores = b.restores;
  CommandRecord command{.id = 1, .kind = CommandKind::restart, .subject_id = 2};
  CommandRecord unknown = command;
  unknown.id = 2;
  unknown.subject_id = 99;
  test::write_records(store, command, unknown);
  run_frames(3);
  EXPECT_EQ(b.restores, restores + 1);
  ASSERT_EQ(events(StatusCode::component_restarted).size(), 1U);
  EXPECT_EQ(events(StatusCode::component_restarted)[0].a, 2);
  // After a start of the whole flight it is past.
  start();
  EXPECT_EQ(events(StatusCode::component_restarted).size(), 1U);
}

}  // namespace
}  // namespace ilp
