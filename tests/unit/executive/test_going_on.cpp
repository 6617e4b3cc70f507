// Components that cannot be restored, faults that pass, and memory that has changed without a step.
#include "tests/support/failing_store.hpp"
#include "tests/unit/executive/executive_fixture.hpp"

namespace ilp {
namespace {

using test::ExecutiveTest;

TEST_F(ExecutiveTest, WhatNoWaitingHealsFailsTheStart) {
  for (const StatusCode code : {StatusCode::store_build, StatusCode::store_schema, StatusCode::store_damaged}) {
    b.on_restore = [code] { return Status{code, 11}; };
    EXPECT_EQ(executive.start().code, code);
  }
}

TEST_F(ExecutiveTest, WhoCannotBeRestoredAtTheStartWaitsAndTheOthersFly) {
  b.on_restore = [&] { return b.restores < 3 ? Status{StatusCode::store_error, 11} : Status{}; };
  ASSERT_TRUE(executive.start().ok());
  EXPECT_FALSE(executive.idle()) << "its work is not done";
  executive.run_minor_frame();
  EXPECT_EQ(diary, "ac") << "tried again in the next frame at the earliest";
  next_frame();
  run_frames(5);
  EXPECT_EQ(b.restores, 3);
  EXPECT_EQ(b.steps, 1);
  EXPECT_TRUE(executive.idle());
}

TEST_F(ExecutiveTest, AfterAFaultThatMayPassTheNextTriesAreFartherAndFartherApart) {
  start();
  std::vector<std::int64_t> tried;
  bool broken = true;
  b.on_step = [&]() -> StepResult {
    tried.push_back(executive.frames_run());
    if (broken) return {{StatusCode::store_error, 10}, false};
    return {};
  };
  const std::int64_t first = executive.frames_run();
  write<FrameRecord>(1);
  run_frames(300);
  std::vector<std::int64_t> apart;
  for (std::size_t i = 1; i < tried.size(); ++i) apart.push_back(tried[i] - tried[i - 1]);
  EXPECT_EQ(tried.at(0), first);
  EXPECT_EQ(apart, (std::vector<std::int64_t>{1, 2, 4, 8, 16, 32, 64, 64, 64}));
  EXPECT_FALSE(executive.idle()) << "nobody else would wake it";
  broken = false;
  run_frames(64);
  EXPECT_TRUE(executive.idle());
  EXPECT_EQ(tried.size(), 11U);
  // A good step: the next fault is the first again.
  broken = true;
  write<FrameRecord>(2);
  run_frames(3);
  EXPECT_EQ(tried.size(), 11U + 2);
}

TEST_F(ExecutiveTest, WhoWaitsForAFaultToPassIsNotWokenMeanwhile) {
  start();
  b.on_step = [] { return StepResult{{StatusCode::store_error, 10}, true}; };
  for (int frame = 0; frame < 8; ++frame) {
    write<FrameRecord>(frame + 1);
    run_frames(1);
  }
  EXPECT_EQ(b.steps, 1 + 4) << "in frames 0, 1, 3 and 7";
  EXPECT_EQ(a.steps, 1 + 8);
}

TEST_F(ExecutiveTest, WhoCouldNotBeRestoredDoesNotStepUntilItIs) {
  start();
  int failures = 5;
  // The component itself is valid again at once: only its checkpoint could not be read.
  b.on_step = [&]() -> StepResult {
    b.on_step = nullptr;
    b.on_restore = [&] { return failures-- > 0 ? Status{StatusCode::store_error, 10} : Status{}; };
    return {assertion_failure(__FILE__, __LINE__, 1), true};
  };
  for (int frame = 0; frame < 16; ++frame) {
    write<FrameRecord>(frame + 1);
    run_frames(1);
  }
  EXPECT_EQ(b.steps, 1 + 1) << "what it has in memory is not what is in the store";
  EXPECT_EQ(b.restores, 1 + 5) << "in frames 0, 1, 3, 7 and 15";
  EXPECT_FALSE(executive.idle());
  run_frames(17);
  EXPECT_EQ(b.restores, 1 + 6);
  EXPECT_EQ(b.steps, 1 + 2);
  EXPECT_TRUE(executive.idle());
  const std::vector<EventRecord> waiting = events(StatusCode::component_waiting);
  ASSERT_EQ(waiting.size(), 1U) << "said once";
  EXPECT_STREQ(waiting[0].component, "b");
  EXPECT_EQ(waiting[0].a, 2);
  EXPECT_EQ(waiting[0].b, static_cast<std::int64_t>(StatusCode::store_error));
  const std::vector<EventRecord> resumed = events(StatusCode::component_resumed);
  ASSERT_EQ(resumed.size(), 1U);
  EXPECT_EQ(resumed[0].b, 5);
}

TEST_F(ExecutiveTest, ATimeDrivenComponentWaitsForItsRestoreToo) {
  start();
  a.on_step = [&]() -> StepResult {
    a.on_step = nullptr;
    a.on_restore = [&] { return a.restores < 4 ? Status{StatusCode::store_error, 10} : Status{}; };
    return {assertion_failure(__FILE__, __LINE__, 1), true};
  };
  run_frames(3);
  EXPECT_EQ(a.steps, 1 + 1);
  run_frames(1);
  EXPECT_EQ(a.steps, 1 + 2);
}

TEST_F(ExecutiveTest, AStepThatAsksForItIsRestoredBeforeTheNextOne) {
  start();
  b.on_step = [&]() -> StepResult {
    b.on_step = nullptr;
    return {{StatusCode::numerical_failure, 3}, true, Then::restore};
  };
  write<FrameRecord>(1);
  executive.run_minor_frame();
  EXPECT_EQ(diary, "abb");
  EXPECT_EQ(b.restores, 1 + 1);
}

TEST_F(ExecutiveTest, UpdatesOfARestoreAreReportedAndItRuns) {
  start();
  b.on_restore = [] { return Status{StatusCode::checkpoint_older, 2, 7}; };
  b.on_step = [&]() -> StepResult {
    b.on_step = nullptr;
    return {assertion_failure(__FILE__, __LINE__, 1), true};
  };
  write<FrameRecord>(1);
  run_frames(2);
  EXPECT_EQ(b.steps, 1 + 2);
  const std::vector<EventRecord> reported = events(StatusCode::checkpoint_older);
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_EQ(reported[0].b, 7);
  EXPECT_TRUE(events(StatusCode::component_waiting).empty());
}

TEST_F(ExecutiveTest, MemoryThatNobodyChangedIsNoticedBeforeItActs) {
  std::int64_t cursor = 0;
  b.keeps = &cursor;
  b.on_restore = [&] {
    cursor = 5;
    return Status{};
  };
  start();
  std::vector<std::int64_t> acted_on;
  b.on_step = [&]() -> StepResult {
    acted_on.push_back(cursor++);
    return {};
  };
  write<FrameRecord>(1);
  run_frames(1);
  write<FrameRecord>(2);
  run_frames(1);
  EXPECT_EQ(acted_on, (std::vector<std::int64_t>{5, 6})) << "what its own steps change is no damage";
  cursor ^= std::int64_t{1} << 40U;
  write<FrameRecord>(3);
  run_frames(2);
  EXPECT_EQ(acted_on, (std::vector<std::int64_t>{5, 6, 5})) << "from its checkpoint";
  const std::vector<EventRecord> reported = events(StatusCode::memory_damaged);
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_EQ(reported[0].a, 2);
}

TEST_F(ExecutiveTest, AFlippedBitInTheExecutivesOwnMemoryIsMendedAndTold) {
  start();
  const std::int64_t before = executive.timing().frames;
  auto& slot = const_cast<ComponentStats&>(stats(1));
  const std::uint32_t steps = slot.steps;
  slot.steps ^= 1U << 20U;
  run_frames(1);
  EXPECT_EQ(stats(1).steps, steps);
  EXPECT_EQ(executive.timing().frames, before + 1);
  const std::vector<EventRecord> reported = events(StatusCode::memory_damaged);
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_EQ(reported[0].a, 0);
  EXPECT_FALSE(executive.restart_wanted());
}

TEST_F(ExecutiveTest, AParameterThatNobodySetIsMendedBeforeTheNextStepAndOneThatAStepSetIsKept) {
  assemble({.parameters = &mission});
  start();
  const double wanted = mission.target_overlap;
  double seen = 0;
  a.on_step = [&]() -> StepResult {
    seen = mission.target_overlap;
    mission.min_overlap = 0.25;
    return {{}, false, Then::go_on, true};
  };
  mission.target_overlap = -7;
  run_frames(2);
  EXPECT_EQ(seen, wanted);
  EXPECT_EQ(mission.min_overlap, 0.25);
  EXPECT_EQ(events(StatusCode::memory_damaged).size(), 1U);
  // Within the step of one that sets none.
  b.on_step = [&]() -> StepResult {
    mission.min_overlap = 9;
    return {};
  };
  write<FrameRecord>(1);
  run_frames(1);
  EXPECT_EQ(mission.min_overlap, 0.25);
  EXPECT_EQ(events(StatusCode::memory_damaged).size(), 2U);
}

TEST_F(ExecutiveTest, ADamagedCommandKeepsNobodyFromTheNextOnes) {
  test::FailingStore failing(store);
  Executive other(stages, components, failing, clock);
  ASSERT_TRUE(other.start().ok());
  CommandRecord command{.kind = CommandKind::restart, .subject_id = 2};
  for (command.id = 1; command.id <= 2; ++command.id) test::write_records(store, command);
  failing.damage(RecordType::command, 1);
  const int restores = b.restores;
  other.run_minor_frame();
  other.run_minor_frame();
  EXPECT_EQ(b.restores, restores + 1);
}

/// Its cursor and state change only after a commit.
class CommittingComponent final : public Component {
 public:
  explicit CommittingComponent(Store& store) : wiring_{store} {}
  [[nodiscard]] const char* name() const override { return "committing"; }
  Status restore() override {
    ++outside.restores;
    state_.count = outside.saved;
    return {};
  }
  StepResult step() override {
    ++outside.steps;
    if (outside.before_commit) outside.before_commit(*this);
    Status status;
    if (outside.commits) {
      Transaction transaction(wiring_.store);
      status = transaction.begin();
      if (status.ok()) status = transaction.commit();
      if (!status.ok()) return {status, false};
      outside.saved = ++state_.count;
    }
    return {};
  }
  [[nodiscard]] LastingMemory lasting() const override {
    const LastingMemory memory =
        LastingMemory::of(*this, wiring_, cursor_, state_, work_, outside).changed_by_commits();
    return outside.kept == nullptr ? memory : memory.keeping(*outside.kept);
  }
  void flip_state() { state_.count ^= 1U << 9U; }
  void flip_work() { work_.count ^= 1U << 9U; }
  void flip_reference() { reinterpret_cast<std::byte*>(this)[sizeof(void*)] ^= std::byte{1}; }
  [[nodiscard]] std::uint32_t state() const { return state_.count; }

