// Self-calibration over hundreds of simulated flights of all kinds: how often it answers, and that it is never wrong.

#include <gtest/gtest.h>

#include <memory>

#include "fsw/vision/calibration/calibration_workspace.hpp"
#include "fsw/vision/calibration/self_calibration.hpp"
#include "tests/unit/vision/calibration/synthetic_flight.hpp"

namespace ilp::test {
namespace {

struct Tally {
  int flights = 0, answers = 0, within_a_percent = 0, wrong = 0;
};

Tally fly(FlightScene scene, unsigned first_seed, int flights) {
  const auto state = std::make_unique<CalibrationState>();
  const auto workspace = std::make_unique<CalibrationWorkspace>();
  Tally tally;
  for (int i = 0; i < flights; ++i) {
    scene.seed = first_seed + static_cast<unsigned>(i);
    scene.field_of_view_rad = 0.7 + 0.7 * (scene.seed * 37 % 101) / 101.0;
    const SyntheticFlight flight(scene);
    SelfCalibration calibration(*state, *workspace);
    EXPECT_TRUE(calibration.begin(flight.nominal, {}).ok());
    CalibrationReport report;
    for (std::size_t k = 0; k < flight.keyframes.size() && report.verdict != CalibrationVerdict::ok; ++k) {
      const FlightKeyframe& frame = flight.keyframes[k];
      EXPECT_TRUE(
          calibration
              .add_keyframe(static_cast<std::int64_t>(k), frame.corners, frame.matches, 100 * scene.seed + k, report)
              .ok());
    }
    ++tally.flights;
    if (report.verdict != CalibrationVerdict::ok) continue;
    ++tally.answers;
    const double error_px = std::abs(report.camera.fx - flight.camera.fx);
    tally.within_a_percent += error_px < 0.01 * flight.camera.fx ? 1 : 0;
    const bool wrong = error_px > 3 * report.sigma_focal_px || error_px > 0.03 * flight.camera.fx;
    tally.wrong += wrong ? 1 : 0;
    EXPECT_FALSE(wrong) << scene.world << " seed " << scene.seed << ": " << report.camera.fx << " +- "
                        << report.sigma_focal_px << ", true " << flight.camera.fx;
  }
  ::testing::Test::RecordProperty("answers", tally.answers);
  std::printf("%-12s swing %.3f: %d flights, %d answers, %d within 1 %%, %d wrong\n", scene.world.c_str(),
              scene.swing_rad, tally.flights, tally.answers, tally.within_a_percent, tally.wrong);
  return tally;
}

TEST(CalibrationFlights, RightWithinAPercentInNineOfTenOverARuggedCanyon) {
  FlightScene scene;
  scene.swing_rad = 0.1;
  const Tally tally = fly(scene, 1, 70);
  EXPECT_GE(10 * tally.within_a_percent, 9 * tally.answers);
  // A lens with a wide field, enough relief and tilt: at least in a third of the flights of ten keyframes.
  EXPECT_GE(3 * tally.answers, tally.flights);
}

TEST(CalibrationFlights, GentleSwingIsAnsweredRarelyAndRightly) {
  FlightScene scene;
  scene.swing_rad = 0.05;
  const Tally tally = fly(scene, 201, 40);
  EXPECT_GE(10 * tally.within_a_percent, 9 * tally.answers);
}

TEST(CalibrationFlights, FortyKeyframesOverACanyonAreEnoughInNineFlightsOfTen) {
  FlightScene scene;
  scene.keyframes = 40;
  const Tally tally = fly(scene, 601, 100);
  EXPECT_GE(10 * tally.within_a_percent, 9 * tally.flights);
}

TEST(CalibrationFlights, TwentyKeyframesOverSteeperGroundAreEnoughInNineFlightsOfTen) {
  FlightScene scene;
  scene.ruggedness = 1.5;
  scene.keyframes = 20;
  const Tally tally = fly(scene, 601, 60);
  EXPECT_GE(10 * tally.within_a_percent, 9 * tally.flights);
}

TEST(CalibrationFlights, AGentleSwingIsEnoughInHalfOfTheFlightsOfFortyKeyframes) {
  FlightScene scene;
  scene.swing_rad = 0.05;
  scene.keyframes = 40;
  const Tally tally = fly(scene, 601, 60);
  EXPECT_GE(2 * tally.within_a_percent, tally.flights);
  EXPECT_GE(10 * tally.within_a_percent, 9 * tally.answers);
}

TEST(CalibrationFlights, ErrorsThatFollowATrackDoNotFoolIt) {
  FlightScene scene;
  scene.swing_rad = 0.1;
  scene.drift_px = 0.1;
  const Tally tally = fly(scene, 301, 30);
  EXPECT_GE(10 * tally.within_a_percent, 9 * tally.answers);
}

TEST(CalibrationFlights, FlatGroundIsAlwaysRefused) {
  FlightScene scene;
  scene.world = "flat";
  scene.swing_rad = 0.1;
  EXPECT_EQ(fly(scene, 401, 30).answers, 0);
}

TEST(CalibrationFlights, StraightLinesAreAlwaysRefused) {
  FlightScene scene;
  scene.line = true;
  EXPECT_EQ(fly(scene, 501, 30).answers, 0);
}

}  // namespace
}  // namespace ilp::test
