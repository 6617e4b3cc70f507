#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <span>
#include <vector>

#include "bsp/flight/boot.hpp"
#include "bsp/flight/flight_software.hpp"
#include "bsp/flight/flight_store.hpp"
#include "hal/clock/virtual_clock.hpp"
#include "hal/store/sqlite/page_checksum.hpp"
#include "hal/store/sqlite/quarantine.hpp"
#include "tests/support/said.hpp"
#include "tests/support/store_records.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

class FlightStoreTest : public testing::Test {
 protected:
  std::unique_ptr<FlightStore> make() { return std::make_unique<FlightStore>(sqlite_, memory_); }
  /// A boot of a flight in the database; `ended` in order or not.
  void live(bool ended) {
    const auto store = make();
    ASSERT_TRUE(store->open(path_.c_str(), StoreTrouble::refuse, mission_).ok());
    VirtualClock clock(5);
    Boot boot(store->store(), clock);
    ASSERT_TRUE(boot.begin({}).ok());
    if (ended) {
      ASSERT_TRUE(boot.end().ok());
    }
    store->close();
  }
  /// Checkpoints of these forms in the database.
  void leave(const std::vector<CheckpointForm>& forms) const {
    SqliteStore store;
    ASSERT_TRUE(store.open(path_.c_str()).ok());
    test::in_transaction(store, [&] {
      for (const CheckpointForm& form : forms) {
        const std::vector<std::uint8_t> state(form.bytes, 7);
        ASSERT_TRUE(save_checkpoint(store, form, {}, std::span<const std::uint8_t>(state)).ok());
      }
    });
  }
  void overwrite(std::uint32_t page, const std::string& bytes) const {
    std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(page - 1) * 4096);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    ASSERT_TRUE(file.good());
  }
  /// Overwrites pages after the first.
  void damage() const { overwrite(2, std::string(16 * 4096, '\x5A')); }
  /// As if SQLite had written it: with its checksum.
  template <typename Change>
  void rewrite_page(std::uint32_t number, Change change) const {
    std::string bytes = test::text_of(path_).substr(static_cast<std::size_t>(number - 1) * 4096, 4096);
    const Page page(reinterpret_cast<std::uint8_t*>(bytes.data()), page_bytes);
    change(page);
    seal_page(number, page);
    overwrite(number, bytes);
  }

  test::TemporaryFolder folder_;
  std::string path_ = folder_ / "flight.db";
  MissionParameters mission_;
  Arena sqlite_;  // of a host: SQLite has the system's heap
  alignas(Arena::alignment) static inline std::byte memory_[limits::ram_store_bytes];
};

TEST_F(FlightStoreTest, WhatWasWrittenIsThereAtTheNextStart) {
  live(true);
  live(true);
  const auto store = make();
  ASSERT_TRUE(store->open(path_.c_str(), StoreTrouble::fly_on, mission_).ok());
  StartRecord boot;
  ASSERT_TRUE(last(store->store(), boot).ok());
  EXPECT_EQ(boot.id, 2);
  EXPECT_TRUE(store->updates().ok());
}

