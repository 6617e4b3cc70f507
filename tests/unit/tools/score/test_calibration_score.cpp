#include "sim/tools/score/calibration_score.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fsw/records/serial.hpp"
#include "sim/ground/intake/flight_model.hpp"

namespace ilp::score {
namespace {

const CameraModel truth{640, 480, 500, 500, 319.5, 239.5, 0, 0, 0, 0};

TEST(CalibrationScore, AFoundCameraIsComparedWithTheTruth) {
  intake::Flight flight;
  CameraRecord camera = camera_record(truth);
  camera.fx = 496;
  camera.sigma_focal_px = 2;
  camera.source = CameraSource::calibrated;
  flight.camera_record = camera;
  flight.calibrations[1] = {};
  flight.calibrations[9] = {};
  const auto summary = calibration_summary(flight, truth);
  EXPECT_EQ(summary.at("camera_calibrated"), 1);
  EXPECT_EQ(summary.at("calibration_keyframe"), 9);
  EXPECT_DOUBLE_EQ(summary.at("focal_error_percent"), 0.8);
  EXPECT_DOUBLE_EQ(summary.at("focal_error_sigmas"), 2);
}

TEST(CalibrationScore, ANominalCameraThatFliesIsNotCalibratedButHasAnError) {
  intake::Flight flight;
  CameraRecord camera = nominal_camera_record(truth);
  camera.fx = 550;
  camera.sigma_focal_px = 50;
  camera.frozen = true;
  flight.camera_record = camera;
  flight.calibrations[9] = {};
  const auto summary = calibration_summary(flight, truth);
  EXPECT_EQ(summary.at("camera_calibrated"), 0);
  EXPECT_TRUE(std::isnan(summary.at("calibration_keyframe")));
  EXPECT_DOUBLE_EQ(summary.at("focal_error_percent"), 10);
  EXPECT_DOUBLE_EQ(summary.at("focal_error_sigmas"), 1);
}

TEST(CalibrationScore, OneThatWasNotFoundHasNoErrorAndAKnownOneNoNumberAtAll) {
  intake::Flight flight;
  flight.camera_record = nominal_camera_record(truth);
  flight.calibrations[3] = {};
  auto summary = calibration_summary(flight, truth);
  EXPECT_EQ(summary.at("camera_calibrated"), 0);
  EXPECT_TRUE(std::isnan(summary.at("focal_error_percent")));
  flight.calibrations.clear();
  flight.camera_record = camera_record(truth);
  summary = calibration_summary(flight, truth);
  for (const auto& [name, value] : summary) EXPECT_TRUE(std::isnan(value)) << name;
}

intake::RecordEntry entry_of(const CameraRecord& record) {
  const RecordInfo& info = record_info<CameraRecord>();
  intake::RecordEntry entry{RecordType::camera, std::vector<std::uint8_t>(serial_bytes(info)), {}};
  EXPECT_TRUE(serialize(info, &record, entry.serial).ok());
  return entry;
}

TEST(CalibrationScore, AFileFromBeforeTheCalibrationDoesNotBringTheNominalCameraBack) {
  CameraRecord nominal = nominal_camera_record(truth);
  nominal.id = nominal_camera_id;
  nominal.fx = 600;
  const CameraRecord frozen = camera_record(truth);
  for (const auto& records : {std::vector{nominal, frozen, nominal}, std::vector{frozen, nominal}}) {
    intake::Outbox outbox;
    for (const CameraRecord& record : records) outbox.records.push_back(entry_of(record));
    const intake::Flight flight = intake::build_flight(outbox);
    ASSERT_TRUE(flight.camera);
    EXPECT_EQ(flight.camera->fx, truth.fx);
  }
}

TEST(CalibrationScore, TheTrueCameraOfAFolderWithoutOneIsNone) {
  EXPECT_FALSE(true_camera("/nowhere"));
  EXPECT_FALSE(true_camera(""));
}

}  // namespace
}  // namespace ilp::score
