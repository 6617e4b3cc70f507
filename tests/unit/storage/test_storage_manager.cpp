#include "tests/support/failing_store.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/unit/storage/storage_fixture.hpp"

namespace ilp {
namespace {

using test::StorageManagerTest;

TEST_F(StorageManagerTest, FramesGoOnlyWhenNothingNeedsThemAnyMore) {
  add_frames(3);
  run(*manager);
  EXPECT_EQ(frames_held(), (Ids{1, 2, 3})) << "no keyframe yet: any frame may become one";

  add_keyframe(1, 2);
  add_frames(4);
  add_keyframe(2, 5);
  run(*manager);
  EXPECT_EQ(frames_held(), (Ids{2, 5, 6, 7})) << "before the newest keyframe only keyframes are needed";

  add_product(1, ProductKind::depth);
  run(*manager);
  EXPECT_EQ(frames_held(), (Ids{2, 5, 6, 7})) << "the image of keyframe 1 is not yet coded";

  add_product(1, ProductKind::image);
  run(*manager);
  EXPECT_EQ(frames_held(), (Ids{5, 6, 7})) << "behind the newest keyframe the overlap checker may still choose";
  expect_account_is_right();
  EXPECT_EQ(read<StorageRecord>(1).frames_released, 4U);
  EXPECT_EQ(number_of<FrameRecord>(), 7) << "the records stay";
}

TEST_F(StorageManagerTest, DepthMapsGoWhenTheyAreCodedAndMasksWhenTheirRecordsAreConfirmed) {
  add_depth(1);
  add_depth(2);
  add_product(1, ProductKind::depth);
  run(*manager);
  EXPECT_NE(read<DepthRecord>(1).values.bytes, 0U) << "the image is coded with it";
  add_product(1, ProductKind::image);
  run(*manager);
  EXPECT_EQ(read<DepthRecord>(1).values.bytes, 0U);
  EXPECT_EQ(read<DepthRecord>(1).sigma.bytes, 0U);
  EXPECT_NE(read<MaskRecord>(1).code.bytes, 0U);
  EXPECT_NE(read<DepthRecord>(2).values.bytes, 0U);
  expect_account_is_right();
  add_downlink(1, DownlinkKind::records, 1, 1);
  run(*manager);
  EXPECT_NE(read<MaskRecord>(1).code.bytes, 0U) << "with the link is not confirmed";
  add_downlink(1, DownlinkKind::records, 1, 1, 5);
  run(*manager);
  EXPECT_EQ(read<MaskRecord>(1).code.bytes, 0U);
  EXPECT_NE(read<MaskRecord>(2).code.bytes, 0U);
  expect_account_is_right();
}

TEST_F(StorageManagerTest, AMaskIsCountedWhenItIsFinal) {
  add_depth(1);
  auto mask = read<MaskRecord>(1);
  mask.scope = MaskScope::strip;
  write(mask);
  run(*manager);
  EXPECT_EQ(number_of<StorageRecord>(), 0) << "its size may still change: nothing is counted";
  mask.scope = MaskScope::flight;
  mask.code.bytes = 30;
  write(mask);
  run(*manager);
  EXPECT_EQ(read<StorageRecord>(1).depth_bytes, 3 * test::map_bytes + 30);
  expect_account_is_right();
}

TEST_F(StorageManagerTest, PointsGoWhenTheGroundHasConfirmedThemAndNobodyNeedsThemInAnyOrder) {
  constexpr std::int64_t keyframes = 130;
  for (std::int64_t id = 1; id <= keyframes; ++id) {
    add_frames(1);
    add_keyframe(id, id);
    StructureRecord structure{.id = id};
    structure.points.bytes = 40;
    write(structure);
    add_product(id, ProductKind::image, 0.5, 10);
  }
  const auto held = [&] { return ids_of<StructureRecord>([](const auto& one) { return one.points.bytes != 0; }); };
  const auto step = [&] {
    for (int i = 0; i < 3; ++i) run(*manager);
    manager = std::make_unique<StorageManager>(store, mission, test::step_memory<StorageManager>());
    EXPECT_TRUE(manager->restore().ok());
  };
  step();
  EXPECT_EQ(held().size(), 130U);
  // All are with the link; 2, 20, 40 and 110 are confirmed.
  for (std::int64_t id = 1; id <= keyframes; ++id) {
    const bool confirmed = id == 2 || id == 20 || id == 40 || id == 110;
    add_downlink(id, DownlinkKind::points, id, keyframes, confirmed ? 5 : 0);
  }
  step();
  Ids expected;
  // The checks of the camera look at the newest 100: the frames of 29 keyframes at least have been passed.
  for (std::int64_t id = 1; id <= keyframes; ++id) {
    if (id != 2 && id != 20) expected.push_back(id);
  }
  EXPECT_EQ(held(), expected);
  for (std::int64_t id = keyframes + 1; id <= 2 * keyframes; ++id) {
    add_frames(1);
    add_keyframe(id, id);
    add_product(id, ProductKind::image, 0.5, 10);
  }
  step();
  std::erase(expected, 40);
  std::erase(expected, 110);
  EXPECT_EQ(held(), expected) << "what was confirmed earlier goes when its time has come";
  EXPECT_EQ(read<StorageRecord>(1).structure_bytes, 40 * static_cast<std::int64_t>(expected.size()));
  EXPECT_EQ(read<StorageRecord>(1).structures_dropped, 0U);
}

TEST_F(StorageManagerTest, WithoutAnyConfirmationMasksAndPointsGoWithTheHistory) {
  mission.history_keyframes = 100;
  for (std::int64_t id = 1; id <= 1105; id += id == 2 ? 1000 : 1) {
    add_frames(1);
    add_keyframe(id, frames);
    if (id > 1102) continue;
    add_depth(id);
    StructureRecord structure{.id = id};
    structure.points.bytes = 40;
    write(structure);
    add_product(id, ProductKind::image, 0.5, 10);
  }
  for (int i = 0; i < 3; ++i) run(*manager);
  EXPECT_EQ(read<MaskRecord>(1).code.bytes, 0U);
  EXPECT_NE(read<MaskRecord>(1002).code.bytes, 0U);
  EXPECT_EQ(read<StructureRecord>(2).points.bytes, 0U);
  EXPECT_NE(read<StructureRecord>(1003).points.bytes, 0U);
  EXPECT_EQ(read<StorageRecord>(1).structures_dropped, 2U);
}

TEST_F(StorageManagerTest, AProductGoesOnlyWhenTheGroundHasConfirmedIt) {
  add_product(1, ProductKind::depth);
  add_product(1, ProductKind::image, 0.5, 5000, ProductState::sent);
  add_downlink(1, DownlinkKind::product, product_id(1, ProductKind::image), 1);
  run(*manager);
  EXPECT_EQ(products_held().size(), 2U) << "sent is not confirmed";

  add_downlink(1, DownlinkKind::product, product_id(1, ProductKind::image), 1, 77);
  run(*manager);
  EXPECT_EQ(products_held(), (Ids{product_id(1, ProductKind::depth)}));
  EXPECT_EQ(read<StorageRecord>(1).products_acknowledged, 1U);
  EXPECT_EQ(read<StorageRecord>(1).products_dropped, 0U);
  expect_account_is_right();
}

TEST_F(StorageManagerTest, ConfirmedRecordsFilesAndUnknownProductsDeleteNothing) {
  add_product(1, ProductKind::image);
  add_downlink(1, DownlinkKind::records, product_id(1, ProductKind::image), 1, 50);
  add_downlink(2, DownlinkKind::product, 4444, 1, 60);
  EXPECT_TRUE(run(*manager).empty());
  EXPECT_EQ(products_held().size(), 1U);
}

TEST_F(StorageManagerTest, FramesThatNobodyNeedsGoBeforeAnyProduct) {
  mission.storage_budget_mib = 1;
  for (int i = 0; i < 4; ++i) add_frames(64);  // 1 MiB
  add_keyframe(1, 1);
  add_keyframe(2, 250);
  add_product(1, ProductKind::depth, 0.2, 10'000);
  add_product(1, ProductKind::image, 0.2, 10'000);
  EXPECT_TRUE(run(*manager, 5000).empty()) << "no product may be dropped while frames can go";
  EXPECT_EQ(products_held().size(), 2U);
  EXPECT_EQ(frames_held().size(), 256U - 249U);
}

TEST_F(StorageManagerTest, RestartedAtEveryStepItsAccountIsStillRight) {
  add_frames(10);
  add_keyframe(1, 2);
  add_keyframe(2, 6);
  add_depth(1);
  add_product(1, ProductKind::depth);
  add_product(1, ProductKind::image);
  add_downlink(1, DownlinkKind::records, 1, 1, 5);
  add_downlink(2, DownlinkKind::product, product_id(1, ProductKind::depth), 1, 6);
  for (int step = 0; step < 100; ++step) {
    manager = std::make_unique<StorageManager>(store, mission, test::step_memory<StorageManager>());
    ASSERT_TRUE(manager->restore().ok());
    if (!manager->step().pending) break;
  }
  EXPECT_EQ(frames_held(), (Ids{6, 7, 8, 9, 10}));
  EXPECT_EQ(products_held(), (Ids{product_id(1, ProductKind::image)}));
  expect_account_is_right();
}

TEST_F(StorageManagerTest, AProductThatTheGroundGivesUpIsDropped) {
  add_product(1, ProductKind::image);
  add_product(2, ProductKind::image);
  run(*manager);
  CommandRecord command{.id = 1, .kind = CommandKind::delete_product, .subject_id = product_id(1, ProductKind::image)};
  write(command);
  run(*manager);
  EXPECT_EQ(read<ProductRecord>(command.subject_id).state, ProductState::dropped);
  EXPECT_EQ(read<ProductRecord>(command.subject_id).data.bytes, 0U);
  EXPECT_EQ(read<ProductRecord>(product_id(2, ProductKind::image)).state, ProductState::stored);
  EXPECT_EQ(read<StorageRecord>(1).products_held, 1U);
  EXPECT_EQ(read<StorageRecord>(1).products_dropped, 1U);
  // One that is not there, and one that is made later.
  command.id = 2;
  command.subject_id = product_id(9, ProductKind::depth);
  write(command);
  command.id = 3;
  command.subject_id = product_id(2, ProductKind::image);
  write(command);
  run(*manager);
  EXPECT_EQ(read<StorageRecord>(1).products_held, 0U);
}

TEST_F(StorageManagerTest, ADamagedRecordKeepsNobodyFromTheRest) {
  add_frames(3);
  add_keyframe(1, 2);
  add_frames(4);
  add_keyframe(2, 5);
  add_depth(1);
  add_product(1, ProductKind::depth);
  add_product(1, ProductKind::image);
  test::FailingStore failing(store);
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool hit = call.kind == test::StoreCall::get && call.type == RecordType::frame && call.id == 1;
    return hit ? Status{StatusCode::record_damaged, call.id, static_cast<std::int64_t>(call.type)} : Status{};
  });
  manager = std::make_unique<StorageManager>(failing, mission, test::step_memory<StorageManager>());
  ASSERT_TRUE(manager->restore().ok());
  EXPECT_TRUE(run(*manager).empty());
  EXPECT_EQ(frames_held(), (Ids{1, 5, 6, 7})) << "all but the damaged one";
  EXPECT_EQ(read<DepthRecord>(1).values.bytes, 0U);
}

TEST_F(StorageManagerTest, BehindADamagedCheckpointItsAccountIsRightAgain) {
  for (const bool newer_only : {true, false}) {
    SCOPED_TRACE(newer_only);
    const std::int64_t first = number_of<KeyframeRecord>() + 1, frames_before = number_of<FrameRecord>();
    add_frames(3);
    add_keyframe(first, frames_before + 2);
    run(*manager);
    add_frames(4);
    add_keyframe(first + 1, frames_before + 5);
    add_depth(first);
    add_product(first, ProductKind::depth);
    add_product(first, ProductKind::image);
    run(*manager);
    const auto released = read<StorageRecord>(1).frames_released;
    damage_checkpoints(newer_only);
    manager = std::make_unique<StorageManager>(store, mission, test::step_memory<StorageManager>());
    EXPECT_EQ(manager->restore().code, newer_only ? StatusCode::checkpoint_older : StatusCode::checkpoint_lost);
    add_frames(1);
    run(*manager);
    expect_account_is_right();
    EXPECT_EQ(read<StorageRecord>(1).frames_released, released) << "totals stay";
  }
}

}  // namespace
}  // namespace ilp
