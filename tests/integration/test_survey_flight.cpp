// Recorded surveys whose consecutive images share a fifth to a half of their ground, or are turned by any angle, or
// are taken around one subject.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "sim/host/alignment.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/support/strip.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

struct Survey {
  const char* name;
  std::size_t least_posed;       ///< keyframes with a final pose
  std::size_t least_longest;     ///< poses of the longest strip
  double largest_error_percent;  ///< mean position error of any strip of four poses, of the extent
  // Of the ground's largest model.
  std::size_t least_joined;  ///< keyframes
  double joined_percent;     ///< largest mean position error, of the extent
};

void PrintTo(const Survey& survey, std::ostream* to) {
  *to << survey.name;
}

class SurveyFlight : public ::testing::TestWithParam<Survey> {};

Vec3 centre_of(const test::StripImage& image) {
  return {image.centre[0], image.centre[1], image.centre[2]};
}

/// Mean position error after alignment, over the largest distance of two reference cameras.
double error_percent(const std::vector<PoseRecord>& poses, const std::map<std::int64_t, std::int64_t>& frames,
                     const std::vector<test::StripImage>& truth, double extent) {
  std::vector<Vec3> found, references;
  for (const PoseRecord& pose : poses) {
    found.emplace_back(pose.centre[0], pose.centre[1], pose.centre[2]);
    references.push_back(centre_of(truth.at(static_cast<std::size_t>(frames.at(pose.id) - 1))));
  }
  const auto fit = host::align_positions(found, references);
  if (!fit) return 100;
  double sum = 0;
  for (std::size_t i = 0; i < found.size(); ++i) sum += (*fit * found[i] - references[i]).norm();
  return 100 * sum / static_cast<double>(found.size()) / extent;
}

/// The ground's report of the flight's files.
void expect_one_model(const Survey& survey, const fs::path& flight, const fs::path& out) {
  const fs::path reference = fs::path(test::data_root) / survey.name / "cameras.txt";
  test::run_well({ILP_GROUND, flight / "outbox", "--out", out.string(), "--reference", reference});
  const auto report = nlohmann::json::parse(std::ifstream(out / "report.json"));
  std::size_t most = 0;
  std::int64_t strip = 0;
  // Without links nothing is joined, and the strips are the models.
  const auto joined = report.value("joined", nlohmann::json{{"models", nlohmann::json::array()}});
  for (const auto& model : joined.at("models")) {
    if (model.at("keyframes").size() <= most) continue;
    most = model.at("keyframes").size();
    strip = model.at("strip");
  }
  for (const auto& one : report.at("strips")) {
    if (!joined.at("models").empty() || one.at("final_poses") <= most) continue;
    most = one.at("final_poses");
    strip = one.at("id");
  }
  EXPECT_GE(most, survey.least_joined);
  for (const auto& one : report.at("strips")) {
    if (one.at("id") != strip) continue;
    EXPECT_EQ(one.at("final_poses"), most);
    EXPECT_LT(one.at("accuracy").at("position").at("mean_percent_of_extent"), survey.joined_percent);
    // Borders of the orthoimage are no rougher than the rest.
    if (!std::string(survey.name).starts_with("revisit_")) continue;
    const auto& seams = one.at("grid").at("seams");
    EXPECT_LE(seams.at("grey").at("ratio"), 1.1);
    EXPECT_LE(seams.at("grey_step").at("ratio"), 1.1);
  }
}

TEST_P(SurveyFlight, TheChainHoldsWhereImagesShareLittleGroundAndItsPosesAreRight) {
  const Survey& survey = GetParam();
  const std::vector<test::StripImage> truth = test::read_strip(survey.name);
  if (truth.empty()) GTEST_SKIP() << "no " << survey.name << " in ../shared/data";
  double extent = 0;
  for (const auto& a : truth) {
    for (const auto& b : truth) {
      extent = std::max(extent, (centre_of(a) - centre_of(b)).norm());
    }
  }
  const test::TemporaryFolder folder;
  const fs::path out = folder / "flight";
  const fs::path data = fs::path(test::data_root) / survey.name;
  test::run_well(
      {ILP_SIL, "--images", data / "images", "--camera", data / "colmap" / "cameras.txt", "--out", out.string()});

  std::map<std::int64_t, std::int64_t> frames;
  for (const auto& keyframe : test::records_of<KeyframeRecord>(out)) frames[keyframe.id] = keyframe.frame_id;
  std::map<std::int64_t, std::vector<PoseRecord>> strips;
  std::size_t posed = 0, longest = 0;
  for (const auto& pose : test::records_of<PoseRecord>(out)) {
    if (pose.state != PoseState::final) continue;
    strips[pose.strip_id].push_back(pose);
    longest = std::max(longest, strips[pose.strip_id].size());
    ++posed;
  }
  EXPECT_GE(posed, survey.least_posed);
  EXPECT_GE(longest, survey.least_longest);
  for (const auto& [id, poses] : strips) {
    if (poses.size() < 4) continue;
    EXPECT_LT(error_percent(poses, frames, truth, extent), survey.largest_error_percent) << "strip " << id;
  }
  expect_one_model(survey, out, folder / "ground");
}

// Without the bridging the longest strips hold 5, 4 and 6 poses, and 9, 10 and 16 keyframes have one.
INSTANTIATE_TEST_SUITE_P(Recorded, SurveyFlight,
                         ::testing::Values(Survey{"revisit_boruszyn_kite", 25, 20, 0.2, 26, 0.05},
                                           Survey{"revisit_seneca_farm", 26, 7, 0.06, 37, 0.06},
                                           Survey{"aerial_coal_oil_point", 18, 15, 0.03, 18, 0.03},
                                           // Cameras that go around a doorway and a fountain.
                                           Survey{"strecha_entry_p10", 9, 9, 0.05, 9, 0.05},
                                           Survey{"strecha_fountain_p11", 10, 10, 0.03, 10, 0.03}),
                         [](const auto& survey) { return std::string(survey.param.name); });

}  // namespace
}  // namespace ilp
