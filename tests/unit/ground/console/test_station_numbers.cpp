#include "sim/ground/console/station_numbers.hpp"

#include <gtest/gtest.h>

#include <ctime>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>

#include "tests/support/said.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::console {
namespace {

namespace fs = std::filesystem;

class StationNumbersTest : public testing::Test {
 protected:
  [[nodiscard]] std::string fault() const {
    return test::error_of([&] { const StationNumbers numbers(file_); });
  }
  [[nodiscard]] std::string text() const { return test::text_of(file_); }
  void write(const std::string& text) const { std::ofstream(file_) << text; }

  const test::TemporaryFolder folder_;
  const fs::path file_ = folder_ / "numbers";
};

TEST_F(StationNumbersTest, NoneIsUsedTwiceHoweverOftenTheStationStartsWithinASecond) {
  std::set<std::uint32_t> sequences, others;
  std::set<std::uint64_t> transactions;
  std::uint32_t last = 0;
  for (int start = 0; start < 20; ++start) {
    StationNumbers numbers(file_);
    for (int i = 0; i < 700; ++i) {
      const std::uint32_t sequence = numbers.next_sequence(7);
      ASSERT_GT(sequence, last) << "the flight takes rising ones only";
      last = sequence;
      ASSERT_TRUE(sequences.insert(sequence).second);
      if (i % 7 == 0) others.insert(numbers.next_sequence(8));
      if (i % 50 == 0) transactions.insert(numbers.next_transaction());
    }
  }
  EXPECT_EQ(others.size(), 2000U);
  EXPECT_EQ(transactions.size(), 280U);
}

TEST_F(StationNumbersTest, AKilledStationHasReservedWhatItUsed) {
  std::uint32_t last = 0;
  {
    StationNumbers numbers(file_);
    for (int i = 0; i < 1000; ++i) last = numbers.next_sequence(7);
    // As it stands on disk while the station runs: what a kill leaves.
    fs::copy_file(file_, folder_ / "copy");
  }
  fs::rename(folder_ / "copy", file_);
  StationNumbers numbers(file_);
  EXPECT_GT(numbers.next_sequence(7), last);
}

TEST_F(StationNumbersTest, TheyGoOnFromTheCalendarAndNeverFromAClockThatWentBack) {
  StationNumbers fresh;
  EXPECT_GE(fresh.next_sequence(7), static_cast<std::uint32_t>(std::time(nullptr)) - 1);
  write("7 4000000000\n0 9000000000000\nend\n");
  StationNumbers numbers(file_);
  EXPECT_EQ(numbers.next_sequence(7), 4000000000U) << "used in a year to come";
  EXPECT_EQ(numbers.next_transaction(), 9000000000000U);
  EXPECT_GE(numbers.next_sequence(8), static_cast<std::uint32_t>(std::time(nullptr)) - 1);
}

TEST_F(StationNumbersTest, ADamagedFileIsNamedAndNothingIsUsed) {
  EXPECT_EQ(fault(), "");
  const std::string good = text();
  EXPECT_EQ(fault(), "");
  write(good.substr(0, good.size() - 3));
  EXPECT_NE(fault().find("damaged"), std::string::npos);
  for (const char* bad : {"7 x\nend\n", "-7 5\nend\n", "70000 5\nend\n", "7 99999999999999999999\nend\n",
                          "7 5 5\nend\n", "7 5\nend\n7 1\n", "", "\x01\x02"}) {
    write(bad);
    EXPECT_NE(fault().find("damaged"), std::string::npos) << bad;
  }
}

TEST_F(StationNumbersTest, AnotherStationWithTheSameFileIsTurnedAway) {
  const StationNumbers numbers(file_);
  EXPECT_NE(fault().find("in use by another console"), std::string::npos);
}

TEST_F(StationNumbersTest, WhereTheyCannotBeKeptNoneIsGiven) {
  EXPECT_THROW(StationNumbers(folder_ / "missing/numbers"), std::runtime_error);
  StationNumbers numbers(file_);
  fs::remove_all(file_.parent_path());
  EXPECT_THROW(static_cast<void>(numbers.next_sequence(7)), std::runtime_error);
  EXPECT_THROW(static_cast<void>(numbers.next_sequence(7)), std::runtime_error) << "and none the next time";
}

TEST_F(StationNumbersTest, TheLastOnesAreNotFollowedByTheFirst) {
  write("7 4294967295\nend\n");
  StationNumbers numbers(file_);
  EXPECT_THROW(static_cast<void>(numbers.next_sequence(7)), std::runtime_error);
}

}  // namespace
}  // namespace ilp::console
