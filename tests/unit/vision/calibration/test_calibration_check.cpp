// Whether windows that were adjusted with a wrong focal length are noticed, and right ones left in peace.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "fsw/vision/calibration/calibration_check.hpp"
#include "fsw/vision/calibration/calibration_workspace.hpp"
#include "tests/unit/vision/calibration/posed_window.hpp"

namespace ilp::test {
namespace {

struct Verdicts {
  int agrees = 0, contradicts = 0, cannot_tell = 0;
};

class CalibrationCheckTest : public ::testing::Test {
 protected:
  static constexpr int flights = 24;

  static FlightScene scene(unsigned seed) {
    FlightScene scene;
    scene.seed = seed;
    scene.keyframes = 8;
    scene.wrong = 0;
    scene.field_of_view_rad = 0.7 + 0.7 * (seed * 37 % 101) / 101.0;
    return scene;
  }
  static CameraModel times(const SyntheticFlight& flight, double factor) {
    CameraModel given = flight.nominal;
    given.fx = given.fy = factor * flight.camera.fx;
    return given;
  }
  CalibrationCheck check(const FlightScene& scene, double factor) {
    const SyntheticFlight flight(scene);
    const CameraModel given = times(flight, factor);
    const PosedWindow window(flight, given);
    EXPECT_TRUE(window.ok());
    CalibrationCheck result;
    EXPECT_TRUE(check_calibration(given, window.problem(), {}, *workspace_, result).ok());
    if (result.verdict != CalibrationCheckVerdict::cannot_tell) {
      EXPECT_LT(std::abs(result.focal_px - flight.camera.fx), 4 * result.sigma_px) << scene.seed << " " << factor;
      EXPECT_NEAR(result.deviation, given.fx / result.focal_px - 1, 1e-12);
    }
    return result;
  }
  static void count(const CalibrationCheck& check, Verdicts& verdicts) {
    verdicts.agrees += check.verdict == CalibrationCheckVerdict::agrees ? 1 : 0;
    verdicts.contradicts += check.verdict == CalibrationCheckVerdict::contradicts ? 1 : 0;
    verdicts.cannot_tell += check.verdict == CalibrationCheckVerdict::cannot_tell ? 1 : 0;
  }
  Verdicts check_flights(FlightScene (*change)(FlightScene), unsigned first_seed, double factor) {
    Verdicts verdicts;
    for (unsigned i = 0; i < flights; ++i) count(check(change(scene(first_seed + i)), factor), verdicts);
    return verdicts;
  }

  std::unique_ptr<CalibrationWorkspace> workspace_ = std::make_unique<CalibrationWorkspace>();
};

FlightScene canyon(FlightScene scene) {
  return scene;
}
FlightScene flat(FlightScene scene) {
  scene.world = "flat";
  return scene;
}
FlightScene straight(FlightScene scene) {
  scene.line = true;
  return scene;
}
FlightScene with_wrong_matches(FlightScene scene) {
  scene.wrong = 0.02;
  return scene;
}

TEST_F(CalibrationCheckTest, ATenthTooMuchOrTooLittleIsNoticed) {
  for (const double factor : {0.9, 1.1}) {
    const Verdicts verdicts = check_flights(canyon, 2001, factor);
    EXPECT_EQ(verdicts.agrees, 0) << factor;
    EXPECT_GE(verdicts.contradicts, 0.9 * flights) << factor;
  }
}

TEST_F(CalibrationCheckTest, ThreePerCentAreMostlyNoticed) {
  for (const double factor : {0.97, 1.03}) {
    EXPECT_GE(check_flights(canyon, 2101, factor).contradicts, 0.7 * flights) << factor;
  }
}

TEST_F(CalibrationCheckTest, ARightFocalLengthIsNotAccused) {
  const Verdicts verdicts = check_flights(canyon, 2201, 1);
  EXPECT_EQ(verdicts.contradicts, 0);
  EXPECT_GE(verdicts.agrees, 0.9 * flights);
}

TEST_F(CalibrationCheckTest, WrongMatchesInTheWindowDoNotMislead) {
  const Verdicts right = check_flights(with_wrong_matches, 2301, 1);
  EXPECT_EQ(right.contradicts, 0);
  EXPECT_GE(right.agrees, 0.8 * flights);
  const Verdicts wrong = check_flights(with_wrong_matches, 2301, 1.1);
  EXPECT_EQ(wrong.agrees, 0);
  EXPECT_GE(wrong.contradicts, 0.8 * flights);
}

// The axes still tilt over flat ground, so that some of the windows contain a little information; none may mislead.
TEST_F(CalibrationCheckTest, FlatGroundMostlyCannotTell) {
  const Verdicts right = check_flights(flat, 2401, 1);
  EXPECT_EQ(right.contradicts, 0);
  EXPECT_GE(right.cannot_tell, 0.8 * flights);
  EXPECT_EQ(check_flights(flat, 2401, 1.1).agrees, 0);
}

TEST_F(CalibrationCheckTest, AStraightLevelFlightCannotTell) {
  for (const double factor : {1.0, 1.1}) EXPECT_EQ(check_flights(straight, 2501, factor).cannot_tell, flights);
}

// Nobody pays for an adjustment whose answer the geometry already gives.
TEST_F(CalibrationCheckTest, AStraightLevelFlightIsDecidedByItsGeometryAndACanyonIsNot) {
  for (const bool level : {true, false}) {
    FlightScene flown = scene(2501);
    flown.line = level;
    const SyntheticFlight flight(flown);
    const CameraModel given = times(flight, 1.1);
    const PosedWindow window(flight, given);
    CalibrationChecker checker(*workspace_);
    ASSERT_TRUE(checker.begin(given, window.problem(), {}).ok());
    bool pending = true;
    checker.step(pending);
    EXPECT_EQ(pending, !level);
    EXPECT_EQ(checker.result().verdict, CalibrationCheckVerdict::cannot_tell);
    EXPECT_EQ(checker.result().sigma_px, 0);
  }
}

TEST_F(CalibrationCheckTest, TooFewCamerasCannotTellAndBadWindowsAreRefused) {
  const SyntheticFlight flight(scene(2001));
  const CameraModel given = times(flight, 1);
  const PosedWindow window(flight, given);
  auto problem = std::make_unique<BundleProblem>(window.problem());
  CalibrationCheck result;
  problem->observations[7].point = static_cast<std::uint16_t>(problem->points.size());
  Status status = check_calibration(given, *problem, {}, *workspace_, result);
  EXPECT_TRUE(status.is(StatusCode::invalid_argument));
  EXPECT_EQ(status.b, 7000);
  *problem = window.problem();
  problem->observations[9].x = std::numeric_limits<double>::quiet_NaN();
  status = check_calibration(given, *problem, {}, *workspace_, result);
  EXPECT_TRUE(status.is(StatusCode::invalid_argument));
  EXPECT_EQ(status.b, 9000);
  CameraModel broken = given;
  broken.fx = -1;
  EXPECT_FALSE(check_calibration(broken, window.problem(), {}, *workspace_, result).ok());
  problem->cameras.clear();
  problem->points.clear();
  problem->observations.clear();
  ASSERT_TRUE(check_calibration(given, *problem, {}, *workspace_, result).ok());
  EXPECT_EQ(result.verdict, CalibrationCheckVerdict::cannot_tell);
  EXPECT_EQ(result.sigma_px, 0);
}

}  // namespace
}  // namespace ilp::test