 private:
  struct Wiring {
    Store& store;
  };
  struct alignas(8) Counter {
    std::uint32_t count = 0;
  };
  Wiring wiring_;
  Counter cursor_, state_, work_;

 public:
  struct Outside {
    std::uint32_t saved = 0;
    int steps = 0, restores = 0;
    bool commits = true;
    std::uint32_t* kept = nullptr;  ///< where its work is in the memory of a step
    std::function<void(CommittingComponent&)> before_commit;
  } outside;
};

class CommittingTest : public testing::Test {
 protected:
  CommittingTest() { EXPECT_TRUE(executive_.start().ok()); }
  std::size_t reported() { return test::events_of(store_, StatusCode::memory_damaged).size(); }

  std::vector<std::byte> region_ = std::vector<std::byte>(std::size_t{1} << 20U);
  RamStore store_{region_};
  StepStore steps_{store_};
  test::FakeClock clock_;
  CommittingComponent component_{steps_};
  Stage stage_{.component = ComponentId{1}, .name = "committing", .period = 1, .budget_ns = 20 * ns_per_ms};
  Component* components_[1] = {&component_};
  Executive executive_{{&stage_, 1}, components_, store_, clock_, {.steps = &steps_}};
};

TEST_F(CommittingTest, AStateThatFlipsOnTheWayToACommitIsNotCommitted) {
  executive_.run_minor_frame();
  ASSERT_EQ(component_.state(), 1U);
  component_.outside.before_commit = [](CommittingComponent& c) { c.flip_state(); };
  executive_.run_minor_frame();
  EXPECT_EQ(component_.outside.saved, 1U) << "it was committed";
  EXPECT_EQ(component_.state(), 1U) << "it has not gone back";
  EXPECT_EQ(reported(), 1U);
  component_.outside.before_commit = {};
  executive_.run_minor_frame();
  EXPECT_EQ(component_.state(), 2U);
}

TEST_F(CommittingTest, AStateThatFlipsInAStepWithoutACommitIsNotTakenForItsOwn) {
  component_.outside.commits = false;
  component_.outside.before_commit = [](CommittingComponent& c) { c.flip_state(); };
  executive_.run_minor_frame();
  executive_.run_minor_frame();
  EXPECT_EQ(component_.outside.steps, 1) << "it took a step with the flipped state";
  EXPECT_EQ(component_.state(), 0U);
  EXPECT_EQ(reported(), 1U);
}

/// Its state is a vector that is never full.
class GrowingComponent final : public Component {
 public:
  [[nodiscard]] const char* name() const override { return "growing"; }
  Status restore() override {
    ++restores;
    return {};
  }
  StepResult step() override { return {elements.push_back(7) ? Status{} : StatusCode::capacity_exceeded, false}; }
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory::of(*this, wiring, restores, elements)
        .without(memory_between(elements.end(), elements.data() + elements.capacity()));
  }

