// What ilp-store prints of a table, also where a flight was killed.
#include "sim/tools/store/table_rows.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>

#include "fsw/records/records.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#include "sim/tools/store/named_store.hpp"
#include "tests/support/said.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::store_tool {
namespace {
namespace fs = std::filesystem;

std::string rows_of(const fs::path& file, const std::string& table, const std::vector<std::string>& fields) {
  NamedStore named = NamedStore::for_reading(file.string());
  std::ostringstream out;
  EXPECT_EQ(print_rows(named.store(), table, fields, out), 0);
  return out.str();
}

template <typename Record>
void put_now(Store& store, const Record& record) {
  ASSERT_TRUE(store.begin().ok());
  ASSERT_TRUE(put(store, record).ok());
  ASSERT_TRUE(store.commit().ok());
}

class TableRowsTest : public testing::Test {
 protected:
  TableRowsTest() {
    EXPECT_TRUE(flight.open((folder / "flight.db").c_str()).ok());
    PoseRecord pose;
    for (const std::int64_t id : {7, 3}) {
      pose.id = id;
      pose.state = id == 3 ? PoseState::final : PoseState::failed;
      pose.centre[0] = 0.1;
      pose.centre[1] = -1e300;
      pose.centre[2] = static_cast<double>(id);
      put_now(flight, pose);
    }
    StripRecord strip{.id = 1};
    put_now(flight, strip);
  }
  test::TemporaryFolder folder;
  SqliteStore flight;
};

TEST_F(TableRowsTest, GiveTheFieldsThatAreAskedForInTheOrderOfIds) {
  const std::string wanted = "id\tcentre\tstate\n3\t0.1,-1e+300,3\tfinal\n7\t0.1,-1e+300,7\tfailed\n";
  EXPECT_EQ(rows_of(folder / "flight.db", "pose", {"id", "centre", "state"}), wanted) << "a flight has it open";
  EXPECT_EQ(rows_of(folder / "flight.db", "overlap", {"id"}), "id\n");
  const std::string all = rows_of(folder / "flight.db", "pose", {});
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 3);
}

TEST_F(TableRowsTest, OfAFlightThatWasKilledAreThereAndItsLogStaysAsItIs) {
  test::TemporaryFolder killed;
  for (const char* name : {"flight.db", "flight.db-wal"}) fs::copy_file(folder / name, killed / name);
  const auto log = fs::file_size(killed / "flight.db-wal");
  ASSERT_GT(log, 0U);
  EXPECT_EQ(rows_of(killed / "flight.db", "pose", {"id"}), "id\n3\n7\n");
  EXPECT_EQ(fs::file_size(killed / "flight.db-wal"), log);
  SqliteStore again;
  EXPECT_TRUE(again.open((killed / "flight.db").c_str()).ok()) << "the flight goes on with it";
}

TEST_F(TableRowsTest, OfATableOrFieldThatDoesNotExistAreRefusedByName) {
  const auto fault = [&](const std::string& table, const std::string& field) -> std::string {
    return test::error_of([&] { rows_of(folder / "flight.db", table, {field}); });
  };
  EXPECT_NE(fault("poses", "id").find("no table poses"), std::string::npos);
  EXPECT_NE(fault("pose", "focal").find("no field focal"), std::string::npos);
}

}  // namespace
}  // namespace ilp::store_tool
