#include <gtest/gtest.h>

#include <string>

#include "sim/ground/report/camera_lines.hpp"
#include "tests/support/said.hpp"

namespace ilp::report {
namespace {

/// What the keyframes leave of the prior errors of the focal length and of k1.
struct Left {
  double focal_length, k1;
};

intake::Flight flight_with(CalibrationVerdict verdict, bool frozen, Left left) {
  intake::Flight flight;
  CameraRecord camera{.frozen = frozen};
  flight.camera_record = camera;
  CalibrationRecord& said = flight.calibrations[6];
  said.id = 6;
  said.keyframes = 6;
  said.verdict = verdict;
  const auto focal_length = static_cast<std::size_t>(Intrinsic::focal_length);
  const auto k1 = static_cast<std::size_t>(Intrinsic::k1);
  said.prior_sigmas[focal_length] = 50;
  said.prior_sigmas[k1] = 0.2F;
  said.sigmas[focal_length] = static_cast<float>(50 * left.focal_length);
  said.sigmas[k1] = static_cast<float>(0.2 * left.k1);
  return flight;
}

std::string text_of(const intake::Flight& flight) {
  std::string text;
  for (const std::string& line : camera_lines(flight)) text += line + "\n";
  return text;
}

TEST(CameraLines, AnOpenFocalLengthIsToldWithItsErrorAndWhatWouldDetermineIt) {
  const std::string text = text_of(flight_with(CalibrationVerdict::partly, true, {0.9, 0.1}));
  for (const char* part :
       {"6 keyframes", words_of(CalibrationVerdict::partly), "focal length", "45.0 px", "relief", "--navigation"})
    EXPECT_TRUE(test::says(text, part)) << part << "\n" << text;
  EXPECT_FALSE(test::says(text, words_of(Intrinsic::k1))) << text;
}

TEST(CameraLines, WhatHasBeenFoundIsNotCalledOpen) {
  const std::string text = text_of(flight_with(CalibrationVerdict::partly, true, {0.1, 0.9}));
  EXPECT_TRUE(test::says(text, words_of(Intrinsic::k1))) << text;
  EXPECT_FALSE(test::says(text, "Its focal length")) << text;
  EXPECT_FALSE(test::says(text_of(flight_with(CalibrationVerdict::partly, true, {0.4, 0.4})), "as it was given"));
}

TEST(CameraLines, AnOpenReadoutTimeIsToldAndOneThatWasFoundIsNot) {
  intake::Flight flight = flight_with(CalibrationVerdict::ok, true, {0.1, 0.1});
  CalibrationRecord& said = flight.calibrations[6];
  said.prior_sigma_readout_s = 0.05;
  said.readout_s = 0.0298;
  said.sigma_readout_s = 0.001;
  EXPECT_EQ(text_of(flight), "");
  said.sigma_readout_s = 0.04;
  for (const char* part : {"readout time", "40", "ms", "swings"})
    EXPECT_TRUE(test::says(text_of(flight), part)) << part;
}

TEST(CameraLines, OfALensThatWasGivenNothingIsOpen) {
  intake::Flight flight = flight_with(CalibrationVerdict::unexplained, true, {0.1, 0.1});
  CalibrationRecord& said = flight.calibrations[6];
  for (auto& sigma : said.prior_sigmas) sigma = 0;
  EXPECT_FALSE(test::says(text_of(flight), "as it was given")) << text_of(flight);
}

TEST(CameraLines, AFlightThatEndedDuringTheSearchHasNoFinalPose) {
  EXPECT_TRUE(
      test::says(text_of(flight_with(CalibrationVerdict::searching, false, {1, 1})), "no keyframe has a final pose"));
}

TEST(CameraLines, NothingIsSaidOfACameraThatWasFoundOrGiven) {
  EXPECT_EQ(text_of(flight_with(CalibrationVerdict::ok, true, {0.1, 0.1})), "");
  intake::Flight given = flight_with(CalibrationVerdict::ok, true, {1, 1});
  given.calibrations.clear();
  EXPECT_EQ(text_of(given), "");
}

TEST(CameraLines, ACameraThatTheImagesContradictIsNamedWithTheValueThatTheyAskFor) {
  intake::Flight flight;
  CameraRecord camera{.k1 = -0.07};
  flight.camera_record = camera;
  CalibrationCheckRecord& check = flight.camera_checks[2];
  EXPECT_EQ(text_of(flight), "") << "nothing seen";
  check.verdict = CameraCheckVerdict::fits;
  EXPECT_EQ(text_of(flight), "");
  check.verdict = CameraCheckVerdict::contradicts;
  check.worst = Intrinsic::k1;
  check.worst_correction = -0.01;
  check.worst_sigmas = 9.25;
  check.statistic = 41;
  const std::string text = text_of(flight);
  for (const char* part : {"strip 2", "radial distortion k1 -0.0800 instead of -0.0700", "9.25 sigmas", "camera file",
                           "contradict the camera", "statistic is 41.0", "limit of 2.50", "are wrong"})
    EXPECT_TRUE(test::says(text, part)) << part << "\n" << text;
  check.verdict = CameraCheckVerdict::unexplained;
  check.spread = 59;
  check.windows = 7;
  EXPECT_TRUE(test::says(text_of(flight), "59.0 times as far apart")) << text_of(flight);
  EXPECT_TRUE(test::says(text_of(flight), "over 7 windows")) << text_of(flight);
  EXPECT_TRUE(test::says(text_of(flight), "rolling shutter"));
  check.statistic = 1;
  check.spread = 0.5;
  check.field = 4.8;
  EXPECT_TRUE(test::says(text_of(flight), "residuals stay 4.80 times")) << text_of(flight);
  EXPECT_FALSE(test::says(text_of(flight), "far apart"));
}

TEST(CameraLines, WhatIsLittleAboveItsLimitIsNotCalledWrong) {
  intake::Flight flight;
  flight.camera_record = CameraRecord{};
  CalibrationCheckRecord& check = flight.camera_checks[1];
  check.verdict = CameraCheckVerdict::contradicts;
  check.statistic = 2.75;
  const std::string text = text_of(flight);
  for (const char* part : {"not quite", "statistic is 2.75", "limit of 2.50", "may be somewhat larger"})
    EXPECT_TRUE(test::says(text, part)) << part << "\n" << text;
  for (const char* strong : {"are wrong", "contradict"}) EXPECT_FALSE(test::says(text, strong)) << text;
  check.verdict = CameraCheckVerdict::unexplained;
  check.spread = 2.6;
  EXPECT_TRUE(test::says(text_of(flight), "fit no lens quite")) << text_of(flight);
  EXPECT_TRUE(test::says(text_of(flight), "may be somewhat too small")) << text_of(flight);
}

/// The event and the lines give one number: what is left over its limit, which a large statistic raises.
TEST(CameraLines, WhatNoLensExplainsIsToldAsItsLimitIsExceeded) {
  intake::Flight flight;
  CalibrationCheckRecord& check = flight.camera_checks[1];
  check.verdict = CameraCheckVerdict::unexplained;
  struct Case {
    double statistic, spread, field;
    const char* excess;
  };
  // Limits: 2 of the spread, a twentieth of the statistic beyond 40; 1.6 of the field, half more at a statistic of 100.
  for (const Case& one : {Case{1, 6, 1, "3.00 times its limit"}, Case{200, 30, 0, "3.00 times its limit"},
                          Case{100, 1, 7.2, "3.00 times its limit"}, Case{0, 5, 1.6, "2.50 times its limit"}}) {
    check.statistic = one.statistic;
    check.spread = one.spread;
    check.field = one.field;
    EXPECT_TRUE(test::says(text_of(flight), one.excess)) << text_of(flight);
  }
}

}  // namespace
}  // namespace ilp::report
