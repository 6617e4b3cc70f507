#include <memory>
#include <vector>

#include "fsw/components/storage_manager.hpp"
#include "tests/unit/components/component_fixture.hpp"

namespace ilp {
namespace {

constexpr std::uint32_t frame_bytes = 4096;
constexpr std::uint32_t map_bytes = 1000;

class StorageManagerTest : public test::ComponentTest {
 protected:
  StorageManagerTest() { EXPECT_TRUE(manager->restore().ok()); }

  void add_frames(std::int64_t count) {
    for (std::int64_t i = 0; i < count; ++i) {
      FrameRecord frame;
      frame.id = ++frames;
      frame.image.bytes = frame_bytes;
      write(frame);
    }
  }
  void add_keyframe(std::int64_t id, std::int64_t frame_id) {
    KeyframeRecord keyframe;
    keyframe.id = id;
    keyframe.frame_id = frame_id;
    write(keyframe);
  }
  void add_depth(std::int64_t id) {
    DepthRecord depth;
    depth.id = id;
    depth.values.bytes = 2 * map_bytes;
    depth.sigma.bytes = map_bytes;
    depth.mask.bytes = 100;
    write(depth);
  }
  void add_product(std::int64_t keyframe_id, ProductKind kind, double priority = 0.5, std::uint32_t bytes = 5000,
                   ProductState state = ProductState::stored) {
    ProductRecord product;
    product.id = product_id(keyframe_id, kind);
    product.keyframe_id = keyframe_id;
    product.kind = kind;
    product.priority = priority;
    product.state = state;
    product.bytes = bytes;
    product.data.bytes = bytes;
    write(product);
  }
  void add_downlink(std::int64_t id, DownlinkKind kind, std::int64_t subject, std::int64_t records_through,
                    TimeNs acknowledged = 0) {
    DownlinkRecord sent;
    sent.id = id;
    sent.kind = kind;
    sent.subject_id = subject;
    sent.records_through = records_through;
    sent.acknowledged_ns = acknowledged;
    write(sent);
    ProductRecord product;
    if (acknowledged == 0 || kind != DownlinkKind::product || !get(store, subject, product).ok()) return;
    product.state = ProductState::acknowledged;
    write(product);
  }
  std::vector<std::int64_t> frames_held() {
    std::vector<std::int64_t> held;
    FrameRecord frame;
    for (std::int64_t id = 0; next(store, id, frame).ok(); id = frame.id) {
      if (frame.image.bytes != 0) held.push_back(frame.id);
    }
    return held;
  }
  std::vector<std::int64_t> products_held() {
    std::vector<std::int64_t> held;
    ProductRecord product;
    for (std::int64_t id = 0; next(store, id, product).ok(); id = product.id) {
      if (product.data.bytes != 0) held.push_back(product.id);
    }
    return held;
  }
  /// What really lies in the store, against what the account says.
  void expect_account_is_right() {
    std::int64_t frames_sum = 0, depth_sum = 0, product_sum = 0;
    FrameRecord frame;
    for (std::int64_t id = 0; next(store, id, frame).ok(); id = frame.id) frames_sum += frame.image.bytes;
    DepthRecord depth;
    for (std::int64_t id = 0; next(store, id, depth).ok(); id = depth.id) {
      depth_sum += std::int64_t{depth.values.bytes} + depth.sigma.bytes + depth.mask.bytes;
    }
    ProductRecord product;
    for (std::int64_t id = 0; next(store, id, product).ok(); id = product.id) product_sum += product.data.bytes;
    const auto account = read<StorageRecord>(1);
    EXPECT_EQ(account.frame_bytes, frames_sum);
    EXPECT_EQ(account.depth_bytes, depth_sum);
    EXPECT_EQ(account.product_bytes, product_sum);
  }
  using Ids = std::vector<std::int64_t>;

