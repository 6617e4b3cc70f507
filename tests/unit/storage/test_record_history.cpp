// What of the past leaves the store, and when.
#include "tests/unit/storage/storage_fixture.hpp"

namespace ilp {
namespace {

using Ids = std::vector<std::int64_t>;

class FramesOfTheStore : public test::StorageManagerTest {};

TEST_F(FramesOfTheStore, HoveringKeepsOnlyTheFrameThatMayStillBecomeTheKeyframe) {
  add_frames(1);
  add_keyframe(1, 1);
  for (int i = 0; i < 400; ++i) {
    add_frames(1);
    // Least at frame 150.
    add_overlap(frames, OverlapDecision::skipped, 0.9 + 1e-4 * std::abs(static_cast<double>(frames) - 150));
    run(*manager);
  }
  EXPECT_EQ(frames_held(), (Ids{1, 150}));
  // The checker prefers the later one of two equals, and so does the store.
  add_frames(1);
  add_overlap(frames, OverlapDecision::skipped, 0.9);
  run(*manager);
  EXPECT_EQ(frames_held(), (Ids{1, frames}));
  expect_account_is_right();
}

TEST_F(FramesOfTheStore, AnUnrelatedFrameStaysUntilItIsDecidedThroughAnyDarkness) {
  add_frames(1);
  add_keyframe(1, 1);
  add_frames(1);
  add_overlap(2, OverlapDecision::rejected, 0, OverlapVerdict::overlap_unknown);
  for (int i = 0; i < 100; ++i) {
    add_frames(1);
    add_overlap(frames, OverlapDecision::rejected, 0, OverlapVerdict::too_dark);
    run(*manager);
  }
  EXPECT_EQ(frames_held(), (Ids{1, 2}));
  add_frames(1);
  add_overlap(frames, OverlapDecision::skipped, 0.9);
  run(*manager);
  EXPECT_EQ(frames_held(), (Ids{1, frames})) << "a frame that can be related settles it";
}

TEST_F(FramesOfTheStore, AFrameOfABurstIsNotKeptAndDisplacesNone) {
  add_frames(1);
  add_keyframe(1, 1);
  add_frames(1);
  add_overlap(2, OverlapDecision::skipped, 0.9);
  for (int i = 0; i < 3; ++i) {
    add_frames(1);
    add_overlap(frames, OverlapDecision::burst, 0.5);
  }
  run(*manager);
  EXPECT_EQ(frames_held(), (Ids{1, 2}));
  expect_account_is_right();
}

TEST_F(FramesOfTheStore, AFrameHeldBackThatBecomesTheKeyframeKeepsItsImageUntilItIsCoded) {
  add_frames(1);
  add_keyframe(1, 1);
  for (int i = 0; i < 5; ++i) {
    add_frames(1);
    add_overlap(frames, OverlapDecision::skipped, frames == 3 ? 0.8 : 0.9);
  }
  run(*manager);
  EXPECT_EQ(frames_held(), (Ids{1, 3}));
  add_keyframe(2, 3);
  add_frames(1);
  add_overlap(frames, OverlapDecision::skipped, 0.85);
  run(*manager);
  EXPECT_EQ(frames_held(), (Ids{1, 3, 7}));
  add_product(1, ProductKind::image);
  add_product(2, ProductKind::image);
  run(*manager);
  EXPECT_EQ(frames_held(), (Ids{3, 7})) << "the newest keyframe is what is compared with";
  add_keyframe(3, 7);
  run(*manager);
  EXPECT_EQ(frames_held(), (Ids{7}));
  expect_account_is_right();
}

TEST_F(FramesOfTheStore, WhenNobodyLooksAtFramesTheyAreThinnedOutEvenlyAndThatIsTold) {
  mission.storage_budget_mib = 2;
  mission.frame_share = 0.25;  // 128 frames
  add_frames(20);
  add_keyframe(1, 1);
  for (std::int64_t id = 2; id <= 20; ++id) add_overlap(id, OverlapDecision::skipped, 0.9);
  add_frames(300);
  const std::vector<Status> events = run(*manager, 5000);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].code, StatusCode::frames_thinned);
  const Ids held = frames_held();
  EXPECT_LE(held.size(), 128U);
  EXPECT_GT(held.size(), 60U);
  EXPECT_EQ(held[0], 1) << "the keyframe";
  EXPECT_EQ(held[1], 20) << "what may become one";
  EXPECT_EQ(held[2], 21) << "the next to be looked at";
  std::int64_t widest = 0;
  for (std::size_t i = 3; i < held.size(); ++i) widest = std::max(widest, held[i] - held[i - 1]);
  EXPECT_LE(widest, 4);
  EXPECT_EQ(read<StorageRecord>(1).frames_skipped, 320 - 18 - held.size());
  expect_account_is_right();
}

