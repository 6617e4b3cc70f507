// What came is taken in once and counts from then on, in whatever order and state it came.
#include <gtest/gtest.h>

#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <thread>

#include "sim/ground/ground_run.hpp"
#include "sim/ground/intake/catalogue.hpp"
#include "sim/host/files.hpp"
#include "tests/support/kill_after_changes.hpp"
#include "tests/support/said.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::intake {
namespace {
namespace fs = std::filesystem;
using test::TemporaryFolder;

class CatalogueTest : public testing::Test {
 protected:
  CatalogueTest() { test::write_outbox(test::make_flight(false), complete_); }

  void bring(const std::string& name) {
    fs::create_directories(box_);
    fs::copy_file(complete_ / name, box_ / name, fs::copy_options::overwrite_existing);
  }
  void bring_all() {
    for (const fs::path& path : files_of(complete_)) bring(path.filename().string());
  }

  report::Report run(const fs::path& out) {
    ground::GroundOptions options{.outbox = box_, .out = out, .title = "Plane"};
    messages_.str("");
    return ground::run_ground(options, messages_);
  }

  /// Everything but the catalogue and the record of the run; report.json without what depends only on the order in
  /// which files came.
  static std::map<std::string, std::vector<std::uint8_t>> results(const fs::path& out) {
    std::map<std::string, std::vector<std::uint8_t>> files;
    for (const auto& entry : fs::recursive_directory_iterator(out)) {
      const std::string name = fs::relative(entry.path(), out).string();
      if (entry.is_regular_file() && name != "results.txt" && !name.starts_with("catalogue.db"))
        files[name] = host::read_file(entry.path());
    }
    return files;
  }

