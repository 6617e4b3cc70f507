#include <gtest/gtest.h>

#include "tests/integration/flight_files.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

const fs::path plain = test::prepared_flights() / "plain";
const fs::path uninterrupted = test::prepared_flights() / "uninterrupted";

class PowerCutTest : public testing::TestWithParam<int> {};

/// Minor frames of 100 ms; the flight takes images for 76 s, every 4 s.
INSTANTIATE_TEST_SUITE_P(MinorFrames, PowerCutTest, testing::Values(1, 41, 123, 401, 765),
                         testing::PrintToStringParamName());

TEST_P(PowerCutTest, AfterwardsTheFlightEndsAsIfNothingHadHappened) {
  const test::TemporaryFolder folder;
  const fs::path out = folder / "out";
  const test::ProgramResult cut =
      test::run_program(test::sil_command(plain, out, {"--power-cut-after", std::to_string(GetParam())}));
  ASSERT_EQ(cut.exit_status, 9) << cut.output;
  test::run_well(test::sil_command(plain, out, {"--resume"}));
  test::expect_same_files(test::results_of(uninterrupted), test::results_of(out));
}

TEST(PowerCutsTest, KilledAtAnyInstantAgainAndAgainTheFlightEndsAsIfNothingHadHappened) {
  const test::TemporaryFolder folder;
  const fs::path out = folder / "out";
  const auto first = test::sil_command(plain, out, {"--power-cut-after", "3"});
  ASSERT_EQ(test::run_program(first).exit_status, 9);
  const auto command = test::sil_command(plain, out, {"--resume"});
  bool ended = false;
  // Each boot is a little longer, so that the kills fall into all stages on a machine of any speed.
  for (int boot = 0; boot < 12 && !ended; ++boot) ended = test::run_and_kill(command, 60 + 37 * boot);
  if (!ended) {
    test::run_well(command);
  }
  test::expect_same_files(test::results_of(uninterrupted), test::results_of(out));
}

TEST(PowerCutsTest, AFlightThatComesBackKnowsItsGroundAgainWhateverCutsIt) {
  const test::TemporaryFolder folder;
  const test::OwnFlight flight(folder / "flight");
  flight.come_back();
  const fs::path whole = folder / "whole";
  test::run_well(test::sil_command(flight.folder(), whole));
  const auto ties = test::records_of<TieRecord>(whole);
  ASSERT_FALSE(ties.empty());
  EXPECT_EQ(ties.back().to_strip_id, 1);
  EXPECT_NEAR(ties.back().scale, 1, 0.2) << "the first baselines are about as long";

  const fs::path out = folder / "out";
  ASSERT_EQ(test::run_program(test::sil_command(flight.folder(), out, {"--power-cut-after", "600"})).exit_status, 9);
  const auto command = test::sil_command(flight.folder(), out, {"--resume"});
  bool ended = false;
  for (int boot = 0; boot < 12 && !ended; ++boot) ended = test::run_and_kill(command, 60 + 37 * boot);
  if (!ended) {
    test::run_well(command);
  }
  test::expect_same_files(test::results_of(whole), test::results_of(out));
  EXPECT_EQ(test::records_of<LinkRecord>(out).size(), test::records_of<LinkRecord>(whole).size());
}

TEST(PowerCutsTest, ResumingWithAnotherCameraIsRefused) {
  const test::TemporaryFolder folder;
  const fs::path out = folder / "out";
  ASSERT_EQ(test::run_program(test::sil_command(plain, out, {"--power-cut-after", "50"})).exit_status, 9);
  test::write_file(folder / "other.txt", "1 PINHOLE 320 240 300 300 160 120\n");
  const test::ProgramResult result = test::run_program(
      {ILP_SIL, "--images", plain.string(), "--camera", folder / "other.txt", "--out", out.string(), "--resume"});
  EXPECT_EQ(result.exit_status, 1);
  EXPECT_NE(result.output.find("camera"), std::string::npos) << result.output;
}

TEST(PowerCutsTest, ResumingWhereNothingWasBegunIsRefused) {
  const test::TemporaryFolder folder;
  const test::ProgramResult result = test::run_program(test::sil_command(plain, folder / "out", {"--resume"}));
  EXPECT_EQ(result.exit_status, 1);
  EXPECT_NE(result.output.find("--resume"), std::string::npos) << result.output;
}

}  // namespace
}  // namespace ilp
