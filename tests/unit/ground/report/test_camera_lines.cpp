#include <gtest/gtest.h>

#include <string>

#include "sim/ground/report/camera_lines.hpp"

namespace ilp::report {
namespace {

/// What the keyframes leave of the prior errors of the focal length and of k1.
struct Left {
  double focal_length, k1;
};

intake::Flight flight_with(CalibrationVerdict verdict, bool frozen, Left left) {
  intake::Flight flight;
  CameraRecord camera;
  camera.frozen = frozen;
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

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(CameraLines, AnOpenFocalLengthIsToldWithItsErrorAndWhatWouldDetermineIt) {
  const std::string text = text_of(flight_with(CalibrationVerdict::partly, true, {0.9, 0.1}));
  for (const char* part :
       {"6 keyframes", words_of(CalibrationVerdict::partly), "focal length", "45.0 px", "relief", "--navigation"})
    EXPECT_TRUE(says(text, part)) << part << "\n" << text;
  EXPECT_FALSE(says(text, words_of(Intrinsic::k1))) << text;
}

TEST(CameraLines, WhatHasBeenFoundIsNotCalledOpen) {
  const std::string text = text_of(flight_with(CalibrationVerdict::partly, true, {0.1, 0.9}));
  EXPECT_TRUE(says(text, words_of(Intrinsic::k1))) << text;
  EXPECT_FALSE(says(text, "Its focal length")) << text;
  EXPECT_FALSE(says(text_of(flight_with(CalibrationVerdict::partly, true, {0.4, 0.4})), "as it was given"));
}

TEST(CameraLines, AnOpenReadoutTimeIsToldAndOneThatWasFoundIsNot) {
  intake::Flight flight = flight_with(CalibrationVerdict::ok, true, {0.1, 0.1});
  CalibrationRecord& said = flight.calibrations[6];
  said.prior_sigma_readout_s = 0.05;
  said.readout_s = 0.0298;
  said.sigma_readout_s = 0.001;
  EXPECT_EQ(text_of(flight), "");
  said.sigma_readout_s = 0.04;
  for (const char* part : {"readout time", "40", "ms", "swings"}) EXPECT_TRUE(says(text_of(flight), part)) << part;
}

TEST(CameraLines, OfALensThatWasGivenNothingIsOpen) {
  intake::Flight flight = flight_with(CalibrationVerdict::unexplained, true, {0.1, 0.1});
  CalibrationRecord& said = flight.calibrations[6];
  for (auto& sigma : said.prior_sigmas) sigma = 0;
  EXPECT_FALSE(says(text_of(flight), "as it was given")) << text_of(flight);
}

TEST(CameraLines, AFlightThatEndedDuringTheSearchHasNoFinalPose) {
  EXPECT_TRUE(says(text_of(flight_with(CalibrationVerdict::searching, false, {1, 1})), "no keyframe has a final pose"));
}

TEST(CameraLines, NothingIsSaidOfACameraThatWasFoundOrGiven) {
  EXPECT_EQ(text_of(flight_with(CalibrationVerdict::ok, true, {0.1, 0.1})), "");
  intake::Flight given = flight_with(CalibrationVerdict::ok, true, {1, 1});
  given.calibrations.clear();
  EXPECT_EQ(text_of(given), "");
}

TEST(CameraLines, ACameraThatTheImagesContradictIsNamedWithTheValueThatTheyAskFor) {
  intake::Flight flight;
  CameraRecord camera;
  camera.k1 = -0.07;
  flight.camera_record = camera;
  CalibrationCheckRecord& check = flight.camera_checks[2];
  EXPECT_EQ(text_of(flight), "") << "nothing seen";
  check.verdict = CameraCheckVerdict::fits;
  EXPECT_EQ(text_of(flight), "");
  check.verdict = CameraCheckVerdict::contradicts;
  check.worst = Intrinsic::k1;
  check.worst_correction = -0.01;
  check.worst_sigmas = 9.25;
  const std::string text = text_of(flight);
  for (const char* part : {"strip 2", "radial distortion k1 -0.0800 instead of -0.0700", "9.25 sigmas", "camera file"})
    EXPECT_TRUE(says(text, part)) << part << "\n" << text;
  check.verdict = CameraCheckVerdict::unexplained;
  check.spread = 59;
  EXPECT_TRUE(says(text_of(flight), "59.0 times as far apart")) << text_of(flight);
  EXPECT_TRUE(says(text_of(flight), "rolling shutter"));
  check.spread = 0.5;
  check.field = 2.3;
  EXPECT_TRUE(says(text_of(flight), "residuals stay 2.30 times")) << text_of(flight);
  EXPECT_FALSE(says(text_of(flight), "far apart"));
}

}  // namespace
}  // namespace ilp::report
