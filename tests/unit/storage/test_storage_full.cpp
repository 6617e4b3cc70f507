// A full store is a mode: what is deleted first, what is never deleted, and what is reported.
#include <limits>
#include <map>

#include "fsw/vision/codec/jp2_file.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/unit/storage/storage_fixture.hpp"

namespace ilp {
namespace {

using Ids = std::vector<std::int64_t>;

class StorageFull : public test::StorageManagerTest {
 protected:
  StorageFull() {
    mission.storage_budget_mib = 1;
    // Products of about 4 kB: two of them fit, three do not.
    mission.product_share = 0.01;
    mission.high_watermark = 0.95;
    mission.low_watermark = 0.9;
  }
  static std::int64_t image(std::int64_t keyframe_id) { return product_id(keyframe_id, ProductKind::image); }
  [[nodiscard]] static double quota() { return 0.01 * 1048576; }
  static std::vector<StatusCode> codes(const std::vector<Status>& events) {
    std::vector<StatusCode> all;
    for (const Status& event : events) all.push_back(event.code);
    return all;
  }
  void expect_complete_file(const ProductRecord& product) {
    const std::vector<std::uint8_t> bytes = data_of(product);
    EXPECT_EQ(crc32(bytes), product.crc32);
    EXPECT_EQ(bytes.size(), product.bytes);
    EXPECT_EQ(product.layer_bytes[product.layers - 1], product.bytes);
    for (std::size_t i = product.layers; i < limits::max_quality_layers; ++i) EXPECT_EQ(product.layer_bytes[i], 0U);
    Jpeg2000Info info;
    ASSERT_TRUE(read_jpeg2000_header(bytes, info).ok());
    EXPECT_EQ(info.layers, product.layers);
  }
};

TEST_F(StorageFull, LastLayersOfTheLeastValuableGoFirstDownToTheLowWatermarkAndNoFurther) {
  for (std::int64_t k = 1; k <= 3; ++k) add_coded_product(k, 0.2 * static_cast<double>(k), 0, static_cast<int>(k));
  const std::vector<Status> events = run(*manager);
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events[0].code, StatusCode::storage_tight);
  EXPECT_EQ(events.back().code, StatusCode::storage_relieved);
  EXPECT_EQ(events.size(), 2U) << "layers are counted, not told one by one";
  EXPECT_EQ(products_held().size(), 3U) << "no product is lost";
  const auto least = read<ProductRecord>(image(1));
  const auto best = read<ProductRecord>(image(3));
  EXPECT_LT(least.layers, 4);
  EXPECT_GE(best.layers, least.layers);
  for (std::int64_t k = 1; k <= 3; ++k) expect_complete_file(read<ProductRecord>(image(k)));

