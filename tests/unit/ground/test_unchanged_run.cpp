// A run does what has changed since the run before, notices every other change of its folder, and writes nothing again.
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <fstream>
#include <map>
#include <sstream>

#include "sim/ground/ground_run.hpp"
#include "sim/ground/intake/outbox_reader.hpp"
#include "sim/ground/map/damaged_catalogue.hpp"
#include "sim/ground/received_flight.hpp"
#include "sim/ground/run_record.hpp"
#include "sim/host/files.hpp"
#include "tests/support/said.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::ground {
namespace {
namespace fs = std::filesystem;

using States = std::map<std::string, host::FileState>;
using Contents = std::map<std::string, std::vector<std::uint8_t>>;

bool of_the_run_itself(const std::string& name) {
  return name == "results.txt" || name.starts_with("catalogue.db");
}

class UnchangedRun : public testing::Test {
 protected:
  UnchangedRun() {
    test::SyntheticFlight flight = test::make_flight(false);
    flight.views[3].strip_id = flight.views[4].strip_id = 2;
    test::write_outbox(flight, complete_);
    options_.outbox = folder_.path() / "outbox";
    options_.out = folder_.path() / "out";
    fs::copy(complete_, options_.outbox);
  }

  /// As the program does it. True when there was nothing to do.
  bool run() {
    messages_.str("");
    if (auto known = summary_if_unchanged(options_, messages_)) {
      lines_ = *known;
      return true;
    }
    lines_ = summary_of(options_, run_ground(options_, messages_));
    return false;
  }

  [[nodiscard]] States states() const {
    States states;
    for (const auto& entry : fs::recursive_directory_iterator(options_.out)) {
      if (const auto state = host::state_of(entry.path())) {
        states[fs::relative(entry.path(), options_.out).string()] = *state;
      }
    }
    return states;
  }
  [[nodiscard]] Contents contents() const {
    Contents contents;
    for (const auto& [name, state] : states()) {
      if (!of_the_run_itself(name)) contents[name] = host::read_file(options_.out / name);
    }
    return contents;
  }
  /// The files that a second look finds with other times.
  [[nodiscard]] std::vector<std::string> written_since(const States& before) const {
    std::vector<std::string> names;
    for (const auto& [name, state] : states()) {
      const auto found = before.find(name);
      if (!of_the_run_itself(name) && (found == before.end() || found->second != state)) names.push_back(name);
    }
    return names;
  }

  /// One octet is another one; size and time of the last change are as before.
  void damage(const std::string& name) const {
    const fs::path path = options_.out / name;
    const auto time = fs::last_write_time(path);
    auto bytes = host::read_file(path);
    bytes[bytes.size() / 2] ^= 0x10U;
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    fs::last_write_time(path, time);
  }

