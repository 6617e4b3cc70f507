// What outlives the database: kept through restarts, noticed when a bit of it flips, and numbers that never come again.
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "fsw/shared/flight_memory.hpp"
#include "hal/nonvolatile/ram_nonvolatile.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
namespace {

/// Takes what it is given, or refuses it.
class FailingNonvolatile final : public Nonvolatile {
 public:
  Status read(std::span<std::uint8_t> content, std::size_t& bytes) override { return ram.read(content, bytes); }
  Status write(std::span<const std::uint8_t> content) override {
    ++writes;
    return refuse ? Status{StatusCode::io_error, 5} : ram.write(content);
  }
  RamNonvolatile ram;
  bool refuse = false;
  int writes = 0;
};

TEST(FlightMemory, ContentIsThereAtTheNextStart) {
  RamNonvolatile medium;
  FlightMemory memory(medium);
  EXPECT_STATUS(memory.load(), not_found);
  EXPECT_EQ(memory.content().life, 0);
  FlightMemoryContent content = memory.content();
  content.life = 3;
  ASSERT_TRUE(content.good.set(17, 2.5));
  ASSERT_TRUE(content.wanted.set(18, -1));
  content.marks[1] = {77, 5, 0};
  ASSERT_TRUE(memory.keep(content).ok());
  FlightMemory next(medium);
  ASSERT_TRUE(next.load().ok());
  EXPECT_EQ(next.content().life, 3);
  EXPECT_EQ(next.content().good.find(17)->value, 2.5);
  EXPECT_EQ(next.content().good.find(18), nullptr);
  EXPECT_EQ(next.content().wanted.find(18)->value, -1);
  EXPECT_EQ(next.content().marks[1].highest, 77U);
}

TEST(FlightMemory, SettingsAreEachThereOnceAndFullIsNotSilent) {
  KeptSettings settings;
  for (std::uint64_t i = 1; i <= KeptSettings::capacity; ++i) EXPECT_TRUE(settings.set(i, static_cast<double>(i)));
  EXPECT_FALSE(settings.set(100000, 1));
  EXPECT_TRUE(settings.set(5, 7));
  EXPECT_EQ(settings.find(5)->value, 7);
  EXPECT_EQ(settings.count, KeptSettings::capacity);
  settings.remove(5);
  EXPECT_EQ(settings.find(5), nullptr);
  EXPECT_EQ(settings.find(6)->value, 6);
  EXPECT_TRUE(settings.set(100000, 1));
}

TEST(FlightMemory, AnotherLayoutIsNotBelieved) {
  RamNonvolatile medium;
  FlightMemory memory(medium);
  FlightMemoryContent content{.layout = FlightMemoryContent::current_layout + 1, .life = 9};
  ASSERT_TRUE(memory.keep(content).ok());
  FlightMemory next(medium);
  EXPECT_STATUS(next.load(), record_damaged);
  EXPECT_EQ(next.content().life, 0);
  content.layout = FlightMemoryContent::current_layout;
  content.good.count = KeptSettings::capacity + 1;
  ASSERT_TRUE(memory.keep(content).ok());
  EXPECT_STATUS(next.load(), record_damaged);
}

TEST(FlightMemory, AContentWithoutSenseIsNotBelieved) {
  const auto is_read = [](auto change) {
    RamNonvolatile medium;
    FlightMemory memory(medium);
    FlightMemoryContent content;
    change(content);
    EXPECT_TRUE(memory.keep(content).ok());
    FlightMemory next(medium);
    return next.load().ok();
  };
  EXPECT_TRUE(is_read([](FlightMemoryContent&) {}));
  EXPECT_FALSE(is_read([](FlightMemoryContent& c) { c.life = INT64_MAX; }));
  EXPECT_FALSE(is_read([](FlightMemoryContent& c) { c.life = -1; }));
  EXPECT_FALSE(is_read([](FlightMemoryContent& c) { c.record_base = INT64_MAX; }));
  EXPECT_FALSE(is_read([](FlightMemoryContent& c) { c.transactions_reserved = -5; }));
  EXPECT_FALSE(is_read([](FlightMemoryContent& c) { c.latest_ns = INT64_MIN; }));
  EXPECT_FALSE(is_read([](FlightMemoryContent& c) { c.mission_epoch_s = std::numeric_limits<double>::quiet_NaN(); }));
}

TEST(FlightMemory, AFlippedBitIsNoticedAndMendedFromTheMedium) {
  RamNonvolatile medium;
  FlightMemory memory(medium);
  FlightMemoryContent content{.life = 2};
  ASSERT_TRUE(content.good.set(90, 1));
  ASSERT_TRUE(memory.keep(content).ok());
  auto& in_memory = const_cast<FlightMemoryContent&>(memory.content());
  in_memory.life ^= 1 << 20;
  EXPECT_EQ(memory.content().life, 2);
  in_memory.good.items[0].value = 0;
  EXPECT_EQ(memory.content().good.find(90)->value, 1);
}

TEST(FlightMemory, TransactionNumbersNeverComeAgain) {
  RamNonvolatile medium;
  std::set<std::int64_t> used;
  std::int64_t of_the_store = 0;
  for (int start = 0; start < 200; ++start) {
    FlightMemory memory(medium);
    static_cast<void>(memory.load());
    // Every third start has a new database, which knows of no transaction.
    if (start % 3 == 0) of_the_store = 0;
    for (int i = 0; i < start % 100; ++i) {
      of_the_store = memory.next_transaction(of_the_store);
      EXPECT_TRUE(used.insert(of_the_store).second) << of_the_store;
    }
  }
  EXPECT_EQ(*used.begin(), 1);
}

TEST(FlightMemory, OnlyEveryBlockOfTransactionsIsAWrite) {
  FailingNonvolatile medium;
  FlightMemory memory(medium);
  static_cast<void>(memory.load());
  std::int64_t number = 0;
  for (int i = 0; i < 640; ++i) number = memory.next_transaction(number);
  EXPECT_EQ(number, 640);
  EXPECT_EQ(medium.writes, 10);
}

TEST(FlightMemory, WithoutAMediumNumbersGoOnAllTheSame) {
  FailingNonvolatile medium;
  medium.refuse = true;
  FlightMemory memory(medium);
  static_cast<void>(memory.load());
  std::int64_t number = 0;
  for (int i = 0; i < 200; ++i) {
    const std::int64_t next = memory.next_transaction(number);
    EXPECT_EQ(next, number + 1);
    number = next;
  }
  EXPECT_STATUS(memory.kept(), io_error);
  // A store with higher numbers is trusted.
  EXPECT_EQ(memory.next_transaction(1000), 1001);
  memory.skip_transactions(5000);
  EXPECT_EQ(memory.next_transaction(1001), 5001);
}

}  // namespace
}  // namespace ilp
