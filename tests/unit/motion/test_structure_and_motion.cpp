// Keyframes to poses over terrain given by a formula: what a keyframe that cannot be read, a restart, a store that
// fails and a damaged checkpoint cost.
#include <cmath>
#include <set>

#include "tests/support/step_memory.hpp"
#include "tests/unit/motion/structure_fixture.hpp"

namespace ilp {
namespace {

using test::height;
using test::keyframes;
using test::rugged;
using test::step_m;
using test::views;

using StructureAndMotionTest = test::StructureFixture;

TEST_F(StructureAndMotionTest, PosesBecomeFinalInOrderAndAreTrue) {
  test::ExecutedComponent run(*component, store);
  ASSERT_TRUE(run.start().ok());
  for (int frame = 0; frame < 20'000 && finals() < keyframes; ++frame) {
    run.frame();
    for (std::int64_t id = 2; id <= keyframes; ++id) {
      EXPECT_FALSE(state(id) == PoseState::final && state(id - 1) != PoseState::final) << id;
    }
  }
  ASSERT_EQ(finals(), keyframes);
  // The altitude of the first gives the scale; the strip's world begins at the first camera.
  const auto first = read<PoseRecord>(1);
  for (std::int64_t id = 2; id <= keyframes; ++id) {
    const auto pose = read<PoseRecord>(id);
    EXPECT_EQ(pose.strip_id, 1);
    double squares = 0;
    for (int i = 0; i < 3; ++i) squares += (pose.centre[i] - first.centre[i]) * (pose.centre[i] - first.centre[i]);
    const Vec3 truth = test::centre_of(views()[static_cast<std::size_t>(id - 1)].cam_from_world) -
                       test::centre_of(views()[0].cam_from_world);
    EXPECT_NEAR(std::sqrt(squares) / truth.norm(), 1, 0.05) << id;
  }
  EXPECT_EQ(strip_ends_commanded(), 0);
}

TEST_F(StructureAndMotionTest, AKeyframeThatCannotBeReadFailsAndTheStripGoesOn) {
  release_image(5);
  run_to_the_end();
  for (std::int64_t id = 1; id <= keyframes; ++id) {
    EXPECT_EQ(state(id), id == 5 ? PoseState::failed : PoseState::final) << id;
  }
  EXPECT_EQ(strip_ends_commanded(), 0);
}

TEST_F(StructureAndMotionTest, TwoThatCannotBeReadEndTheStripOnce) {
  release_image(5);
  release_image(6);
  run_to_the_end();
  for (std::int64_t id = 1; id <= keyframes; ++id) {
    EXPECT_EQ(state(id), id >= 5 ? PoseState::failed : PoseState::final) << id;
  }
  EXPECT_EQ(strip_ends_commanded(), 1);
}

TEST_F(StructureAndMotionTest, RestartedInTheMiddleOfEveryKeyframeItLeavesTheSameRecords) {
  const Result wanted = undisturbed();
  fly_in_short_boots();
  EXPECT_EQ(result(), wanted);
}

TEST_F(StructureAndMotionTest, AfterAReadErrorInARestoreThePosesAreThoseOfTheUndisturbedFlight) {
  const Result wanted = undisturbed();
  test::ExecutedComponent run(*component, store);
  ASSERT_TRUE(run.start().ok());
  run_until(run, store, 6);
  int left = 3;
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool hit = call.type == RecordType::checkpoint && call.kind == test::StoreCall::read_blob && left-- > 0;
    return hit ? Status{StatusCode::store_error, 10} : Status{};
  });
  command_restart();
  ASSERT_TRUE(run.run());
  EXPECT_LT(left, 0) << "the store failed as it should";
  EXPECT_EQ(result(), wanted);
}

TEST_F(StructureAndMotionTest, WhereKeptWorkIsInTheMemoryOfAStepIsComparedBetweenSteps) {
  ASSERT_TRUE(restored(component->restore()));
  std::byte* const memory = test::step_memory<StructureAndMotion>().bytes.data();
  auto& features = *std::launder(reinterpret_cast<FeatureScratch*>(memory));
  auto& sequence = *std::launder(reinterpret_cast<SequenceWorkspace*>(memory));
  const auto sum = [&] {
    const LastingMemory lasting = component->lasting();
    return lasting.checksum(lasting.state_checksum());
  };
  const auto notices = [&](auto& value) {
    const std::uint64_t before = sum();
    auto* const octet = reinterpret_cast<std::byte*>(&value);
    *octet ^= std::byte{1};
    const bool differs = sum() != before;
    *octet ^= std::byte{1};
    return differs;
  };
  int kept = 0, corners = 0, matches = 0, pairs = 0;
  for (bool pending = true; pending;) {
    const StepResult result = component->step();
    ASSERT_TRUE(result.status.ok());
    pending = result.pending;
    const bool keeps = result.then == Then::keep;
    kept += keeps ? 1 : 0;
    corners += notices(features.harris.progress.next_row) ? 1 : 0;
    matches += notices(features.matcher.progress.next) ? 1 : 0;
    pairs += notices(sequence.two_view.progress.part) ? 1 : 0;
    EXPECT_LE(corners + matches + pairs, kept) << "where nothing is kept, others use the memory";
  }
  EXPECT_GE(corners, keyframes);
  EXPECT_GE(matches, keyframes - 1);
  EXPECT_GE(pairs, 3 * (keyframes - 1));
}

