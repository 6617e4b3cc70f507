// A flight with storage for 100 keyframes that goes on and on.
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cstdio>

#include "tests/integration/endless_flight.hpp"
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

void expect_sound(const std::string& path) {
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
  expect_sound(path);
#ifdef ILP_LONG_FLIGHT
  EXPECT_LE(result.most_database_bytes, result.database_bytes_at_quarter + result.database_bytes_at_quarter / 4);
  EXPECT_LE(result.resident_kib_at_end, result.resident_kib_at_quarter + 4096);
#endif
}

}  // namespace
}  // namespace ilp
