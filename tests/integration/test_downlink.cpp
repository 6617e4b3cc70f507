// A downlink as links deliver it: in any order, a fifth missing, some products cut at a layer, some files damaged.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <sstream>

#include "fsw/vision/codec/jpeg2000.hpp"
#include "fsw/vision/codec/jpeg2000_decode.hpp"
#include "sim/ground/ground_run.hpp"
#include "sim/host/files.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

const fs::path flown = test::prepared_flights() / "uninterrupted" / "outbox";

/// What becomes of each file on its way.
struct Downlink {
  std::map<std::string, Bytes> valid;    ///< complete, or cut at a layer
  std::map<std::string, Bytes> damaged;  ///< differ from what was sent, as long as it
  std::set<std::string> missing, cut;
};

Bytes first_layer_of(Bytes file) {
  std::size_t bytes = 0;
  EXPECT_TRUE(truncate_to_layers(file, 1, bytes).ok());
  file.resize(bytes);
  return file;
}

int layers_of(const Bytes& file) {
  Jpeg2000Info info;
  return read_jpeg2000_header(file, info).ok() ? info.layers : 0;
}

Downlink make_downlink(unsigned seed) {
  std::mt19937 random(seed);
  Downlink downlink;
  for (const fs::path& path : intake::files_of(flown)) {
    const std::string name = path.filename().string();
    Bytes bytes = host::read_file(path);
    const auto fate = random() % 20;
    if (fate < 4) {
      downlink.missing.insert(name);
    } else if (fate < 7 && name.ends_with(".jp2") && layers_of(bytes) > 1) {
      downlink.cut.insert(name);
      downlink.valid[name] = first_layer_of(std::move(bytes));
    } else if (fate < 10) {
      for (int k = 0; k < 3; ++k) bytes[bytes.size() / 3 + random() % (bytes.size() / 2)] ^= 0x41U;
      downlink.damaged[name] = std::move(bytes);
    } else {
      downlink.valid[name] = std::move(bytes);
    }
  }
  return downlink;
}

report::Report run(const fs::path& box, const fs::path& out) {
  ground::GroundOptions options{.outbox = box, .out = out};
  std::ostringstream messages;
  return run_ground(options, messages);
}

void write(const fs::path& box, const std::map<std::string, Bytes>& files) {
  fs::create_directories(box);
  for (const auto& [name, bytes] : files) host::write_file(box / name, bytes);
}

void expect_same_map(const fs::path& a, const fs::path& b) {
  for (const char* name : {"height.tif", "sigma.tif", "sigma-matching.tif", "count.tif", "ortho.tif"}) {
    ASSERT_EQ(fs::exists(a / name), fs::exists(b / name)) << name;
    if (!fs::exists(a / name)) continue;
    EXPECT_EQ(host::read_file(a / name), host::read_file(b / name)) << name;
  }
}

class DamagedDownlinkTest : public testing::TestWithParam<unsigned> {};

TEST_P(DamagedDownlinkTest, TheMergeCompletesSaysWhatIsMissingAndTakesNothingDamaged) {
  const test::TemporaryFolder folder;
  const Downlink downlink = make_downlink(GetParam());
  ASSERT_FALSE(downlink.missing.empty());
  ASSERT_FALSE(downlink.damaged.empty());

  // In any order, in four rounds.
  std::vector<std::pair<std::string, Bytes>> arrivals(downlink.valid.begin(), downlink.valid.end());
  arrivals.insert(arrivals.end(), downlink.damaged.begin(), downlink.damaged.end());
  std::shuffle(arrivals.begin(), arrivals.end(), std::mt19937(GetParam() + 100));
  const fs::path box = folder / "box", out = folder / "out";
  fs::create_directories(box);
  report::Report report;
  for (std::size_t round = 0; round < 4; ++round) {
    for (std::size_t i = round; i < arrivals.size(); i += 4)
      host::write_file(box / arrivals[i].first, arrivals[i].second);
    report = run(box, out);
  }

  const fs::path valid_box = folder / "valid", valid_out = folder / "valid-out";
  write(valid_box, downlink.valid);
  (void)run(valid_box, valid_out);
  expect_same_map(out, valid_out);

  // Damaged record files prove it themselves; products where their record has come.
  std::set<std::string> faulty;
  for (const intake::ReceivedFile& file : report.outbox.files) {
    if (!file.fault.empty()) faulty.insert(file.name);
  }
  for (const auto& [name, bytes] : downlink.damaged) {
    const std::string records = "records-" + name.substr(name.find('-') + 1, 6) + ".ilp";
    const bool proved = name.ends_with(".ilp") || downlink.valid.contains(records);
    EXPECT_TRUE(faulty.contains(name) || !proved) << name;
  }
  for (const auto& [name, bytes] : downlink.valid) EXPECT_FALSE(faulty.contains(name)) << name;

  // What did not come whole of a keyframe whose records came is reported.
  const auto reported = [&](std::int64_t id, const std::string& what) {
    return std::any_of(report.missing.begin(), report.missing.end(), [&](const intake::Missing& m) {
      return m.keyframe_id == id && m.what.find(what) != std::string::npos && m.centre;
    });
  };
  for (const intake::ReceivedFile& file : intake::read_outbox(flown).files) {
    if (!file.name.ends_with(".jp2")) continue;
    const std::string digits = file.name.substr(8, 6);
    if (!downlink.valid.contains("records-" + digits + ".ilp")) continue;
    const std::string kind = file.name.find("image") == std::string::npos ? "its depth" : "its image";
    const bool whole = downlink.valid.contains(file.name) && !downlink.cut.contains(file.name);
    EXPECT_NE(reported(std::stoll(digits), kind), whole) << file.name;
  }

  // Everything comes at last: nothing damaged was taken for good.
  for (const fs::path& path : intake::files_of(flown)) host::write_file(box / path.filename(), host::read_file(path));
  const report::Report complete = run(box, out);
  EXPECT_TRUE(complete.missing.empty());
  (void)run(flown, folder / "complete");
  expect_same_map(out, folder / "complete");
}

