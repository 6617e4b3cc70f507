#include <gtest/gtest.h>

#include <string>

#include "sim/ground/report/unknown_camera.hpp"

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
  for (const std::string& line : unknown_camera_lines(flight)) text += line + "\n";
  return text;
}

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(UnknownCamera, OverFlatGroundTheFindingAndThreeWaysOutAreTold) {
  const std::string text = text_of(flight_with(CalibrationVerdict::planar, false, CameraSource::nominal));
  for (const char* part : {"planar", "6 keyframes", "--camera", "calibration_fallback = nominal", "--navigation"})
    EXPECT_TRUE(says(text, part)) << part << "\n" << text;
}

TEST(UnknownCamera, TheWayOutFollowsFromTheFinding) {
  EXPECT_TRUE(says(text_of(flight_with(CalibrationVerdict::critical_motion, false, CameraSource::nominal)), "0.1 rad"));
  EXPECT_TRUE(says(text_of(flight_with(CalibrationVerdict::too_few_matches, false, CameraSource::nominal)), "texture"));
  EXPECT_FALSE(says(text_of(flight_with(CalibrationVerdict::critical_motion, false, CameraSource::nominal)), "relief"));
}

TEST(UnknownCamera, AFlightThatWentOnWithTheNominalCameraIsToldWhatThatMeans) {
  const std::string text = text_of(flight_with(CalibrationVerdict::planar, true, CameraSource::nominal));
  EXPECT_TRUE(says(text, "heights are as wrong as its focal length")) << text;
  EXPECT_FALSE(says(text, "calibration_fallback")) << text;
}

TEST(UnknownCamera, NothingIsSaidOfACameraThatWasFoundOrGiven) {
  EXPECT_EQ(text_of(flight_with(CalibrationVerdict::ok, true, CameraSource::calibrated)), "");
  intake::Flight given = flight_with(CalibrationVerdict::ok, true, CameraSource::given);
  given.calibrations.clear();
  EXPECT_EQ(text_of(given), "");
}

}  // namespace
}  // namespace ilp::report
