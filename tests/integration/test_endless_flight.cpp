// A flight with storage for 100 keyframes that goes on and on.
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <vector>

#include "tests/integration/endless_flight.hpp"
#include "tests/support/store_records.hpp"
#include "tests/unit/hal/small_disk.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

void expect_bounded(const test::EndlessResult& result, const MissionParameters& mission) {
  const StorageRecord& account = result.account;
  std::printf(
      "%lld keyframes, %lld minor frames: database at most %.2f MiB (%.2f at a quarter), log %.2f MiB, held %.2f MiB, "
      "%lld rows, resident %lld -> %lld KiB\n"
      "frames released %u, layers cut %u, products dropped %u, acknowledged %u, full %u times, rows erased %lld, "
      "%lld files with %.1f MiB sent\n",
      static_cast<long long>(result.keyframes), static_cast<long long>(result.minor_frames),
      static_cast<double>(result.most_database_bytes) / 1048576,
      static_cast<double>(result.database_bytes_at_quarter) / 1048576,
      static_cast<double>(result.most_log_bytes) / 1048576, static_cast<double>(result.most_held_bytes) / 1048576,
      static_cast<long long>(result.most_rows), static_cast<long long>(result.resident_kib_at_quarter),
      static_cast<long long>(result.resident_kib_at_end), account.frames_released, account.layers_cut,
      account.products_dropped, account.products_acknowledged, account.times_full,
      static_cast<long long>(account.rows_erased), static_cast<long long>(result.files),
      static_cast<double>(result.bytes) / 1048576);
  const double budget = mission.storage_budget_mib * 1048576;
  // One keyframe may come on top before the storage manager has its turn.
  EXPECT_LE(static_cast<double>(result.most_held_bytes), budget + 50'000);
  // A product cut to its first layer takes a page all the same.
  EXPECT_LE(static_cast<double>(result.most_database_bytes), 8 * budget);
  EXPECT_LE(result.most_log_bytes, sqlite_log_bytes);
  EXPECT_LE(result.most_rows, 100 * 12 + 300 * 3 + 25'000);
  EXPECT_GT(account.times_full, 0U) << "this flight is meant to be full";
  EXPECT_GT(account.layers_cut, 0U);
  EXPECT_GT(account.products_acknowledged, 0U);
  EXPECT_EQ(account.frames_skipped, 0U);
  EXPECT_EQ(account.products_damaged, 0U);
}

void expect_valid(const std::string& path) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  std::string answer;
  const auto append = [](void* to, int, char** values, char**) {
    *static_cast<std::string*>(to) += values[0];
    return 0;
  };
  EXPECT_EQ(sqlite3_exec(database, "PRAGMA integrity_check", append, &answer, nullptr), SQLITE_OK);
  EXPECT_EQ(answer, "ok");
  sqlite3_close(database);
}

TEST(EndlessFlight, KeepsItsBoundsAndItsRules) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "flight.db";
  const MissionParameters mission = test::endless_mission();
  test::EndlessOptions options;
#ifdef ILP_LONG_FLIGHT
  options.keyframes = 10'000;
#endif
  const test::EndlessResult result = test::fly_endlessly(path, mission, options);
  EXPECT_EQ(result.keyframes, options.keyframes);
  expect_bounded(result, mission);
  expect_valid(path);
#ifdef ILP_LONG_FLIGHT
  EXPECT_LE(result.most_database_bytes, result.database_bytes_at_quarter + result.database_bytes_at_quarter / 4);
  EXPECT_LE(result.resident_kib_at_end, result.resident_kib_at_quarter + 4096);
#endif
}

TEST(EndlessFlight, OnADiskSmallerThanItsBudgetItGivesUpWhatIsLeastWorthAndCaptureGoesOn) {
  const test::TemporaryFolder folder;
  const test::SmallDisk disk(folder / "disk", 12);
  if (!disk.mounted()) GTEST_SKIP() << "no right to mount a small disk here";
  const std::string path = disk.path() + "/flight.db";
  MissionParameters mission = test::endless_mission();
  mission.storage_budget_mib = 64;
  mission.link_bytes_per_s = 1000;
  test::EndlessOptions options{.keyframes = 800, .pass_frames = 100};
  const test::EndlessResult result = test::fly_endlessly(path, mission, options);
  EXPECT_EQ(result.keyframes, options.keyframes);
  EXPECT_GT(result.account.times_full, 0U);
  EXPECT_LE(result.most_database_bytes, 6 << 20) << "half of so small a disk is for the log";
  EXPECT_FALSE(result.events.contains(StatusCode::store_full)) << "full is a mode long before the disk is full";
  expect_valid(path);
}