// Every fifth file is missing.
TEST(LinkedDownlinkTest, OfStripsThatComeBackToTheirGroundWhatCameIsJoinedAndTheRestIsTold) {
  const test::TemporaryFolder folder;
  const test::OwnFlight flight(folder / "flight");
  flight.come_back();
  const fs::path out = folder / "out";
  test::run_well(test::sil_command(flight.folder(), out));
  const std::vector<fs::path> sent = intake::files_of(out / "outbox");
  const fs::path whole_out = folder / "whole";
  const report::Report whole = run(out / "outbox", whole_out);
  EXPECT_TRUE(whole.missing.empty()) << "keyframes of which all is known have no products";
  ASSERT_EQ(whole.joined.models.size(), 1U);
  const std::size_t all_members = whole.joined.models[0].members.size();
  EXPECT_GE(whole.joined.models[0].strips.size(), 2U);

  const fs::path box = folder.path() / "part" / "out" / "outbox";
  const fs::path at_once = folder / "once";
  const fs::path by_parts = folder / "parts";
  fs::create_directories(box);
  std::vector<fs::path> came;
  for (std::size_t i = 0; i < sent.size(); ++i) {
    if (i % 5 != 1) came.push_back(sent[i]);
  }
  // The later half first.
  for (std::size_t i = came.size() / 2; i < came.size(); ++i) {
    host::write_file(box / came[i].filename(), host::read_file(came[i]));
  }
  (void)run(box, by_parts);
  for (std::size_t i = 0; i < came.size() / 2; ++i) {
    host::write_file(box / came[i].filename(), host::read_file(came[i]));
  }
  (void)run(box, by_parts);
  const report::Report report = run(box, at_once);
  EXPECT_EQ(host::read_file(by_parts / "report.json"), host::read_file(at_once / "report.json"));
  expect_same_map(by_parts, at_once);

  EXPECT_FALSE(report.missing.empty());
  ASSERT_LE(report.joined.models.size(), 1U);
  for (const model::JoinedModel& model : report.joined.models) {
    EXPECT_LE(model.members.size(), all_members);
    EXPECT_GE(model.members.size(), all_members / 2);
    EXPECT_LT(model.median_error_px, 1);
    for (const model::JoinedModel::Member& member : model.members) {
      ASSERT_TRUE(report.flight.keyframes.contains(member.keyframe_id));
      EXPECT_TRUE(report.flight.keyframes.at(member.keyframe_id).posed()) << member.keyframe_id;
    }
  }
  for (const model::StripApart& apart : report.joined.apart) EXPECT_FALSE(apart.why.empty()) << apart.strip_id;
  EXPECT_FALSE(report.joined.models.empty()) << "links of other keyframes came";

  // What was missing comes at last.
  for (const fs::path& path : sent) host::write_file(box / path.filename(), host::read_file(path));
  EXPECT_TRUE(run(box, at_once).missing.empty());
  EXPECT_EQ(host::read_file(whole_out / "report.json"), host::read_file(at_once / "report.json"));
  expect_same_map(whole_out, at_once);
}

INSTANTIATE_TEST_SUITE_P(Seeds, DamagedDownlinkTest, testing::Range(1U, 5U));

}  // namespace
}  // namespace ilp