class RecordHistoryTest : public test::StorageManagerTest {
 protected:
  RecordHistoryTest() {
    mission.history_frames = 100;
    mission.history_keyframes = 100;
  }
  /// Everything that a keyframe and the frame before it leave, coded, sent and confirmed.
  void live(std::int64_t k, bool confirmed = true, bool product_held = false) {
    add_frames(2);
    CaptureRecord capture{.id = k, .state = CaptureState::exposed};
    write(capture);
    add_overlap(frames - 1, OverlapDecision::skipped);
    add_overlap(frames, OverlapDecision::selected);
    add_keyframe(k, frames);
    StripRecord strip{.id = (k - 1) / 10 + 1};
    strip.first_keyframe_id = 10 * strip.id - 9;
    strip.last_keyframe_id = k;
    strip.end = k % 10 == 0 ? StripEnd::overlap_lost : StripEnd::open;
    write(strip);
    CalibrationCheckRecord check{.id = strip.id};
    write(check);
    PoseRecord pose{.id = k, .state = PoseState::final};
    write(pose);
    StructureRecord structure{.id = k};
    structure.points.bytes = 50;
    write(structure);
    add_depth(k);
    RichnessRecord richness{.id = k};
    write(richness);
    add_product(k, ProductKind::depth);
    add_product(k, ProductKind::image);
    add_downlink(4 * k - 3, DownlinkKind::records, k, k, confirmed ? 9 : 0);
    add_downlink(4 * k - 2, DownlinkKind::product, product_id(k, ProductKind::depth), k, 9);
    add_downlink(4 * k - 1, DownlinkKind::product, product_id(k, ProductKind::image), k, product_held ? 0 : 9);
    add_downlink(4 * k, DownlinkKind::points, k, k, 9);
    run(*manager);
  }
  template <typename Record>
  bool has(std::int64_t id) {
    Record record;
    return get(store, id, record).ok();
  }
};

TEST_F(RecordHistoryTest, EveryTableIsBounded) {
  for (std::int64_t k = 1; k <= 400; ++k) live(k);
  constexpr std::int64_t slack = 12;
  EXPECT_LE(number_of<FrameRecord>(), 200 + slack);
  EXPECT_LE(number_of<OverlapRecord>(), 200 + slack);
  EXPECT_LE(number_of<CaptureRecord>(), 100 + slack);
  EXPECT_LE(number_of<KeyframeRecord>(), 100 + slack);
  EXPECT_LE(number_of<PoseRecord>(), 100 + slack);
  EXPECT_LE(number_of<StructureRecord>(), 100 + slack);
  EXPECT_LE(number_of<DepthRecord>(), 100 + slack);
  EXPECT_LE(number_of<RichnessRecord>(), 100 + slack);
  EXPECT_EQ(number_of<ProductRecord>(), 0);
  EXPECT_LE(number_of<StripRecord>(), 10 + slack);
  EXPECT_LE(number_of<CalibrationCheckRecord>(), 10 + slack);
  EXPECT_LE(number_of<DownlinkRecord>(), 400 + slack);
  for (std::int64_t k = 301; k <= 400; ++k) {
    ASSERT_TRUE(has<KeyframeRecord>(k) && has<PoseRecord>(k) && has<DepthRecord>(k) && has<RichnessRecord>(k)) << k;
    ASSERT_TRUE(has<FrameRecord>(2 * k) && has<OverlapRecord>(2 * k)) << k;
  }
  EXPECT_GT(read<StorageRecord>(1).rows_erased, 2000);
  expect_account_is_right();
}