  test::TemporaryFolder folder_;
  const fs::path complete_ = folder_.path() / "complete";
  GroundOptions options_;
  std::ostringstream messages_;
  std::vector<std::string> lines_;
};

TEST_F(UnchangedRun, ASecondRunSaysTheSameAndWritesNoFile) {
  ASSERT_FALSE(run());
  const States before = states();
  const std::vector<std::string> said = lines_;
  ASSERT_GT(before.size(), 40U);
  EXPECT_TRUE(run());
  EXPECT_EQ(states(), before);
  EXPECT_EQ(lines_, said);
}

TEST_F(UnchangedRun, TheRecordNamesEveryFileOfTheResults) {
  (void)run();
  std::map<std::string, ResultFile> recorded = read_record(options_.out).files;
  for (const auto& [name, state] : states()) {
    EXPECT_TRUE(name == "results.txt" || recorded.contains(name)) << name;
    recorded.erase(name);
  }
  EXPECT_TRUE(recorded.empty()) << recorded.begin()->first;
}

TEST_F(UnchangedRun, ResultsWithoutACatalogueAreNotReplacedByThoseOfAnotherDownlink) {
  options_.keep_copies = false;
  ASSERT_FALSE(run());
  const States before = states();
  options_.outbox = complete_;
  EXPECT_TRUE(
      test::says(test::error_of([&] { (void)run(); }), "are of the downlink " + (folder_.path() / "outbox").string()));
  EXPECT_EQ(states(), before);
  options_.afresh = true;
  EXPECT_FALSE(run());
}

TEST_F(UnchangedRun, WhatWasDamagedOrDeletedIsMadeAgain) {
  (void)run();
  const Contents expected = contents();
  for (const auto& [name, content] : expected) damage(name);
  EXPECT_FALSE(run());
  for (const auto& [name, content] : expected) {
    EXPECT_NE(messages_.str().find(name + " is missing or was changed"), std::string::npos) << name;
  }
  EXPECT_TRUE(contents() == expected);
  for (const char* name : {"report.html", "height.tif", "keyframes/000002-mask.png", "colmap/points3D.txt"}) {
    fs::remove(options_.out / name);
  }
  EXPECT_FALSE(run());
  EXPECT_TRUE(contents() == expected);
  EXPECT_TRUE(run());
}

TEST_F(UnchangedRun, ADamagedFileOfTheMapCostsNoOtherMapItsFiles) {
  (void)run();
  const States before = states();
  damage("keyframes/000001-depth.pfm");
  fs::remove(options_.out / "sigma-strip-2.tif");
  EXPECT_FALSE(run());
  for (const std::string& name : written_since(before)) {
    const bool page = name == "report.json" || name == "report.html" || name == "viewer.html";
    EXPECT_TRUE(page || name == "keyframes/000001-depth.pfm" || name == "sigma-strip-2.tif") << name;
  }
}

TEST_F(UnchangedRun, ARecordThatIsDamagedOrGoneIsMadeAgain) {
  (void)run();
  const Contents expected = contents();
  damage("results.txt");
  EXPECT_FALSE(run());
  EXPECT_TRUE(run());
  fs::remove(options_.out / "results.txt");
  EXPECT_FALSE(run());
  EXPECT_TRUE(run());
  EXPECT_TRUE(contents() == expected);
}

TEST_F(UnchangedRun, ACatalogueThatWasWrittenToIsNoticed) {
  (void)run();
  const Contents expected = contents();
  damage("catalogue.db");
  EXPECT_FALSE(run());
  EXPECT_TRUE(contents() == expected);
  EXPECT_TRUE(run());
}

TEST_F(UnchangedRun, WhatTheCatalogueHasLostIsNewsForTheNextRun) {
  (void)run();
  const Contents expected = contents();
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((options_.out / "catalogue.db").c_str(), &database), SQLITE_OK);
  const char* damage = "UPDATE file SET contents = x'00' WHERE name = 'product-000002-image.jp2'";
  EXPECT_EQ(sqlite3_exec(database, damage, nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(database);
  EXPECT_FALSE(run());
  EXPECT_FALSE(contents() == expected);
  EXPECT_FALSE(run());
  EXPECT_TRUE(contents() == expected);
  EXPECT_TRUE(run());
}

TEST_F(UnchangedRun, DamageThatTheFileSystemDoesNotShowIsFoundWhenAsked) {
  (void)run();
  const Contents expected = contents();
  damage("ortho.tif");
  RunRecord record = read_record(options_.out);
  record.files.at("ortho.tif").state = *host::state_of(options_.out / "ortho.tif");
  write_record(record, options_.out);
  EXPECT_TRUE(run());
  options_.check = true;
  EXPECT_FALSE(run());
  EXPECT_TRUE(contents() == expected);
  EXPECT_TRUE(run());
}

TEST_F(UnchangedRun, ChangedOptionsAndInputsAreNoticed) {
  const auto anchor_at = [&](int longitude) {
    std::ofstream(folder_.path() / "anchor.json")
        << R"({"body": "mars", "strips": [{"strip": 1, "latitude": 4, "height": 1000, "azimuth": 0,)"
        << R"("metres_per_unit": 2, "longitude": )" << longitude << "}]}";
  };
  anchor_at(10);
  options_.anchor = folder_.path() / "anchor.json";
  (void)run();
  Contents before = contents();
  const auto changed = [&](const char* what) {
    EXPECT_FALSE(run()) << what;
    std::vector<std::string> names;
    for (const auto& [name, content] : contents()) {
      if (before[name] != content) names.push_back(name);
    }
    before = contents();
    EXPECT_TRUE(run()) << what;
    return names;
  };
  options_.title = "Another title";
  EXPECT_FALSE(changed("title").empty());
  options_.max_vertices = 2000;
  const auto with_fewer_vertices = changed("vertices");
  EXPECT_NE(std::find(with_fewer_vertices.begin(), with_fewer_vertices.end(), "model.ply"), with_fewer_vertices.end());
  anchor_at(11);
  const auto anchored = changed("anchor");
  EXPECT_NE(std::find(anchored.begin(), anchored.end(), "height.tif"), anchored.end());
  EXPECT_EQ(std::find(anchored.begin(), anchored.end(), "height-strip-2.tif"), anchored.end());
  test::write_truth(test::make_flight(false), folder_.path() / "truth", 1, Mat3::Identity(), Vec3::Zero());
  options_.truth = folder_.path() / "truth";
  EXPECT_FALSE(changed("truth").empty());
}

TEST_F(UnchangedRun, ANewKeyframeLeavesWhatItDoesNotConcern) {
  for (const char* name : {"records-000003.ilp", "product-000003-depth.jp2", "product-000003-image.jp2"}) {
    fs::remove(options_.outbox / name);
  }
  (void)run();
  const States before = states();
  fs::copy(complete_, options_.outbox, fs::copy_options::skip_existing | fs::copy_options::recursive);
  EXPECT_FALSE(run());
  bool map_written = false;
  for (const std::string& name : written_since(before)) {
    map_written = map_written || name == "height.tif";
    EXPECT_EQ(name.find("-strip-2"), std::string::npos) << name;
    EXPECT_TRUE(!name.starts_with("keyframes/") || name.starts_with("keyframes/000003")) << name;
  }
  EXPECT_TRUE(map_written);
  const Contents late = contents();
  options_.afresh = true;
  (void)run();
  EXPECT_TRUE(contents() == late);
}

TEST_F(UnchangedRun, ACopyOfTheFolderKeepsItsPictures) {
  (void)run();
  fs::copy(options_.out, folder_.path() / "copy", fs::copy_options::recursive);
  options_.out = folder_.path() / "copy";
  const States before = states();
  EXPECT_FALSE(run());
  for (const std::string& name : written_since(before)) {
    EXPECT_TRUE(name.starts_with("report.") || name == "viewer.html") << name;
  }
  EXPECT_TRUE(run());
}

TEST_F(UnchangedRun, MissingAcknowledgementsAreWrittenAgain) {
  options_.acknowledge = folder_.path() / "acknowledged";
  (void)run();
  const auto files = intake::files_of(options_.acknowledge);
  ASSERT_EQ(files.size(), intake::files_of(options_.outbox).size());
  const auto expected = host::read_file(files[2]);
  fs::remove(files[2]);
  EXPECT_TRUE(run());
  EXPECT_EQ(host::read_file(files[2]), expected);
}

TEST(DamagedCatalogue, IsNamedByItsFileOrItsAddress) {
  ground::GroundOptions options{.out = "results"};
  const auto reported = [&] {
    return test::error_of(
        [&] { ground::naming_catalogue(options, [] { throw map::DamagedCatalogue("a tile cannot be read back"); }); });
  };
  EXPECT_EQ(reported(),
            "results/catalogue.db is damaged: a tile cannot be read back; --afresh makes it again from the outbox");
  options.catalogue = "dbname=missions";
  EXPECT_EQ(reported().find("dbname=missions is damaged"), 0U);
}

}  // namespace
}  // namespace ilp::ground
