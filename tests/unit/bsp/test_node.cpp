#include "bsp/flight/node.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "bsp/flight/held_camera.hpp"
#include "bsp/flight/shared_flight_store.hpp"
#include "fsw/commanding/settings.hpp"
#include "fsw/shared/camera_on_record.hpp"
#include "hal/clock/virtual_clock.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "tests/support/store_records.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
namespace {

constexpr StageMask matcher = stage_bit(ComponentId::dense_matcher);
constexpr StageMask others = all_stages & ~primary_stages & ~matcher;

class NodeTest : public testing::Test {
 protected:
  template <typename Record>
  void write(const Record& record) {
    test::write_records(store_, record);
  }
  /// The process has looked for work and found none.
  void answer(Node& node, std::int64_t commits = 0) {
    std::int64_t question = 0;
    ASSERT_TRUE(node.question(question).ok());
    if (question != 0) {
      ASSERT_TRUE(node.answer(question, commits).ok());
    }
  }
  bool done(std::int64_t commits = 0) {
    const Result<bool> all = primary_.ask_whether_done(commits);
    EXPECT_TRUE(all.ok());
    return all.value();
  }
  void begin_all() {
    ASSERT_TRUE(primary_.begin("a", mission_).ok());
    ASSERT_TRUE(one_.begin("b", mission_).ok());
    ASSERT_TRUE(two_.begin("c", mission_).ok());
  }