  TemporaryFolder folder_;
  const fs::path complete_ = folder_.path() / "complete", box_ = folder_.path() / "outbox",
                 out_ = folder_.path() / "out";
  std::ostringstream messages_;
};

TEST_F(CatalogueTest, AnyOrderOfArrivalEndsInTheSameResult) {
  bring_all();
  (void)run(out_);
  const auto expected = results(out_);
  ASSERT_GT(expected.size(), 15U);
  std::vector<std::string> names;
  for (const fs::path& path : files_of(complete_)) names.push_back(path.filename().string());
  for (const unsigned seed : {1U, 2U, 3U}) {
    std::shuffle(names.begin(), names.end(), std::mt19937(seed));
    fs::remove_all(box_);
    const fs::path out = folder_.path() / ("out-" + std::to_string(seed));
    for (std::size_t i = 0; i < names.size(); ++i) {
      bring(names[i]);
      if (i % 5 == 4 || i + 1 == names.size()) (void)run(out);
    }
    EXPECT_EQ(results(out), expected) << "seed " << seed;
  }
}

TEST_F(CatalogueTest, OnlyWhatChangedIsPaintedAnewAndAnEmptiedOutboxLosesNothing) {
  bring_all();
  const report::Report first = run(out_);
  EXPECT_EQ(first.strips.at(0).map.painted, first.strips[0].map.tiles);
  const auto expected = results(out_);
  fs::remove_all(box_);
  fs::create_directories(box_);
  const report::Report second = run(out_);
  EXPECT_EQ(second.strips.at(0).map.painted, 0U);
  EXPECT_EQ(results(out_), expected);
}

TEST_F(CatalogueTest, AProductThatComesLateIsMerged) {
  bring_all();
  fs::remove(box_ / "product-000003-depth.jp2");
  const report::Report before = run(out_);
  ASSERT_EQ(before.missing.size(), 1U);
  EXPECT_EQ(before.missing[0].keyframe_id, 3);
  EXPECT_EQ(before.missing[0].what, "its depth");
  ASSERT_TRUE(before.missing[0].centre);
  EXPECT_NEAR((*before.missing[0].centre - test::make_flight(false).views[2].centre).norm(), 0, 1e-9);
  bring("product-000003-depth.jp2");
  const report::Report after = run(out_);
  EXPECT_TRUE(after.missing.empty());
  EXPECT_GT(after.strips.at(0).map.measured_cells, before.strips.at(0).map.measured_cells);
}

TEST_F(CatalogueTest, OfAKeyframeBetweenOthersOfWhichNothingCameThePlaceIsTold) {
  bring_all();
  for (const char* name : {"records-000003.ilp", "product-000003-depth.jp2", "product-000003-image.jp2"}) {
    fs::remove(box_ / name);
  }
  const report::Report report = run(out_);
  ASSERT_EQ(report.missing.size(), 1U);
  EXPECT_EQ(report.missing[0].what, "everything");
  const auto views = test::make_flight(false).views;
  ASSERT_TRUE(report.missing[0].centre);
  EXPECT_NEAR((*report.missing[0].centre - (views[1].centre + views[3].centre) / 2).norm(), 0, 1e-9);
}

TEST_F(CatalogueTest, DamageIsReplacedByWhatIsSoundAndNeverTheOtherWayRound) {
  bring_all();
  (void)run(out_);
  const auto expected = results(out_);

  // Damaged at first, valid later.
  const fs::path path = box_ / "product-000002-depth.jp2", records = box_ / "records-000004.ilp";
  const fs::path out = folder_.path() / "other";
  auto bytes = host::read_file(path);
  for (std::size_t i = bytes.size() / 2; i < bytes.size() / 2 + 40; ++i) bytes[i] ^= 0x5AU;
  host::write_file(path, bytes);
  fs::resize_file(records, fs::file_size(records) / 2);
  const report::Report damaged = run(out);
  EXPECT_EQ(report::totals(damaged).files_skipped, 2U);
  bring("product-000002-depth.jp2");
  bring("records-000004.ilp");
  (void)run(out);
  auto mended = results(out);
  EXPECT_EQ(mended.at("height.pfm"), expected.at("height.pfm"));
  EXPECT_EQ(mended.at("ortho.png"), expected.at("ortho.png"));

  // Sound at first, damaged later.
  host::write_file(path, bytes);
  fs::resize_file(records, fs::file_size(records) / 2);
  (void)run(out_);
  EXPECT_EQ(results(out_).at("height.pfm"), expected.at("height.pfm"));
  EXPECT_EQ(results(out_).at("ortho.png"), expected.at("ortho.png"));
}

TEST_F(CatalogueTest, TheFolderOfOneFlightDoesNotTakeAnother) {
  bring_all();
  (void)run(out_);
  const auto before = results(out_);
  test::SyntheticFlight other = test::make_flight(false);
  other.begins_ns = 500 * ns_per_s;
  fs::remove_all(box_);
  test::write_outbox(other, box_);
  const std::string refusal = test::error_of([&] { (void)run(out_); });
  EXPECT_TRUE(test::says(refusal, "another flight"));
  EXPECT_TRUE(test::says(refusal, "--afresh"));
  EXPECT_EQ(results(out_), before);
}

TEST_F(CatalogueTest, FilesOfTwoFlightsInOneFolderAreToldApartWhereTimesOrCamerasContradict) {
  bring_all();
  test::SyntheticFlight other = test::make_flight(false);
  other.begins_ns = -500 * ns_per_s;
  const fs::path foreign = folder_.path() / "foreign";
  test::write_outbox(other, foreign);
  for (const char* name : {"records-000004.ilp", "product-000005-image.jp2"}) {
    fs::copy_file(foreign / name, box_ / name, fs::copy_options::overwrite_existing);
  }
  const report::Report report = run(out_);
  std::size_t reported = 0;
  for (const ReceivedFile& file : report.outbox.files) {
    if (file.fault.find("of another flight") == std::string::npos) continue;
    EXPECT_TRUE(file.name == "records-000004.ilp" || file.name == "product-000005-image.jp2") << file.name;
    ++reported;
  }
  EXPECT_EQ(reported, 2U);
  EXPECT_NE(messages_.str().find("of another flight"), std::string::npos);
}

/// Records of a keyframe as they come down with it.
RecordFile store_epoch_file(std::size_t index, std::int64_t keyframe_id, TimeNs time_ns, double focal_length) {
  KeyframeRecord keyframe{.id = keyframe_id, .time_ns = time_ns};
  CameraRecord camera{.fx = focal_length, .fy = focal_length, .frozen = 1};
  return {index, {entry_of(camera), entry_of(keyframe)}};
}

TEST(OtherFlights, AnotherStoreEpochMayHaveAnotherCameraAndAClockThatRestarted) {
  std::vector<RecordFile> files;
  for (std::int64_t i = 1; i <= 5; ++i) files.push_back(store_epoch_file(files.size(), i, i * ns_per_s, 400));
  for (std::int64_t i = 1; i <= 3; ++i)
    files.push_back(store_epoch_file(files.size(), 100'000'000 + i, i * ns_per_s, 401));
  EXPECT_TRUE(files_of_other_flights(files).empty());
  // A store epoch whose number came from the calendar; the event with which it began shows it.
  files.push_back(store_epoch_file(files.size(), 100'000'700, ns_per_s, 402));
  EXPECT_EQ(files_of_other_flights(files).size(), 1U);
  EventRecord begun{.id = 1, .code = static_cast<std::uint16_t>(StatusCode::life_begun), .b = 100'000'650};
  files.push_back({files.size(), {entry_of(begun)}});
  EXPECT_TRUE(files_of_other_flights(files).empty());
  // Within a store epoch contradictions are found as ever.
  files.push_back(store_epoch_file(files.size(), 100'000'004, ns_per_s, 401));
  files.push_back(store_epoch_file(files.size(), 6, 6 * ns_per_s, 399));
  EXPECT_EQ(files_of_other_flights(files).size(), 2U);
}

TEST_F(CatalogueTest, ADamagedCatalogueIsSetAsideAndBegunAnew) {
  bring_all();
  (void)run(out_);
  const auto expected = results(out_);
  std::fstream file(out_ / "catalogue.db", std::ios::in | std::ios::out | std::ios::binary);
  for (int page = 1; page < 6; ++page) file.seekp(page * 4096).write("nonsense nonsense nonsense", 26);
  file.close();
  (void)run(out_);
  EXPECT_NE(messages_.str().find("quarantined"), std::string::npos);
  EXPECT_TRUE(fs::exists(out_ / "catalogue.db.damaged"));
  auto again = results(out_);
  EXPECT_EQ(again.at("height.pfm"), expected.at("height.pfm"));
  EXPECT_EQ(again.at("report.json"), expected.at("report.json"));
}

TEST_F(CatalogueTest, WhatIsDamagedInTheCatalogueIsTakenInAgain) {
  bring_all();
  (void)run(out_);
  const auto expected = results(out_);
  {
    // As bits that flip where the database does not look: in what it holds.
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open((out_ / "catalogue.db").c_str(), &database), SQLITE_OK);
    EXPECT_EQ(
        sqlite3_exec(database,
                     "UPDATE file SET contents = CAST(substr(contents, 1, length(contents) - 1) || x'55' AS BLOB) "
                     "WHERE name IN ('product-000001-image.jp2', 'records-000002.ilp')",
                     nullptr, nullptr, nullptr),
        SQLITE_OK);
    sqlite3_close(database);
  }
  const report::Report damaged = run(out_);
  EXPECT_NE(messages_.str().find("skipped product-000001-image.jp2: damaged in the catalogue"), std::string::npos)
      << messages_.str();
  EXPECT_NE(messages_.str().find("skipped records-000002.ilp: damaged in the catalogue"), std::string::npos);
  (void)run(out_);
  EXPECT_EQ(results(out_).at("height.pfm"), expected.at("height.pfm"));
  EXPECT_EQ(results(out_).at("report.json"), expected.at("report.json"));
}