TEST_F(FlightStoreTest, AFileThatIsNoDatabaseIsRefusedOrSetAside) {
  std::ofstream(path_) << std::string(10'000, 'x');
  EXPECT_STATUS(make()->open(path_.c_str(), StoreTrouble::refuse, mission_), store_damaged);
  EXPECT_EQ(fs::file_size(path_), 10'000U);
  const auto store = make();
  ASSERT_TRUE(store->open(path_.c_str(), StoreTrouble::fly_on, mission_).ok());
  EXPECT_STATUS(store->updates(), store_set_aside);
  EXPECT_EQ(fs::file_size(path_ + ".aside-1"), 10'000U);
  VirtualClock clock;
  EXPECT_TRUE(Boot(store->store(), clock).begin({}).ok());
}

TEST_F(FlightStoreTest, DamageIsLookedForAfterALifeThatDidNotEndInOrder) {
  live(false);
  damage();
  EXPECT_STATUS(make()->open(path_.c_str(), StoreTrouble::refuse, mission_), store_damaged);
  const auto store = make();
  ASSERT_TRUE(store->open(path_.c_str(), StoreTrouble::fly_on, mission_).ok());
  EXPECT_TRUE(store->updates().is(StatusCode::store_set_aside) || store->updates().is(StatusCode::store_salvaged));
  EXPECT_TRUE(fs::exists(path_ + ".aside-1"));
}

TEST_F(FlightStoreTest, ADatabaseOfAnotherVersionIsSetAside) {
  live(true);
  {
    SqliteStore store;
    ASSERT_TRUE(store.open(path_.c_str()).ok());
  }
  // The fingerprint of the field tables stands at offset 60 of the file.
  rewrite_page(1, [](Page page) { page[60] = page[61] = page[62] = 0, page[63] = 1; });
  EXPECT_STATUS(make()->open(path_.c_str(), StoreTrouble::refuse, mission_), store_schema);
  const auto store = make();
  ASSERT_TRUE(store->open(path_.c_str(), StoreTrouble::fly_on, mission_).ok());
  EXPECT_STATUS(store->updates(), store_set_aside);
}

TEST_F(FlightStoreTest, ADatabaseOfABuildWithOtherCapacitiesIsRefusedUntouchedOrSetAside) {
  live(true);
  const CheckpointForm foreign{ComponentId::dense_matcher, 2, 1000};
  leave({foreign});
  const std::string before = test::text_of(path_);
  const Status refused = make()->open(path_.c_str(), StoreTrouble::refuse, mission_);
  EXPECT_STATUS(refused, store_build);
  EXPECT_EQ(refused.a, static_cast<std::int64_t>(foreign.component));
  EXPECT_EQ(refused.b, foreign.bytes);
  EXPECT_EQ(test::text_of(path_), before);
  const auto store = make();
  ASSERT_TRUE(store->open(path_.c_str(), StoreTrouble::fly_on, mission_).ok());
  EXPECT_STATUS(store->updates(), store_set_aside);
  EXPECT_EQ(test::text_of(path_ + ".aside-1"), before);
}

TEST_F(FlightStoreTest, CheckpointsOfThisBuildAndOfComponentsThatBeginAnewAreAccepted) {
  live(true);
  std::vector<CheckpointForm> forms;
  for (const CheckpointForm* form : checkpoint_forms()) forms.push_back(*form);
  // What the ground set for events of other numbers is forgotten.
  forms.push_back({ComponentId::telemetry, 1, 9});
  leave(forms);
  EXPECT_STATUS(make()->open(path_.c_str(), StoreTrouble::refuse, mission_), ok);
}

TEST_F(FlightStoreTest, WithoutADiskTheRecordsAreInMemory) {
  const std::string nowhere = folder_ / "none/flight.db";
  EXPECT_STATUS(make()->open(nowhere.c_str(), StoreTrouble::refuse, mission_), store_error);
  const auto store = make();
  ASSERT_TRUE(store->open(nowhere.c_str(), StoreTrouble::fly_on, mission_).ok());
  EXPECT_STATUS(store->updates(), store_in_memory);
  EXPECT_LT(mission_.storage_budget_mib * 1048576.0, static_cast<double>(limits::ram_store_bytes));
  VirtualClock clock;
  EXPECT_TRUE(Boot(store->store(), clock).begin({}).ok());
}

TEST(Quarantine, TheEarliestAreKeptAndTheLatestMakesWay) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "flight.db";
  std::int64_t number = 0;
  for (std::int64_t i = 1; i <= max_quarantined + 2; ++i) {
    std::ofstream(path) << i;
    if (i == max_quarantined) std::ofstream(path + "-wal") << i;
    ASSERT_TRUE(quarantine_database(path.c_str(), number).ok());
    EXPECT_EQ(number, std::min(i, max_quarantined));
    EXPECT_FALSE(fs::exists(path));
  }
  std::int64_t first = 0;
  std::int64_t latest = 0;
  std::ifstream(path + ".aside-1") >> first;
  std::ifstream(path + ".aside-4") >> latest;
  EXPECT_EQ(first, 1);
  EXPECT_EQ(latest, max_quarantined + 2);
  EXPECT_FALSE(fs::exists(path + ".aside-4-wal")) << "a log of another database";
}

TEST_F(FlightStoreTest, SeveralProcessesShareADatabaseAndEachStageRunsInOne) {
  constexpr StageMask matcher = stage_bit(ComponentId::dense_matcher), coder = stage_bit(ComponentId::compressor);
  const auto node = make(), other = make();
  EXPECT_STATUS(node->join(path_.c_str(), mission_), not_found) << "no head has made it";
  const auto head = make();
  ASSERT_OK(head->open_as_primary(path_.c_str(), StoreTrouble::refuse, Synchronise::behind_commit, mission_));
  ASSERT_OK(head->claim(primary_stages));
  ASSERT_OK(node->join(path_.c_str(), mission_));
  ASSERT_OK(node->claim(matcher));
  ASSERT_OK(other->join(path_.c_str(), mission_));
  const Status claimed = other->claim(matcher | coder);
  EXPECT_STATUS(claimed, stage_claimed);
  EXPECT_EQ(claimed.a, static_cast<std::int64_t>(ComponentId::dense_matcher));
  EXPECT_OK(other->claim(coder)) << "a refused claim reserves nothing";

  RecordMask changed = 0;
  ASSERT_OK(node->store().poll(changed));
  PoseRecord pose{.id = 7};
  test::write_records(head->store(), pose);
  node->wait(1000);
  ASSERT_OK(node->store().poll(changed));
  EXPECT_NE(changed & mask_of(RecordType::pose), 0U);
  EXPECT_OK(get(node->store(), 7, pose));

  node->close();
  EXPECT_OK(other->claim(matcher)) << "it is free again";
}

TEST_F(FlightStoreTest, AFlightInOneProcessIsNotSharedAndASharedOneIsNotTaken) {
  const auto alone = make(), second = make();
  ASSERT_OK(alone->open(path_.c_str(), StoreTrouble::refuse, mission_));
  EXPECT_STATUS(second->join(path_.c_str(), mission_), store_in_use);
  alone->close();
  ASSERT_OK(alone->open_as_primary(path_.c_str(), StoreTrouble::refuse, Synchronise::behind_commit, mission_));
  EXPECT_STATUS(second->open(path_.c_str(), StoreTrouble::refuse, mission_), store_in_use);
  EXPECT_TRUE(std::filesystem::exists(path_ + "-guard"));
  alone->close();
  EXPECT_FALSE(std::filesystem::exists(path_ + "-guard"));
}

TEST_F(FlightStoreTest, WhileOthersHaveItOpenADamagedDatabaseIsNotSetAside) {
  live(true);
  const auto node = make();
  ASSERT_OK(node->join(path_.c_str(), mission_));
  overwrite(1, std::string(4096, 'x'));
  const auto head = make();
  EXPECT_FALSE(head->open_as_primary(path_.c_str(), StoreTrouble::fly_on, Synchronise::behind_commit, mission_).ok());
  EXPECT_TRUE(std::filesystem::exists(path_));
}

}  // namespace
}  // namespace ilp