  std::vector<std::byte> memory_ = std::vector<std::byte>(std::size_t{4} << 20U);
  RamStore store_{memory_};
  VirtualClock clock_{ns_per_s};
  MissionParameters mission_;
  Node primary_{store_, clock_, primary_stages}, one_{store_, clock_, matcher}, two_{store_, clock_, others};
};

TEST_F(NodeTest, AFlightIsDoneWhenAllWereIdleBetweenTwoAnswers) {
  begin_all();
  EXPECT_FALSE(done()) << "nobody was asked yet";
  answer(one_);
  EXPECT_FALSE(done()) << "one has not answered";
  answer(two_);
  EXPECT_FALSE(done()) << "a first answer does not say what happened before it";
  answer(one_);
  answer(two_);
  EXPECT_TRUE(done());
}

TEST_F(NodeTest, WorkBetweenTwoAnswersIsNoEnd) {
  begin_all();
  done();
  answer(one_);
  answer(two_);
  done();
  answer(one_);
  answer(two_, 1);  // it has written something that may wake the other one, which has answered already
  EXPECT_FALSE(done());
  answer(one_);
  answer(two_, 1);
  EXPECT_TRUE(done());
}

TEST_F(NodeTest, WorkOfThePrimaryIsNoEnd) {
  begin_all();
  done();
  answer(one_);
  answer(two_);
  done();
  answer(one_);
  answer(two_);
  EXPECT_FALSE(done(1));
}

TEST_F(NodeTest, AStageThatNobodyRunsIsNoEnd) {
  ASSERT_TRUE(primary_.begin("a", mission_).ok());
  ASSERT_TRUE(one_.begin("b", mission_).ok());
  for (int k = 0; k < 4; ++k) {
    EXPECT_FALSE(done());
    answer(one_);
  }
}

TEST_F(NodeTest, AProcessThatIsStartedAgainHasNotBeenIdle) {
  begin_all();
  done();
  answer(one_);
  answer(two_);
  done();
  answer(one_);
  Node again(store_, clock_, others);
  ASSERT_TRUE(again.begin("c", mission_).ok());
  answer(again);
  EXPECT_FALSE(done());
}

TEST_F(NodeTest, AnswersToAnEarlierPrimaryDoNotCount) {
  begin_all();
  done();
  answer(one_);
  answer(two_);
  done();
  answer(one_);
  answer(two_);
  Node next_primary(store_, clock_, primary_stages);
  ASSERT_TRUE(next_primary.begin("a", mission_).ok());
  for (int asked = 0; asked < 2; ++asked) {
    const Result<bool> all = next_primary.ask_whether_done(0);
    ASSERT_TRUE(all.ok());
    EXPECT_FALSE(all.value());
  }
}

TEST_F(NodeTest, ThePrimaryNoticesWhoComesWhoFallsSilentAndWhoComesBack) {
  ASSERT_TRUE(primary_.begin("a", mission_).ok());
  const auto look = [this] {
    Node::Update updates;
    EXPECT_TRUE(primary_.poll_other_nodes(10 * ns_per_s, updates).ok());
    return updates.change;
  };
  EXPECT_EQ(look(), Node::Change::none);
  ASSERT_TRUE(one_.begin("b", mission_).ok());
  EXPECT_EQ(look(), Node::Change::joined);
  EXPECT_EQ(look(), Node::Change::none);
  clock_.sleep_until(clock_.now() + 11 * ns_per_s);
  EXPECT_EQ(look(), Node::Change::silent);
  EXPECT_EQ(look(), Node::Change::none) << "told once";
  ASSERT_TRUE(one_.begin("b", mission_).ok());
  EXPECT_EQ(look(), Node::Change::joined);
}

TEST_F(NodeTest, AClockThatIsAnHourOffMakesNobodySilent) {
  ASSERT_TRUE(primary_.begin("a", mission_).ok());
  VirtualClock wrong(clock_.now() - 3600 * ns_per_s);
  Node node(store_, wrong, matcher);
  ASSERT_TRUE(node.begin("b", mission_).ok());
  Node::Update updates;
  ASSERT_TRUE(primary_.poll_other_nodes(10 * ns_per_s, updates).ok());
  EXPECT_EQ(updates.change, Node::Change::joined);
  ASSERT_TRUE(primary_.poll_other_nodes(10 * ns_per_s, updates).ok());
  EXPECT_EQ(updates.change, Node::Change::none);
}

TEST_F(NodeTest, WhoDiffersFromThePrimaryIsRefused) {
  ASSERT_TRUE(primary_.begin("a", mission_).ok());
  NodeRecord head;
  ASSERT_TRUE(find_primary(store_, head).ok());
  EXPECT_TRUE(check_primary(head, matcher, mission_).ok());
  EXPECT_STATUS(check_primary(head, matcher | stage_bit(ComponentId::downlink), mission_), stage_claimed);
  MissionParameters other = mission_;
  other.target_overlap = 0.85;
  EXPECT_STATUS(check_primary(head, matcher, other), node_differs);
  head.version[0] = 'x';
  EXPECT_STATUS(check_primary(head, matcher, mission_), store_build);
}

TEST_F(NodeTest, AFlightIsFoundOnceItsPrimaryHasWrittenIdentityAndCamera) {
  NodeRecord head;
  EXPECT_STATUS(find_flight(store_, matcher, mission_, head), not_ready);
  ASSERT_TRUE(primary_.begin("a", mission_).ok());
  EXPECT_STATUS(find_flight(store_, matcher, mission_, head), not_found);
  IdentityRecord identity{.keyframe_base = 4000, .record_base = 90000};
  write(identity);
  EXPECT_STATUS(find_flight(store_, matcher, mission_, head), not_found);
  write(camera_record(CameraModel{}));
  ASSERT_TRUE(find_flight(store_, matcher, mission_, head).ok());
  EXPECT_EQ(store_.id_base(RecordType::keyframe), 4000);
  EXPECT_EQ(store_.id_base(RecordType::event), 90000);
  ASSERT_TRUE(primary_.report_end().ok());
  EXPECT_STATUS(find_flight(store_, matcher, mission_, head), not_ready);
}

class OneImage final : public Camera {
 public:
  Status capture(TimeNs, FrameImage&, CameraFrame&) override {
    ++captures;
    return {};
  }
  int captures = 0;
};

TEST_F(NodeTest, TheCameraIsHeldUntilTheStripOfTheLatestFrameIsKnown) {
  OneImage camera;
  HeldCamera held(camera, store_);
  const auto image = std::make_unique<FrameImage>();
  const auto gives = [&] {
    CameraFrame frame;
    const Status status = held.capture(clock_.now(), *image, frame);
    EXPECT_EQ(held.held(), !status.ok());
    return status.ok();
  };
  CameraRecord model = camera_record(CameraModel{640, 480, 500, 500, 320, 240, 0, 0, 0, 0});
  write(model);
  EXPECT_TRUE(gives());
  FrameRecord frame{.id = 1};
  write(frame);
  EXPECT_FALSE(gives()) << "its overlap is not known";
  OverlapRecord overlap{.id = 1};
  write(overlap);
  EXPECT_TRUE(gives());
  KeyframeRecord keyframe{.id = 1};
  write(keyframe);
  EXPECT_FALSE(gives()) << "its pose may end the strip";
  PoseRecord pose{.id = 1};
  write(pose);
  EXPECT_TRUE(gives());
  ++model.revision;
  write(model);
  EXPECT_FALSE(gives()) << "all poses are made again with another camera";
  pose.camera_revision = model.revision;
  write(pose);
  EXPECT_TRUE(gives());
}

class IdleComponent final : public Component {
 public:
  [[nodiscard]] const char* name() const override { return "idle"; }
  Status restore() override { return {}; }
  StepResult step() override { return {}; }
};

TEST_F(NodeTest, ASettingOfThePrimaryIsInForceBeforeTheNextStep) {
  SharedFlightStore shared(store_);
  MissionParameters in_force = mission_;
  IdleComponent idle;
  Component* const components[] = {&idle};
  const Stage row = stage_of(ComponentId::dense_matcher);
  Executive executive(std::span(&row, 1), components, shared, clock_, {.parameters = &in_force});
  shared.follow(mission_, in_force, executive);
  ASSERT_TRUE(executive.start().ok());
  executive.run_minor_frame();
  EXPECT_EQ(in_force.target_overlap, mission_.target_overlap);

  const std::size_t overlap = find_parameter("overlap", "target_overlap");
  ASSERT_LT(overlap, parameter_count());
  test::in_transaction(store_, [&] { ASSERT_TRUE(write_setting(store_, overlap, 0.9, 0).ok()); });
  executive.run_minor_frame();
  EXPECT_EQ(in_force.target_overlap, 0.9);
  executive.run_minor_frame();
  EXPECT_EQ(in_force.target_overlap, 0.9) << "the guard of the parameters has taken it for damage";
}

TEST_F(NodeTest, StepsOfEveryStageCount) {
  IdleComponent idle;
  Component* const components[] = {&idle};
  for (const Stage& stage : schedule) {
    Executive executive(std::span(&stage, 1), components, store_, clock_);
    ASSERT_TRUE(executive.start().ok());
    executive.run_minor_frame();
    const StageMask mask = stage_bit(stage.component);
    Node node(store_, clock_, mask);
    ASSERT_TRUE(node.begin("a", mission_).ok());
    ASSERT_TRUE(node.keep_alive(executive, 0).ok());
    NodeRecord record;
    ASSERT_TRUE(get(store_, node_number(mask), record).ok());
    EXPECT_GE(record.steps, 1) << stage.name;
  }
}

TEST_F(NodeTest, OnlyWhatCanWakeAnotherProcessCountsAsWork) {
  SharedFlightStore shared(store_);
  const auto commit = [&](const auto& record) {
    Transaction transaction(shared);
    ASSERT_TRUE(transaction.begin().ok());
    ASSERT_TRUE(put(shared, record).ok());
    ASSERT_TRUE(transaction.commit().ok());
  };
  commit(CheckpointRecord{});
  commit(StorageRecord{});
  EXPECT_EQ(shared.waking_commits(), 0);
  commit(PoseRecord{});
  EXPECT_EQ(shared.waking_commits(), 1);
}

}  // namespace
}  // namespace ilp
