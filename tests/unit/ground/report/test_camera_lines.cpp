#include <gtest/gtest.h>

#include <string>

#include "sim/ground/report/camera_lines.hpp"

namespace ilp::report {
namespace {

intake::Flight flight_with(CalibrationVerdict verdict, bool frozen, CameraSource source) {
  intake::Flight flight;
  CameraRecord camera;
  camera.frozen = frozen;
  camera.source = source;
  flight.camera_record = camera;
  for (std::int64_t id = 1; id <= 6; ++id) {
    flight.calibrations[id].id = id;
    flight.calibrations[id].verdict = id == 1 ? CalibrationVerdict::collecting : verdict;
  }
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

TEST(CameraLines, OverFlatGroundTheFindingAndThreeWaysOutAreTold) {
  const std::string text = text_of(flight_with(CalibrationVerdict::planar, false, CameraSource::nominal));
  for (const char* part : {"planar", "6 keyframes", "--camera", "calibration_fallback = nominal", "--navigation"})
    EXPECT_TRUE(says(text, part)) << part << "\n" << text;
}

TEST(CameraLines, TheWayOutFollowsFromTheFinding) {
  EXPECT_TRUE(says(text_of(flight_with(CalibrationVerdict::critical_motion, false, CameraSource::nominal)), "0.1 rad"));
  EXPECT_TRUE(says(text_of(flight_with(CalibrationVerdict::too_few_matches, false, CameraSource::nominal)), "texture"));
  EXPECT_FALSE(says(text_of(flight_with(CalibrationVerdict::critical_motion, false, CameraSource::nominal)), "relief"));
}

TEST(CameraLines, AFlightThatWentOnWithTheNominalCameraIsToldWhatThatMeans) {
  const std::string text = text_of(flight_with(CalibrationVerdict::planar, true, CameraSource::nominal));
  EXPECT_TRUE(says(text, "heights are as wrong as its focal length")) << text;
  EXPECT_FALSE(says(text, "calibration_fallback")) << text;
}

TEST(CameraLines, NothingIsSaidOfACameraThatWasFoundOrGiven) {
  EXPECT_EQ(text_of(flight_with(CalibrationVerdict::ok, true, CameraSource::calibrated)), "");
  intake::Flight given = flight_with(CalibrationVerdict::ok, true, CameraSource::given);
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
