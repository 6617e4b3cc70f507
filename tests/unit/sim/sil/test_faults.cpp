#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>

#include "hal/clock/virtual_clock.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "sim/sil/faulty_link.hpp"
#include "sim/sil/faulty_store.hpp"
#include "sim/sil/power_cut.hpp"
#include "sim/sil/real_time.hpp"
#include "tests/support/said.hpp"
#include "tests/support/store_records.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::sil {
namespace {

TEST(FaultPlan, KindsStrikeIndependentlyOfEachOther) {
  int both = 0;
  for (std::int64_t n = 1; n <= 4000; ++n) both += strikes(1, "lost", n, 0.5) && strikes(1, "black", n, 0.5) ? 1 : 0;
  // Five standard deviations about a quarter.
  EXPECT_NEAR(both, 1000, 140);
}

TEST(FaultPlan, AShareOfOneIsEveryFrameAndOfNothingIsNone) {
  for (std::int64_t n = 1; n <= 1000; ++n) {
    EXPECT_TRUE(strikes(3, "lost", n, 1));
    EXPECT_FALSE(strikes(3, "lost", n, 0));
  }
}

TEST(FaultPlan, AWindowBeginsLastsAndComesAgain) {
  const auto inside = [](double s, FaultWindow window) { return inside_window(static_cast<TimeNs>(s * 1e9), window); };
  EXPECT_FALSE(inside(5, {5, 0, 0}));
  EXPECT_FALSE(inside(4.9, {5, 2, 0}));
  EXPECT_TRUE(inside(5, {5, 2, 0}));
  EXPECT_TRUE(inside(6.9, {5, 2, 0}));
  EXPECT_FALSE(inside(7, {5, 2, 0}));
  EXPECT_FALSE(inside(15.5, {5, 2, 0}));
  EXPECT_TRUE(inside(15.5, {5, 2, 10}));
  EXPECT_FALSE(inside(17.5, {5, 2, 10}));
}

TEST(FaultPlan, ImpossibleSharesAreRefusedByName) {
  FaultPlan plan;
  const auto set = [&] { world::set_parameter(parameters(plan), "faults", "lost_share", "1.5"); };
  EXPECT_TRUE(test::says(test::error_of<std::invalid_argument>(set), "[faults] lost_share"));
}

class FaultyStoreTest : public testing::Test {
 protected:
  Status write(std::int64_t id) {
    StripRecord record{.id = id};
    Transaction transaction(store);
    ILP_TRY(transaction.begin());
    ILP_TRY(put(store, record));
    return transaction.commit();
  }
  std::int64_t count() {
    std::int64_t records = -1;
    EXPECT_TRUE(memory.count(record_info<StripRecord>(), records).ok());
    return records;
  }

