// The map of a flight against the true heights of its world, measured by two programs.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/integration/flight_files.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

nlohmann::json read_json(const fs::path& path) {
  return nlohmann::json::parse(std::ifstream(path));
}

TEST(Comparison, OfAFlightWithItsTruthGivesTheErrorsThatTheScoreGives) {
  const test::TemporaryFolder scratch;
  const fs::path folder = scratch.path();
  const fs::path flight = test::prepared_flights() / "uninterrupted", truth = test::prepared_flights() / "plain/truth";
  const auto ran = [](const std::vector<std::string>& command) {
    const test::ProgramResult result = test::run_program(command);
    return result.exit_status == 0 ? std::string() : result.output;
  };
  ASSERT_EQ(ran({ILP_GROUND, flight / "outbox", "--out", folder / "ground"}), "");
  ASSERT_EQ(ran({ILP_SCORE, flight, "--truth", truth, "--out", folder / "score.json"}), "");
  const auto compare = [&](const std::string& fit) {
    EXPECT_EQ(ran({ILP_GROUND, "compare", folder / "ground", truth / "height.tif", "--poses", truth / "poses.txt",
                   "--fit", fit, "--max-slope", "89", "--out", folder / fit}),
              "");
    return read_json(folder / fit / "comparison.json");
  };
  const auto score = read_json(folder / "score.json");
  const double percent = score["strips"][0]["flying_height"].get<double>() / 100;
  const double bias = percent * score["summary"]["height_bias_percent"].get<double>();
  const double p95 = percent * score["summary"]["height_p95_percent"].get<double>();
  const auto unaligned = compare("none");
  ASSERT_GT(unaligned["difference"]["count"].get<int>(), 20000);
  EXPECT_NEAR(unaligned["difference"]["median_m"].get<double>(), bias, 0.02 * p95);
  EXPECT_NEAR(unaligned["difference"]["abs_95_m"].get<double>(), p95, 0.02 * p95);
  // The poses of this flight are exact to a small part of a pixel: the alignment finds hardly anything to move.
  const auto aligned = compare("shift");
  ASSERT_TRUE(aligned["alignment"]["aligned"].get<bool>());
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_LT(std::abs(aligned["alignment"]["shift_m"][axis].get<double>()), aligned["cell_m"].get<double>());
  }
  EXPECT_LE(aligned["difference"]["nmad_m"].get<double>(), 1.01 * unaligned["difference"]["nmad_m"].get<double>());
}

}  // namespace
}  // namespace ilp