TEST(EndlessFlight, WhenOthersFillTheDiskItWaitsLosesNothingAndGoesOn) {
  const test::TemporaryFolder folder;
  const test::SmallDisk disk(folder / "disk", 24);
  if (!disk.mounted()) GTEST_SKIP() << "no right to mount a small disk here";
  const std::string path = disk.path() + "/flight.db";
  const std::string other = disk.path() + "/other";
  test::EndlessOptions options{
      .keyframes = 300, .longest_pause_ns = 300 * ns_per_s, .behind_from = 2000, .behind_to = 4200};
  options.happen = [&](Store&, std::int64_t frame) {
    if (frame == 2000) {
      std::ofstream out(other, std::ios::binary);
      const std::vector<char> zeros(1 << 16);
      while (out.write(zeros.data(), static_cast<std::streamsize>(zeros.size())).flush()) {
      }
    }
    if (frame == 4000) std::filesystem::remove(other);
  };
  const test::EndlessResult result = test::fly_endlessly(path, test::endless_mission(), options);
  EXPECT_EQ(result.keyframes, options.keyframes);
  EXPECT_GT(result.events.count(StatusCode::events_lost) + result.events.count(StatusCode::store_full), 0U);
  expect_valid(path);
}

TEST(EndlessFlight, DamagedProductsAreGivenUpWithAWordAndItGoesOn) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "flight.db";
  std::int64_t damaged = 0;
  test::EndlessOptions options{.keyframes = 250};
  options.happen = [&](Store& store, std::int64_t frame) {
    if (frame % 500 != 250) return;
    ProductRecord product;
    std::int64_t id = 0;
    // The newest that waits.
    std::int64_t waiting = 0;
    for (; next(store, id, product).ok(); id = product.id) {
      if (product.state == ProductState::stored && product.data.bytes != 0 && product.layers_sent == 0) {
        waiting = product.id;
      }
    }
    if (waiting == 0) return;
    ++damaged;
    const std::uint8_t junk[] = {0xAA, 0x55, 0xAA, 0x55, 0xAA};
    test::in_transaction(store,
                         [&] { ASSERT_TRUE(write_blob<ProductRecord>(store, "data", waiting, 200, junk).ok()); });
  };
  const test::EndlessResult result = test::fly_endlessly(path, test::endless_mission(), options);
  EXPECT_EQ(result.keyframes, options.keyframes);
  EXPECT_GT(damaged, 5);
  EXPECT_GT(result.account.products_damaged, 0U);
  EXPECT_LE(result.account.products_damaged, damaged);
  ASSERT_TRUE(result.events.contains(StatusCode::product_damaged));
  EXPECT_EQ(result.events.at(StatusCode::product_damaged), result.account.products_damaged);
}

TEST(EndlessFlight, AClockThatGoesBackwardsStopsNothing) {
  const test::TemporaryFolder folder;
  test::EndlessOptions options{.keyframes = 300, .restart_every_frames = 1500, .clock_back_ns = 100 * ns_per_s};
  const test::EndlessResult result = test::fly_endlessly(folder / "flight.db", test::endless_mission(), options);
  EXPECT_EQ(result.keyframes, options.keyframes);
  EXPECT_GE(result.account.oldest_age_ns, 0);
  EXPECT_GT(result.account.products_acknowledged, 0U);
}

TEST(EndlessFlight, AQuotaSmallerThanOneProductStopsNothing) {
  const test::TemporaryFolder folder;
  MissionParameters mission = test::endless_mission();
  mission.product_share = 0.01;
  mission.high_watermark = 0.1;
  mission.low_watermark = 0.05;
  test::EndlessOptions options{.keyframes = 150};
  const test::EndlessResult result = test::fly_endlessly(folder / "flight.db", mission, options);
  EXPECT_EQ(result.keyframes, options.keyframes);
  EXPECT_GT(result.account.products_dropped, 100U);
}

}  // namespace
}  // namespace ilp