TEST_F(StructureAndMotionTest, EveryReadOfAnImageMayFailOnce) {
  const Result wanted = undisturbed();
  std::set<std::int64_t> failed;
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool hit =
        call.type == RecordType::frame && call.kind == test::StoreCall::read_blob && failed.insert(call.id).second;
    return hit ? Status{StatusCode::store_error, 10} : Status{};
  });
  run_to_the_end();
  EXPECT_EQ(failed.size(), static_cast<std::size_t>(keyframes));
  EXPECT_EQ(result(), wanted);
}

TEST_F(StructureAndMotionTest, EveryCommitMayFailOnce) {
  const Result wanted = undisturbed();
  bool fail_next = true;
  failing.judge_by([&](const test::FailingStore::Call& call) {
    if (call.kind != test::StoreCall::commit) return Status{};
    fail_next = !fail_next;
    return fail_next ? Status{} : Status{StatusCode::store_error, 10};
  });
  run_to_the_end();
  EXPECT_EQ(result(), wanted);
}

TEST_F(StructureAndMotionTest, AnImageThatIsNeverReadIsGivenUpAfterStatedAttempts) {
  std::uint32_t tried = 0;
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool hit = call.type == RecordType::frame && call.kind == test::StoreCall::read_blob && call.id == 5;
    tried += hit ? 1 : 0;
    return hit ? Status{StatusCode::store_error, 10} : Status{};
  });
  test::ExecutedComponent run(*component, store);
  ASSERT_TRUE(run.start().ok());
  ASSERT_TRUE(run.run());
  EXPECT_EQ(tried, most_read_attempts);
  EXPECT_LT(run.now(), 100 * ns_per_s) << "in virtual time nothing else takes any";
  EXPECT_EQ(state(5), PoseState::failed);
  EXPECT_EQ(finals(), keyframes - 1);
}

TEST_F(StructureAndMotionTest, WhereTheNewerCheckpointIsDamagedTheSameRecordsAreMadeAgain) {
  const Result wanted = undisturbed();
  {
    test::ExecutedComponent run(*component, store);
    ASSERT_TRUE(run.start().ok());
    run_until(run, store, 7);
  }
  const std::vector<CheckpointRecord> two = checkpoints();
  ASSERT_EQ(two.size(), 2U);
  flip_a_bit_of(two[0].generation > two[1].generation ? two[0] : two[1]);
  component = std::make_unique<StructureAndMotion>(failing, mission, test::step_memory<StructureAndMotion>());
  run_to_the_end();
  EXPECT_EQ(result(), wanted);
  EXPECT_EQ(strip_ends_commanded(), 0);
}

TEST_F(StructureAndMotionTest, WhereBothAreDamagedNothingFinalChangesAndTheRestOfTheStripIsGivenUp) {
  const Result wanted = undisturbed();
  {
    test::ExecutedComponent run(*component, store);
    ASSERT_TRUE(run.start().ok());
    run_until(run, store, 7);
  }
  std::set<std::int64_t> final_before;
  for (std::int64_t id = 1; id <= keyframes; ++id) {
    if (state(id) == PoseState::final) final_before.insert(id);
  }
  ASSERT_GE(final_before.size(), 2U);
  for (const CheckpointRecord& record : checkpoints()) flip_a_bit_of(record);
  component = std::make_unique<StructureAndMotion>(failing, mission, test::step_memory<StructureAndMotion>());
  run_to_the_end();
  const Result found = result();
  for (std::int64_t id = 1; id <= keyframes; ++id) {
    const auto at = static_cast<std::size_t>(id - 1);
    if (final_before.contains(id)) {
      EXPECT_EQ(found.poses.at(at), wanted.poses.at(at)) << id;
    } else {
      EXPECT_EQ(state(id), PoseState::failed) << "nobody waits for it for ever: " << id;
    }
  }
  EXPECT_EQ(strip_ends_commanded(), 1) << "the next strip has a world of its own";
}

/// The first `still` keyframes are from one place, where the camera only turns.
template <std::int64_t still>
const std::vector<test::View>& views_from_one_place() {
  static const std::vector<test::View> rendered = [] {
    std::vector<test::View> made;
    for (std::int64_t i = 0; i < keyframes; ++i) {
      const auto step = static_cast<double>(std::max<std::int64_t>(i + 1 - still, 0));
      const Vec3 turn =
          i < still ? Vec3(0.03 * static_cast<double>(i), -0.05 * static_cast<double>(i), 0.1) : Vec3::Zero();
      made.push_back(test::render_view(test::distorting_camera(), test::looking_down({step_m * step, 0, height}, turn),
                                       rugged, 2, 1, static_cast<std::uint64_t>(i + 1)));
    }
    return made;
  }();
  return rendered;
}