  std::int64_t frames = 0;
  std::unique_ptr<StorageManager> manager = std::make_unique<StorageManager>(store, mission);
};

TEST_F(StorageManagerTest, FramesGoOnlyWhenNothingNeedsThemAnyMore) {
  add_frames(3);
  run(*manager);
  EXPECT_EQ(frames_held(), (Ids{1, 2, 3})) << "no keyframe yet: any frame may become one";

  add_keyframe(1, 2);
  add_frames(4);
  add_keyframe(2, 5);
  run(*manager);
  EXPECT_EQ(frames_held(), (Ids{2, 3, 4, 5, 6, 7})) << "before the first keyframe's nothing is needed";

  add_product(1, ProductKind::depth);
  run(*manager);
  EXPECT_EQ(frames_held(), (Ids{2, 3, 4, 5, 6, 7})) << "the image of keyframe 1 is not yet coded";

  add_product(1, ProductKind::image);
  run(*manager);
  EXPECT_EQ(frames_held(), (Ids{5, 6, 7})) << "behind the newest keyframe the overlap checker may still choose";
  expect_account_is_right();
  EXPECT_EQ(read<StorageRecord>(1).frames_released, 4U);
  EXPECT_EQ(number_of<FrameRecord>(), 7) << "the records stay";
}

TEST_F(StorageManagerTest, DepthMapsGoWhenTheirRecordsAreWithTheLink) {
  add_depth(1);
  add_depth(2);
  run(*manager);
  EXPECT_NE(read<DepthRecord>(1).values.bytes, 0U);
  add_downlink(1, DownlinkKind::records, 1, 1);
  run(*manager);
  EXPECT_EQ(read<DepthRecord>(1).values.bytes, 0U);
  EXPECT_EQ(read<DepthRecord>(1).mask.bytes, 0U);
  EXPECT_NE(read<DepthRecord>(2).values.bytes, 0U);
  expect_account_is_right();
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

TEST_F(StorageManagerTest, BeyondTheBudgetTheLeastUnsentProductsGoAndNoMoreThanNeeded) {
  mission.storage_budget_mib = 1;
  constexpr std::uint32_t third = 400'000;
  add_product(1, ProductKind::image, 0.7, third);
  add_product(2, ProductKind::image, 0.1, third, ProductState::sent);
  add_product(3, ProductKind::image, 0.3, third);
  add_product(4, ProductKind::image, 0.5, third);
  const std::vector<Status> events = run(*manager);
  EXPECT_EQ(products_held(), (Ids{product_id(1, ProductKind::image), product_id(2, ProductKind::image)}));
  // One after the other, the least first, as soon as the budget is exceeded.
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].code, StatusCode::product_dropped);
  EXPECT_EQ(events[0].a, product_id(3, ProductKind::image));
  EXPECT_EQ(events[0].b, 300);
  EXPECT_EQ(events[1].a, product_id(4, ProductKind::image));
  EXPECT_EQ(read<ProductRecord>(product_id(3, ProductKind::image)).state, ProductState::dropped);
  EXPECT_EQ(read<StorageRecord>(1).products_dropped, 2U);
  expect_account_is_right();
}

TEST_F(StorageManagerTest, WithinTheBudgetNothingIsDropped) {
  mission.storage_budget_mib = 1;
  add_product(1, ProductKind::image, 0.7, 524'288);
  add_product(2, ProductKind::image, 0.1, 524'288);
  EXPECT_TRUE(run(*manager).empty());
  EXPECT_EQ(products_held().size(), 2U);
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

TEST_F(StorageManagerTest, WhatCannotBeDroppedIsKeptHoweverFull) {
  mission.storage_budget_mib = 1;
  add_product(1, ProductKind::image, 0.7, 800'000, ProductState::sent);
  add_product(2, ProductKind::image, 0.1, 800'000, ProductState::sent);
  EXPECT_TRUE(run(*manager).empty());
  EXPECT_EQ(products_held().size(), 2U);
}

TEST_F(StorageManagerTest, BeyondTheBudgetProductsThatWereGivenUpGoFirst) {
  mission.storage_budget_mib = 1;
  add_product(1, ProductKind::image, 0.1, 600'000);
  add_product(2, ProductKind::image, 0.9, 600'000, ProductState::dropped);
  run(*manager);
  EXPECT_EQ(products_held(), (Ids{product_id(1, ProductKind::image)}));
  expect_account_is_right();
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
    manager = std::make_unique<StorageManager>(store, mission);
    ASSERT_TRUE(manager->restore().ok());
    if (!manager->step(0).pending) break;
  }
  EXPECT_EQ(frames_held(), (Ids{6, 7, 8, 9, 10}));
  EXPECT_EQ(products_held(), (Ids{product_id(1, ProductKind::image)}));
  expect_account_is_right();
}

}  // namespace
}  // namespace ilp
