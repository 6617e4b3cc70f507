// Starts on a disk that fails below SQLite. A database is condemned for its content only.
#include <memory>

#include "bsp/flight/flight_store.hpp"
#include "tests/unit/hal/disk_faults.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;
using test::Call;
using test::FailingCalls;
using test::Files;
using test::Trouble;

class StartFaults : public test::DiskFaults {
 protected:
  std::unique_ptr<FlightStore> make() { return std::make_unique<FlightStore>(sqlite_, memory_); }

  MissionParameters mission_;
  Arena sqlite_;
  alignas(Arena::alignment) static inline std::byte memory_[limits::ram_store_bytes];
};

TEST_F(StartFaults, AStartOnADiskThatFailsRenamesNothingAndTheNextOneGoesOn) {
  const Files before = dead(4);
  const std::set<std::int64_t> committed{1, 2, 3, 4};
  const Trouble troubles[] = {
      {"full", {.calls = Call::write | Call::create, .reason = ENOSPC}},
      {"changes", {.calls = test::changes}},
      {"reads", {.calls = static_cast<unsigned>(Call::read)}},
      // As many as make one attempt of a start fail, and not what it would do next.
      {"changes for a while", {.calls = test::changes, .count = 3}},
      {"reads for a while", {.calls = static_cast<unsigned>(Call::read), .count = 3}},
      {"reads for longer", {.calls = static_cast<unsigned>(Call::read), .count = 12}},
  };
  for (const Trouble& trouble : troubles) {
    bool failed = true;
    for (int n = 1; failed; n += 1 + n / 16) {
      ASSERT_LT(n, test::most_calls);
      const std::string where = std::string(trouble.name) + ", call " + std::to_string(n);
      restore(before);
      for (const StoreTrouble how : {StoreTrouble::refuse, StoreTrouble::fly_on}) {
        const auto store = make();
        const FailingCalls disk(path_, test::from_call(trouble.fault, n));
        const Status opened = store->open(path_.c_str(), how, mission_);
        if (how == StoreTrouble::fly_on) {
          EXPECT_OK(opened) << where;
          EXPECT_TRUE(store->updates().ok() || store->updates().is(StatusCode::store_in_memory))
              << where << ": " << status_name(store->updates().code);
        } else {
          EXPECT_FALSE(is_verdict(opened)) << where << ": " << status_name(opened.code);
        }
        failed = disk.failed();
        store->close();
      }
      std::set<std::string> left = names(files());
      left.erase("flight.db-wal");
      left.erase("flight.db-sync");
      EXPECT_EQ(left, std::set<std::string>{"flight.db"}) << where;
      EXPECT_FALSE(fs::exists(path_ + "-guard") && fs::file_size(path_ + "-guard") > 0) << where;
      expect_valid(committed, where);
      if (HasFailure()) return;
    }
  }
}

TEST_F(StartFaults, ADamagedDatabaseIsSetAsideOnlyWhenItsSuccessorIsWhole) {
  {
    SqliteStore store;
    ASSERT_OK(store.open(path_.c_str()));
    for (std::int64_t id = 1; id <= 6; ++id) ASSERT_OK(put_frame(store, id));
  }
  // A page of the image of frame 5.
  Files before = files();
  std::string& content = before["flight.db"];
  const std::size_t at = content.find(std::string(3000, '\5'));
  ASSERT_NE(at, std::string::npos);
  content.replace(at, 100, 100, 'x');
  const std::string damaged = content;
  const Trouble troubles[] = {
      {"full", {.calls = Call::write | Call::create, .reason = ENOSPC}},
      {"changes", {.calls = test::changes}},
      {"changes for a while", {.calls = test::changes, .count = 3}},
  };
  for (const Trouble& trouble : troubles) {
    bool failed = true;
    for (int n = 1; failed; n += 1 + n / 10) {
      ASSERT_LT(n, test::most_calls);
      const std::string where = std::string(trouble.name) + ", call " + std::to_string(n);
      restore(before);
      std::ofstream(path_ + "-guard") << "damaged";
      {
        const auto store = make();
        const FailingCalls disk(path_, test::from_call(trouble.fault, n));
        EXPECT_OK(store->open(path_.c_str(), StoreTrouble::fly_on, mission_)) << where;
        failed = disk.failed();
        store->close();
      }
      Files left = files();
      const bool in_place = left["flight.db"] == damaged;
      const bool aside = left["flight.db.aside-1"] == damaged;
      EXPECT_TRUE(in_place || aside) << where << ": the damaged one is gone";
      EXPECT_TRUE(in_place || !left["flight.db"].empty() || left.contains("flight.db.saved"))
          << where << ": there is no database";
      const auto store = make();
      ASSERT_OK(store->open(path_.c_str(), StoreTrouble::fly_on, mission_)) << where;
      EXPECT_FALSE(store->updates().is(StatusCode::store_in_memory)) << where;
      for (const std::int64_t id : {1, 2, 3, 4, 6}) EXPECT_TRUE(has_frame(store->store(), id)) << where << " " << id;
      store->close();
      EXPECT_FALSE(fs::exists(path_ + ".aside-2")) << where;
      if (HasFailure()) return;
    }
  }
}

}  // namespace
}  // namespace ilp