  const auto account = read<StorageRecord>(1);
  EXPECT_LE(static_cast<double>(account.product_bytes), 0.9 * quota());
  EXPECT_GT(account.layers_cut, 0U);
  EXPECT_GT(account.cut_bytes, 0);
  EXPECT_EQ(account.products_dropped, 0U);
  EXPECT_EQ(account.full, 0);
  EXPECT_EQ(account.times_full, 1U);
  expect_account_is_right();
}

TEST_F(StorageFull, ACutProductIsTheOneThatCuttingOnceMakes) {
  mission.product_share = 0.01;
  for (std::int64_t k = 1; k <= 4; ++k) add_coded_product(k, 0.5, 0, static_cast<int>(k));
  run(*manager);
  for (std::int64_t k = 1; k <= 4; ++k) {
    const auto product = read<ProductRecord>(image(k));
    std::vector<std::uint8_t> whole;
    const ProductRecord made = test::coded_product(k, ProductKind::image, static_cast<int>(k), whole);
    std::size_t bytes = 0;
    ASSERT_TRUE(truncate_to_layers(whole, product.layers, bytes).ok());
    whole.resize(bytes);
    EXPECT_EQ(data_of(product), whole) << k;
    EXPECT_EQ(product.bytes, made.layer_bytes[product.layers - 1]);
  }
}

TEST_F(StorageFull, WhatHasGoneToTheLinkKeepsItsBytes) {
  add_coded_product(1, 0.1, 4, 1);  // all of it, unconfirmed
  add_coded_product(2, 0.1, 2, 2);  // two layers of four
  add_coded_product(3, 0.9, 0, 3);
  const std::vector<std::uint8_t> sent = data_of(read<ProductRecord>(image(1)));
  mission.product_share = 0.01 / 2;
  run(*manager);
  EXPECT_EQ(data_of(read<ProductRecord>(image(1))), sent);
  const auto half = read<ProductRecord>(image(2));
  EXPECT_EQ(half.layers, 2) << "the layers on their way stay";
  EXPECT_EQ(half.state, ProductState::sent) << "all that is left of it is on its way";
  expect_complete_file(half);
  EXPECT_EQ(products_held(), (Ids{image(1), image(2)})) << "the unsent one is dropped whole at the end";
  EXPECT_EQ(read<StorageRecord>(1).full, 1) << "what is left cannot go";
  expect_account_is_right();
}

TEST_F(StorageFull, AProductWhoseLastUnsentLayersGoWhenTheRestIsConfirmedIsDone) {
  ProductRecord product = add_coded_product(1, 0.1, 1, 1);
  product.layers_held = 1;
  write(product);
  add_coded_product(2, 0.9, 0, 2);
  add_coded_product(3, 0.9, 0, 3);
  mission.product_share = 0.001;
  run(*manager);
  run(*manager);
  ProductRecord gone;
  EXPECT_TRUE(get(store, image(1), gone).is(StatusCode::not_found)) << "the ground holds all that was left of it";
  EXPECT_EQ(read<StorageRecord>(1).products_acknowledged, 1U);
}

TEST_F(StorageFull, WholeProductsGoOnlyWhenNoLayerIsLeftAndTheLeastFirst) {
  mission.product_share = 1;
  constexpr std::uint32_t third = 400'000;
  add_product(1, ProductKind::image, 0.7, third);
  add_product(2, ProductKind::image, 0.1, third, ProductState::sent);
  add_product(3, ProductKind::image, 0.3, third);
  add_product(4, ProductKind::image, 0.5, third);
  const std::vector<Status> events = run(*manager);
  EXPECT_EQ(products_held(), (Ids{image(1), image(2)}));
  EXPECT_EQ(codes(events), (std::vector{StatusCode::storage_tight, StatusCode::product_dropped,
                                        StatusCode::product_dropped, StatusCode::storage_relieved}));
  EXPECT_EQ(events[1].a, image(3));
  EXPECT_EQ(events[1].b, 300);
  EXPECT_EQ(events[2].a, image(4));
  EXPECT_EQ(read<ProductRecord>(image(3)).state, ProductState::dropped);
  EXPECT_EQ(read<StorageRecord>(1).products_dropped, 2U);
  EXPECT_EQ(read<StorageRecord>(1).dropped_bytes, 2 * std::int64_t{third});
  expect_account_is_right();
}

TEST_F(StorageFull, UpToTheHighWatermarkNothingGoes) {
  mission.product_share = 1;
  add_product(1, ProductKind::image, 0.7, 498'000);
  add_product(2, ProductKind::image, 0.1, 498'000);
  EXPECT_TRUE(run(*manager).empty());
  EXPECT_EQ(products_held().size(), 2U);
  EXPECT_EQ(read<StorageRecord>(1).full, 0);
}

TEST_F(StorageFull, WhatCannotGoIsKeptHoweverFullAndIsToldOnce) {
  mission.product_share = 1;
  add_product(1, ProductKind::image, 0.7, 800'000, ProductState::sent);
  add_product(2, ProductKind::image, 0.1, 800'000, ProductState::sent);
  EXPECT_EQ(codes(run(*manager)), (std::vector{StatusCode::storage_tight}));
  add_frames(1);
  EXPECT_TRUE(run(*manager).empty());
  EXPECT_EQ(products_held().size(), 2U);
}

TEST_F(StorageFull, AQuotaSmallerThanOneProductLeavesTheFlightGoing) {
  mission.product_share = 0.01;
  mission.storage_budget_mib = 1;
  mission.high_watermark = 0.1;
  mission.low_watermark = 0.05;
  for (std::int64_t k = 1; k <= 3; ++k) {
    add_coded_product(k, 0.5, 0, static_cast<int>(k));
    run(*manager);
    EXPECT_LE(static_cast<double>(read<StorageRecord>(1).product_bytes), 0.1 * quota());
  }
  EXPECT_EQ(read<StorageRecord>(1).products_dropped, 3U);
  expect_account_is_right();
}

TEST_F(StorageFull, DamagedBytesAreFoundWhenAProductIsCutAndItIsGivenUpWithAWord) {
  for (std::int64_t k = 1; k <= 3; ++k) add_coded_product(k, 0.1 * static_cast<double>(k), 0, static_cast<int>(k));
  auto product = read<ProductRecord>(image(1));
  std::vector<std::uint8_t> bytes = data_of(product);
  bytes[bytes.size() / 2] ^= 0x10;
  write(product, "data", bytes);
  const std::vector<Status> events = run(*manager);
  ASSERT_GE(events.size(), 2U);
  EXPECT_EQ(events[1].code, StatusCode::product_damaged);
  EXPECT_EQ(events[1].a, image(1));
  EXPECT_EQ(read<ProductRecord>(image(1)).state, ProductState::dropped);
  EXPECT_EQ(read<StorageRecord>(1).products_damaged, 1U);
  EXPECT_EQ(products_held(), (Ids{image(2), image(3)}));
  expect_account_is_right();
}

TEST_F(StorageFull, BytesOfProductsGivenUpElsewhereGoAtOnce) {
  mission.product_share = 1;
  add_product(1, ProductKind::image, 0.1, 6'000);
  add_product(2, ProductKind::image, 0.9, 6'000, ProductState::dropped);
  run(*manager);
  EXPECT_EQ(products_held(), (Ids{image(1)}));
  EXPECT_EQ(read<StorageRecord>(1).products_damaged, 1U);
  expect_account_is_right();
}

TEST_F(StorageFull, DepthMapsOverTheirShareAreToldAndCostNoProduct) {
  mission.product_share = 1;
  mission.depth_share = 0.01;
  for (std::int64_t k = 1; k <= 5; ++k) add_depth(k);
  add_product(0, ProductKind::image, 0.1, 10'000);
  EXPECT_EQ(codes(run(*manager)), (std::vector{StatusCode::storage_tight}));
  EXPECT_EQ(products_held().size(), 1U);
}

// Places stay for the whole flight: the rest has to fit beside them.
TEST_F(StorageFull, PlacesOnRecordCountAsDataAlsoAfterARestart) {
  mission.product_share = 1;
  for (std::int64_t k = 1; k <= 3; ++k) add_product(k, ProductKind::image, 0.1 * static_cast<double>(k), 100'000);
  EXPECT_TRUE(run(*manager).empty());
  for (std::int64_t id = 1; id <= 5; ++id) {
    PlaceRecord place{.id = id};
    write(place);
  }
  EXPECT_EQ(codes(run(*manager)),
            (std::vector{StatusCode::storage_tight, StatusCode::product_dropped, StatusCode::storage_relieved}));
  EXPECT_EQ(products_held(), (Ids{image(2), image(3)}));
  manager = std::make_unique<StorageManager>(store, mission, test::step_memory<StorageManager>());
  ASSERT_TRUE(restored(manager->restore()));
  EXPECT_TRUE(run(*manager).empty());
  add_product(8, ProductKind::image, 0.8, 100'000);
  EXPECT_EQ(codes(run(*manager)),
            (std::vector{StatusCode::storage_tight, StatusCode::product_dropped, StatusCode::storage_relieved}));
  EXPECT_EQ(products_held(), (Ids{image(3), image(8)}));
  expect_account_is_right();
}

// What the records say must be what a plain count of the store says, whatever comes in which order.
TEST_F(StorageFull, RandomHistoriesOfProductsKeepTheAccountAndTheRules) {
  mission.product_share = 0.05;
  Rng random(11, 3);
  std::map<std::int64_t, std::uint8_t> sent;
  std::int64_t files = 0;
  for (std::int64_t k = 1; k <= 120; ++k) {
    const ProductRecord made = add_coded_product(k, random.uniform(), 0, static_cast<int>(k % 5));
    sent[made.id] = 0;
    for (auto& [id, layers] : sent) {
      ProductRecord product;
      if (random.below(8) != 0 || !get(store, id, product).ok() || product.state != ProductState::stored) continue;
      layers = static_cast<std::uint8_t>(product.layers_sent + 1);
      product.layers_sent = layers;
      if (layers == product.layers) product.state = ProductState::sent;
      write(product);
    }
    for (auto& [id, layers] : sent) {
      ProductRecord product;
      if (layers == 0 || random.below(10) != 0 || !get(store, id, product).ok()) continue;
      if (product.state != ProductState::sent) continue;
      product.layers_held = static_cast<std::uint8_t>((1U << product.layers) - 1U);
      product.state = ProductState::acknowledged;
      write(product);
      add_downlink(++files, DownlinkKind::product, id, k, 5);
    }
    run(*manager);
    expect_account_is_right();
    const auto account = read<StorageRecord>(1);
    ASSERT_EQ(account.full != 0 && static_cast<double>(account.product_bytes) <= 0.9 * 5 * quota(), false);
    for (auto& [id, layers] : sent) {
      ProductRecord product;
      const bool there = get(store, id, product).ok();
      if (layers == 0) continue;
      // Gone to the link: whole, or cut no further than that; away only when confirmed.
      if (there) {
        ASSERT_NE(product.state, ProductState::dropped) << id;
        ASSERT_GE(product.layers, layers) << id;
      }
    }
  }
  EXPECT_GT(read<StorageRecord>(1).layers_cut, 20U);
  EXPECT_GT(read<StorageRecord>(1).products_acknowledged, 5U);
}

ProductRecord product_of_layers(std::uint8_t layers, std::uint8_t sent) {
  ProductRecord product{.priority = 0.5, .layers = layers, .layers_sent = sent};
  for (std::uint32_t i = 0; i < layers; ++i) {
    product.layer_bytes[i] = 1000U << i;
    product.layer_quality[i] = 30.0F + 5.0F * static_cast<float>(i);
  }
  product.data.bytes = product.bytes = product.layer_bytes[layers - 1];
  return product;
}

TEST(StorageVictims, WhatIsWithTheLinkIsNone) {
  EXPECT_TRUE(last_layer_can_go(product_of_layers(3, 0)));
  EXPECT_TRUE(last_layer_can_go(product_of_layers(3, 2)));
  EXPECT_FALSE(last_layer_can_go(product_of_layers(3, 3)));
  EXPECT_FALSE(last_layer_can_go(product_of_layers(1, 0))) << "the only layer";
  EXPECT_TRUE(product_can_go(product_of_layers(1, 0)));
  EXPECT_FALSE(product_can_go(product_of_layers(3, 1)));
  for (const ProductState state : {ProductState::sent, ProductState::acknowledged, ProductState::dropped}) {
    ProductRecord product = product_of_layers(3, 0);
    product.state = state;
    EXPECT_FALSE(last_layer_can_go(product) || product_can_go(product));
  }
}

TEST(StorageVictims, ALayerIsWorthWhatItAddsPerByte) {
  const ProductRecord image = product_of_layers(3, 0);
  EXPECT_NEAR(utility_of_last_layer(image), 0.5 * 5 / 2000, 1e-12);
  ProductRecord depth = image;
  depth.kind = ProductKind::depth;
  depth.layer_quality[1] = 1.0F;
  depth.layer_quality[2] = 0.5F;
  EXPECT_NEAR(utility_of_last_layer(depth), 0.5 * 6.0206 / 2000, 1e-7) << "half the error";
  ProductRecord exact = image;
  exact.layer_quality[2] = std::numeric_limits<float>::infinity();
  EXPECT_NEAR(utility_of_last_layer(exact), 0.5 * 20 / 2000, 1e-12);
  ProductRecord unknown_quality = image;
  for (float& quality : unknown_quality.layer_quality) quality = 0;
  EXPECT_NEAR(utility_of_last_layer(unknown_quality), 0.5 / 2000, 1e-12);
}

class StorageRounds : public test::StorageManagerTest {};

TEST_F(StorageRounds, FullOfWhatIsWithTheLinkItComesToRestHoweverManyFilesAreNotConfirmed) {
  mission.storage_budget_mib = 1;
  mission.high_watermark = 0.1;
  mission.low_watermark = 0.05;
  // Searching 128 products a step and 64 files a step must not wait for each other in turns.
  for (std::int64_t id = 1; id <= 200; ++id) {
    add_product(id, ProductKind::image, 0.5, 1000, ProductState::sent);
    add_downlink(id, DownlinkKind::product, product_id(id, ProductKind::image), id);
  }
  for (int i = 0; i < 5; ++i) run(*manager, 300);
  EXPECT_EQ(products_held().size(), 200U);
  EXPECT_EQ(read<StorageRecord>(1).full, 1);
}

class LostFiles : public test::StorageManagerTest {};

TEST_F(LostFiles, LayersOfAFileThatIsNotConfirmedInTimeGoAgainAndOnlyThose) {
  mission.confirmation_timeout_s = 100;
  ProductRecord product = add_coded_product(1, 0.5, 4);
  product.layers_held = 0b0001;
  write(product);
  DownlinkRecord file;
  file.id = 1;
  file.subject_id = product.id;
  file.first_layer = file.last_layer = 1;
  file.sent_ns = 10 * ns_per_s;
  file.acknowledged_ns = 20 * ns_per_s;
  write(file);
  file.id = 2;
  file.first_layer = 2;
  file.last_layer = 4;
  file.acknowledged_ns = 0;
  write(file);
  file.id = 3;
  file.kind = DownlinkKind::records;
  file.subject_id = -1;
  file.sent_ns = 110 * ns_per_s;
  write(file);
  run(*manager);
  EXPECT_EQ(read<ProductRecord>(product.id).state, ProductState::sent) << "not yet";
  file.id = 4;
  file.sent_ns = 111 * ns_per_s;
  write(file);
  run(*manager);
  const auto again = read<ProductRecord>(product.id);
  EXPECT_EQ(again.state, ProductState::stored);
  EXPECT_EQ(again.layers_sent, 1);
  EXPECT_EQ(again.layers_held, 0b0001);
  EXPECT_EQ(again.data.bytes, product.data.bytes);
  EXPECT_EQ(read<StorageRecord>(1).files_lost, 1U);
  DownlinkRecord gone;
  EXPECT_TRUE(get(store, 2, gone).is(StatusCode::not_found));
  EXPECT_TRUE(get(store, 1, gone).ok());
}

}  // namespace
}  // namespace ilp