TEST_F(RecordHistoryTest, WhatTheGroundHasNotConfirmedStaysTenTimesAsLong) {
  for (std::int64_t k = 1; k <= 300; ++k) live(k, k % 50 != 7);
  for (const std::int64_t k : {7, 57, 107, 157}) {
    EXPECT_TRUE(has<KeyframeRecord>(k) && has<PoseRecord>(k) && has<FrameRecord>(2 * k)) << k;
  }
  EXPECT_FALSE(has<KeyframeRecord>(8));
  EXPECT_FALSE(has<KeyframeRecord>(6));
  for (std::int64_t k = 301; k <= 1100; ++k) live(k);
  EXPECT_FALSE(has<KeyframeRecord>(7)) << "lost for ever";
  EXPECT_TRUE(has<KeyframeRecord>(157));
}

TEST_F(RecordHistoryTest, AKeyframeStaysAsLongAsAProductOfItIsHeld) {
  live(1, true, true);
  for (std::int64_t k = 2; k <= 300; ++k) live(k);
  EXPECT_TRUE(has<KeyframeRecord>(1) && has<StripRecord>(1));
  EXPECT_FALSE(has<StripRecord>(5)) << "it holds up no other one";
  EXPECT_EQ(products_held(), (Ids{product_id(1, ProductKind::image)}));
  add_downlink(3, DownlinkKind::product, product_id(1, ProductKind::image), 1, 9);
  run(*manager);
  EXPECT_TRUE(products_held().empty());
  EXPECT_FALSE(has<KeyframeRecord>(1));
}

TEST_F(RecordHistoryTest, AFileThatIsNeverConfirmedHoldsUpNoOtherOne) {
  for (std::int64_t k = 1; k <= 30; ++k) live(k, true, k == 1);
  EXPECT_EQ(products_held(), (Ids{product_id(1, ProductKind::image)}));
  EXPECT_EQ(read<StorageRecord>(1).products_acknowledged, 59U);
}

TEST_F(RecordHistoryTest, HoveringAndADeadCameraLeaveNoTrail) {
  add_frames(1);
  add_keyframe(1, 1);
  for (std::int64_t id = 1; id <= 1500; ++id) {
    CaptureRecord capture{.id = id, .state = CaptureState::no_frame};
    write(capture);
    if (id > 800) {
      add_frames(1);
      add_overlap(frames, OverlapDecision::skipped, id == 801 ? 0.83 : 0.95);
    }
    run(*manager);
  }
  EXPECT_LE(number_of<CaptureRecord>(), 110);
  EXPECT_LE(number_of<FrameRecord>(), 115);
  EXPECT_LE(number_of<OverlapRecord>(), 115);
  EXPECT_EQ(frames_held(), (Ids{1, 2})) << "the keyframe and the frame of least overlap";
  EXPECT_TRUE(has<OverlapRecord>(2));
  EXPECT_TRUE(has<FrameRecord>(2));
}

TEST_F(RecordHistoryTest, TheNewestEventsAndCommandsStay) {
  for (std::int64_t id = 1; id <= limits::max_commands + 40; ++id) {
    CommandRecord command{.id = id};
    write(command);
  }
  for (std::int64_t id = 1; id <= limits::max_events + 40; ++id) {
    EventRecord event{.id = id};
    write(event);
  }
  run(*manager);
  EXPECT_EQ(number_of<CommandRecord>(), limits::max_commands);
  EXPECT_EQ(number_of<EventRecord>(), limits::max_events);
  EXPECT_TRUE(has<EventRecord>(41));
  EXPECT_FALSE(has<EventRecord>(40));
}

TEST_F(RecordHistoryTest, AClockThatGoesBackwardsMakesNothingOlderThanNothing) {
  for (std::int64_t k = 1; k <= 5; ++k) {
    add_frames(1);
    KeyframeRecord keyframe{.id = k, .frame_id = frames, .time_ns = (10 - k) * ns_per_s};
    write(keyframe);
    add_product(k, ProductKind::image);
    run(*manager);
    EXPECT_EQ(read<StorageRecord>(1).oldest_age_ns, 0);
  }
  KeyframeRecord keyframe{.id = 6, .frame_id = frames + 1, .time_ns = 30 * ns_per_s};
  add_frames(1);
  write(keyframe);
  add_product(6, ProductKind::image);
  run(*manager);
  EXPECT_EQ(read<StorageRecord>(1).oldest_age_ns, 21 * ns_per_s) << "of keyframe 1";
}

}  // namespace
}  // namespace ilp