  FixedVector<std::uint64_t, 1000> elements;
  std::int64_t wiring = 0, restores = 0;
};

/// Its steps say before whether they change the state.
class RestingComponent final : public Component {
 public:
  [[nodiscard]] const char* name() const override { return "resting"; }
  Status restore() override {
    ++outside.restores;
    state = 0;
    return {};
  }
  StepResult step() override {
    if (!outside.rests || outside.flips) ++state;
    return {};
  }
  [[nodiscard]] LastingMemory lasting() const override {
    const LastingMemory memory = LastingMemory::of(*this, wiring, cursor, state, NoMembers{}, outside);
    return outside.rests ? memory.at_rest() : memory;
  }

  std::int64_t wiring = 0, cursor = 0, state = 0;
  struct alignas(8) {
    int restores = 0;
    bool rests = false, flips = false;
  } outside;
};

TEST_F(CommittingTest, AStateThatFlipsInAStepThatDoesNotChangeItIsFoundBeforeTheNextStep) {
  RestingComponent resting;
  Component* components[1] = {&resting};
  Executive executive({&stage_, 1}, components, store_, clock_);
  ASSERT_TRUE(executive.start().ok());
  executive.run_minor_frame();
  resting.outside.rests = true;
  executive.run_minor_frame();
  executive.run_minor_frame();
  EXPECT_EQ(resting.state, 1U);
  EXPECT_EQ(resting.outside.restores, 1);
  resting.outside.flips = true;
  executive.run_minor_frame();
  executive.run_minor_frame();
  EXPECT_EQ(resting.state, 0U) << "it took a step with the flipped state";
  EXPECT_EQ(resting.outside.restores, 2);
}

TEST_F(CommittingTest, OnlyElementsThatAreThereAreCompared) {
  GrowingComponent growing;
  Component* components[1] = {&growing};
  Executive executive({&stage_, 1}, components, store_, clock_);
  ASSERT_TRUE(executive.start().ok());
  executive.run_minor_frame();
  executive.run_minor_frame();
  ASSERT_EQ(growing.restores, 1);
  growing.elements.data()[2] ^= 1U << 9U;
  executive.run_minor_frame();
  EXPECT_EQ(growing.restores, 1) << "the third element is written before it is read";
  growing.elements.data()[2] ^= 1U << 9U;
  executive.run_minor_frame();
  EXPECT_EQ(growing.restores, 2);
}

TEST_F(CommittingTest, WorkThatFlipsBetweenTwoStepsIsDoneAgain) {
  executive_.run_minor_frame();
  const int restores = component_.outside.restores;
  component_.flip_work();
  executive_.run_minor_frame();
  EXPECT_EQ(component_.outside.restores, restores + 1);
  EXPECT_EQ(reported(), 1U);
  EXPECT_FALSE(executive_.restart_wanted());
}

TEST_F(CommittingTest, WhereKeptWorkIsMayFlipOnlyWhileNobodyKeepsIt) {
  std::uint32_t place = 7;
  component_.outside.before_commit = [&](CommittingComponent& c) { c.outside.kept = &place; };
  executive_.run_minor_frame();
  const int restores = component_.outside.restores;
  place ^= 1U << 9U;
  executive_.run_minor_frame();
  EXPECT_EQ(component_.outside.restores, restores + 1);
  EXPECT_EQ(reported(), 1U);
  component_.outside.before_commit = [](CommittingComponent& c) { c.outside.kept = nullptr; };
  executive_.run_minor_frame();
  place ^= 1U << 9U;
  executive_.run_minor_frame();
  EXPECT_EQ(reported(), 1U) << "others use the memory";
}

TEST_F(CommittingTest, AReferenceThatFlipsIsNeverFollowedAndAsksForANewProcess) {
  executive_.run_minor_frame();
  const int steps = component_.outside.steps, restores = component_.outside.restores;
  component_.flip_reference();
  executive_.run_minor_frame();
  executive_.run_minor_frame();
  EXPECT_EQ(component_.outside.steps, steps);
  EXPECT_EQ(component_.outside.restores, restores);
  EXPECT_TRUE(executive_.restart_wanted());
  component_.flip_reference();
}

TEST_F(CommittingTest, ConstantsThatFlipAskForANewProcess) {
  std::uint64_t constant = 5;
  Executive executive({&stage_, 1}, components_, store_, clock_, {.constants = memory_of(constant)});
  ASSERT_TRUE(executive.start().ok());
  executive.run_minor_frame();
  EXPECT_FALSE(executive.restart_wanted());
  constant ^= 1U;
  executive.run_minor_frame();
  EXPECT_TRUE(executive.restart_wanted());
}

}  // namespace
}  // namespace ilp