class BeginningTest : public StructureAndMotionTest {
 protected:
  BeginningTest() : StructureAndMotionTest(views_from_one_place<3>()) {}
};

class LateBeginningTest : public StructureAndMotionTest {
 protected:
  LateBeginningTest() : StructureAndMotionTest(views_from_one_place<6>()) {}
};

TEST_F(LateBeginningTest, OfMoreKeyframesThanMayWaitTheOldestFail) {
  run_to_the_end();
  for (std::int64_t id = 1; id <= keyframes; ++id) {
    EXPECT_EQ(state(id), id <= 2 ? PoseState::failed : PoseState::final) << id;
  }
  EXPECT_EQ(strip_ends_commanded(), 0);
}

TEST_F(BeginningTest, KeyframesThatWaitForABaselineGetTheirPoses) {
  test::ExecutedComponent run(*component, store);
  ASSERT_TRUE(run.start().ok());
  run_until(run, store, 3);
  for (std::int64_t id = 1; id <= 3; ++id) {
    EXPECT_EQ(state(id), PoseState::provisional) << id;
    EXPECT_EQ(read<PoseRecord>(id).verdict, PoseVerdict::waiting) << id;
  }
  for (int frame = 0; frame < 20'000 && finals() < keyframes; ++frame) {
    run.frame();
    for (std::int64_t id = 2; id <= keyframes; ++id) {
      EXPECT_FALSE(state(id) == PoseState::final && state(id - 1) != PoseState::final) << id;
    }
  }
  ASSERT_EQ(finals(), keyframes);
  const auto first = read<PoseRecord>(1);
  for (std::int64_t id = 2; id <= keyframes; ++id) {
    const auto pose = read<PoseRecord>(id);
    EXPECT_EQ(pose.verdict, PoseVerdict::ok) << id;
    const double from_first =
        (Vec3(pose.centre[0], pose.centre[1], pose.centre[2]) - Vec3(first.centre[0], first.centre[1], first.centre[2]))
            .norm();
    EXPECT_NEAR(from_first, step_m * static_cast<double>(std::max<std::int64_t>(id - 3, 0)), 0.05 * from_first + 0.3)
        << id;
  }
  EXPECT_EQ(strip_ends_commanded(), 0);
}

TEST_F(BeginningTest, RestartedInTheMiddleOfEveryKeyframeItLeavesTheSameRecords) {
  const Result wanted = undisturbed();
  fly_in_short_boots();
  EXPECT_EQ(result(), wanted);
}

TEST_F(BeginningTest, AStripThatOnlyTurnedHasNoPoseAndTheNextOneBegins) {
  StripRecord strip{.id = 1, .first_keyframe_id = 1, .last_keyframe_id = 3, .end = StripEnd::end_of_flight};
  write(strip);
  strip.id = 2;
  strip.first_keyframe_id = 4;
  strip.last_keyframe_id = keyframes;
  write(strip);
  for (std::int64_t id = 4; id <= keyframes; ++id) {
    auto keyframe = read<KeyframeRecord>(id);
    keyframe.strip_id = 2;
    keyframe.index -= 3;
    write(keyframe);
  }
  run_to_the_end();
  for (std::int64_t id = 1; id <= keyframes; ++id) {
    EXPECT_EQ(state(id), id <= 3 ? PoseState::failed : PoseState::final) << id;
  }
  EXPECT_EQ(read<PoseRecord>(1).verdict, PoseVerdict::waiting);
  EXPECT_EQ(read<PoseRecord>(2).verdict, PoseVerdict::two_view_failed);
}

TEST_F(BeginningTest, AShortStripBeginsWhenItEndsAndSoItDoesWithRestarts) {
  // With so few corners no pair is good enough to begin before.
  mission.corners = 40;
  StripRecord strip{.id = 1, .first_keyframe_id = 1, .last_keyframe_id = 4, .end = StripEnd::end_of_flight};
  write(strip);
  Result wanted;
  {
    test::ExecutedComponent run(*component, store);
    ASSERT_TRUE(run.start().ok());
    run_until(run, store, 4);
    for (std::int64_t id = 1; id <= 4; ++id) EXPECT_EQ(read<PoseRecord>(id).verdict, PoseVerdict::waiting) << id;
    ASSERT_TRUE(run.run());
    for (std::int64_t id = 1; id <= 4; ++id) EXPECT_EQ(state(id), PoseState::final) << id;
    wanted = result();
    forget();
  }
  for (int boot = 0; boot < 100 && result() != wanted; ++boot) {
    component = std::make_unique<StructureAndMotion>(failing, mission, test::step_memory<StructureAndMotion>());
    ASSERT_TRUE(component->restore().ok());
    for (int step = 0; step < 3 + boot; ++step) ASSERT_TRUE(component->step().status.ok());
  }
  EXPECT_EQ(result(), wanted);
}

}  // namespace
}  // namespace ilp