  std::vector<std::byte> region = std::vector<std::byte>(std::size_t{1} << 20U);
  RamStore memory{region};
  VirtualClock clock;
  FaultyStore store{memory, clock, FaultWindow{10, 5, 0}};
};

TEST_F(FaultyStoreTest, TakesNothingWhileItIsFullAndForgetsNothing) {
  EXPECT_TRUE(write(1).ok());
  clock.sleep_until(10 * ns_per_s);
  EXPECT_TRUE(write(2).is(StatusCode::store_full));
  StripRecord record;
  EXPECT_TRUE(get(store, 1, record).ok());
  clock.sleep_until(15 * ns_per_s);
  EXPECT_TRUE(write(3).ok());
  EXPECT_EQ(count(), 2);
  EXPECT_EQ(store.refused(), 1);
}

TEST_F(FaultyStoreTest, ARefusedWriteDoomsItsTransaction) {
  clock.sleep_until(14 * ns_per_s);
  StripRecord record{.id = 1};
  ASSERT_TRUE(store.begin().ok());
  EXPECT_TRUE(put(store, record).is(StatusCode::store_full));
  clock.sleep_until(15 * ns_per_s);
  EXPECT_TRUE(put(store, record).is(StatusCode::store_full)) << "half a transaction must not be committed";
  EXPECT_TRUE(store.commit().is(StatusCode::store_full));
  EXPECT_EQ(count(), 0);
  EXPECT_TRUE(write(1).ok()) << "the next transaction is a new one";
}

TEST_F(FaultyStoreTest, PowerIsCutInTheMiddleOfATransaction) {
  int cuts = 0;
  store.cut_at_write(2, [&cuts] { ++cuts; });
  EXPECT_TRUE(write(1).ok());  // a write and a commit
  EXPECT_EQ(cuts, 0);
  ASSERT_TRUE(store.begin().ok());
  EXPECT_EQ(cuts, 0);
  StripRecord record{.id = 2};
  EXPECT_TRUE(put(store, record).ok());
  EXPECT_EQ(cuts, 1);
  EXPECT_TRUE(store.commit().ok());
  EXPECT_EQ(cuts, 1) << "once";
}

class OpenLink final : public Link {
 public:
  Status begin_file(const char*) override { return {}; }
  Status write(std::span<const std::uint8_t>) override { return {}; }
  Status end_file() override {
    ++files;
    return {};
  }
  Status acknowledged(const char*, std::uint32_t&, std::uint32_t&) override { return {}; }
  int files = 0;
};

TEST(FaultyLink, DuringAnOutageNothingGoesEitherWay) {
  OpenLink open;
  VirtualClock clock;
  FaultyLink link(open, clock, {10, 5, 0});
  std::uint32_t bytes = 0;
  std::uint32_t crc = 0;
  EXPECT_TRUE(link.begin_file("a").ok());
  clock.sleep_until(10 * ns_per_s);
  EXPECT_TRUE(link.end_file().is(StatusCode::not_ready)) << "the outage caught the file";
  EXPECT_TRUE(link.begin_file("a").is(StatusCode::not_ready));
  EXPECT_TRUE(link.acknowledged("a", bytes, crc).is(StatusCode::not_ready));
  clock.sleep_until(15 * ns_per_s);
  EXPECT_TRUE(link.begin_file("a").ok());
  EXPECT_TRUE(link.end_file().ok());
  EXPECT_TRUE(link.acknowledged("a", bytes, crc).ok());
  EXPECT_EQ(open.files, 1);
}

TEST(PowerCut, CutsAreSpreadOverTheFlightInOrder) {
  const std::vector<PowerCut> cuts = plan_power_cuts(200, 5, 50);
  ASSERT_EQ(cuts.size(), 200U);
  double sum = 0;
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    EXPECT_GE(cuts[i].sequence, i == 0 ? 0 : cuts[i - 1].sequence);
    EXPECT_LT(cuts[i].sequence, 50);
    sum += static_cast<double>(cuts[i].sequence);
  }
  // Mean of a uniform draw from 0 to 49, five standard deviations.
  EXPECT_NEAR(sum / 200, 24.5, 5.1);
}

TEST(PowerCut, AFileThatIsNotOursIsRefused) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(read_past_boots(std::filesystem::path(folder / "")).clock_ns, 0);
  std::ofstream(folder / "power.json") << "{\"clock_ns\": 3}";
  EXPECT_THROW(static_cast<void>(read_past_boots(std::filesystem::path(folder / ""))), std::runtime_error);
}

TEST(StallGuard, OnlyRecordsOfTheFlightAreProgress) {
  std::vector<std::byte> region(std::size_t{1} << 20U);
  RamStore store(region);
  StallGuard guard(100 * ns_per_s);
  const auto write = [&store](const auto& record) { test::write_records(store, record); };
  EXPECT_FALSE(guard.stalled(store, 0));
  EventRecord event{.id = 1};
  write(event);
  EXPECT_FALSE(guard.stalled(store, 100 * ns_per_s));
  CheckpointRecord checkpoint{.id = 1, .cursor = 4};
  write(checkpoint);
  EXPECT_FALSE(guard.stalled(store, 101 * ns_per_s));
  event.id = 2;
  write(event);
  EXPECT_FALSE(guard.stalled(store, 201 * ns_per_s));
  EXPECT_TRUE(guard.stalled(store, 202 * ns_per_s));
}

}  // namespace
}  // namespace ilp::sil