TEST(CatalogueResults, AreKeptUntilARunDoesWithoutThemAndNeverReturnedDamaged) {
  const TemporaryFolder folder;
  const fs::path file = folder / "catalogue.db";
  const std::vector<std::uint8_t> one = {1, 2, 3}, two = {4, 5};
  {
    Catalogue catalogue(file);
    EXPECT_EQ(catalogue.result(7), std::nullopt);
    catalogue.put_result(7, one);
    catalogue.put_result(0xFFFFFFFFFFFFFFFFU, two);
    catalogue.put_result(9, {});
    catalogue.forget_other_results();
  }
  {
    Catalogue catalogue(file);
    EXPECT_EQ(catalogue.result(7), one);
    EXPECT_EQ(catalogue.result(0xFFFFFFFFFFFFFFFFU), two);
    catalogue.forget_other_results();
    EXPECT_EQ(catalogue.result(9), std::nullopt) << "this run did without it";
  }
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, "UPDATE result SET bytes = x'010204' WHERE digest = 7", nullptr, nullptr, nullptr),
            SQLITE_OK);
  sqlite3_close(database);
  Catalogue catalogue(file);
  EXPECT_EQ(catalogue.result(7), std::nullopt);
  EXPECT_EQ(catalogue.result(0xFFFFFFFFFFFFFFFFU), two);
}

TEST_F(CatalogueTest, KilledAnywhereTheNextRunEndsInTheSameResult) {
  bring_all();
  (void)run(out_);
  const auto expected = results(out_);
  const fs::path out = folder_.path() / "killed";
  const std::string program = ILP_GROUND_PROGRAM;
  int killed = 0, changes = 1;
  for (int round = 0; round < 12; ++round) {
    const pid_t child = fork();
    if (child == 0) {
      execl(program.c_str(), program.c_str(), box_.c_str(), "--out", out.c_str(), "--title", "Plane", nullptr);
      _exit(127);
    }
    const bool in_the_middle = test::kill_after_changes(child, out, changes);
    killed += in_the_middle ? 1 : 0;
    changes = in_the_middle ? changes + changes / 2 + 1 : 1;
  }
  EXPECT_GT(killed, 2) << "no run was killed: nothing is shown";
  (void)run(out);
  std::map<std::string, std::vector<std::uint8_t>> after = results(out);
  // A file in the writing keeps its temporary name.
  std::erase_if(after, [&](const auto& file) { return !expected.contains(file.first); });
  EXPECT_EQ(after, expected);
}

}  // namespace
}  // namespace ilp::intake
