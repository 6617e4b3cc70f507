// Flights with an unknown camera: it is found, with an honest error, and every keyframe is posed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fsw/vision/multiview/sequence.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/report/accuracy.hpp"
#include "sim/host/colmap.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/support/page_text.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

const fs::path rugged = test::prepared_flights() / "rugged";
const fs::path flat = test::prepared_flights() / "flat";

constexpr const char* unknown_camera = "[calibration]\ncamera_known = 0\n";

class CalibrationFlightTest : public testing::Test {
 protected:
  /// The true camera of a prepared flight with another focal length and principal point.
  [[nodiscard]] fs::path camera_off_by(const fs::path& flight, double focal, double centre_px) const {
    CameraModel camera = host::read_colmap_camera(flight / "cameras.txt");
    camera.fx *= 1 + focal;
    camera.fy *= 1 + focal;
    camera.k1 *= (1 + focal) * (1 + focal);
    camera.k2 *= std::pow(1 + focal, 4);
    camera.p1 *= 1 + focal;
    camera.p2 *= 1 + focal;
    camera.cx += centre_px;
    camera.cy -= centre_px;
    host::write_colmap_camera(folder / "camera.txt", camera);
    return folder / "camera.txt";
  }
  [[nodiscard]] std::vector<std::string> command(const fs::path& flight, const fs::path& camera,
                                                 const std::string& mission, std::vector<std::string> more = {}) const {
    test::write_file(folder / "mission.ini", mission);
    std::vector<std::string> words{ILP_SIL,         "--images",  flight.string(),        "--camera",
                                   camera.string(), "--mission", folder / "mission.ini", "--out",
                                   out.string()};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  void fly(const fs::path& flight, const fs::path& camera, const std::string& mission) const {
    test::run_well(command(flight, camera, mission));
  }

  test::TemporaryFolder folder;
  fs::path out = folder / "out";
};

TEST_F(CalibrationFlightTest, OverRuggedGroundTheCameraIsFoundAndTheKeyframesThatWaitedArePosed) {
  fly(rugged, camera_off_by(rugged, 0.1, 3), unknown_camera);
  const auto cameras = test::records_of<CameraRecord>(out);
  ASSERT_EQ(cameras.size(), 3U) << "the camera, what it was taken for, and the copy of the camera";
  EXPECT_EQ(cameras[2].fx, cameras[0].fx);
  EXPECT_EQ(cameras[2].frozen, 1);
  const CameraModel truth = host::read_colmap_camera(rugged / "cameras.txt");
  EXPECT_EQ(cameras[0].frozen, 1);
  EXPECT_NEAR(cameras[0].fx, truth.fx, 0.01 * truth.fx);
  EXPECT_GT(cameras[0].sigma_focal_px, 0);
  EXPECT_NEAR(cameras[0].fx, truth.fx, 3 * cameras[0].sigma_focal_px);
  EXPECT_EQ(cameras[1].frozen, 0);
  EXPECT_NEAR(cameras[1].fx, 1.1 * truth.fx, 1e-6);
  EXPECT_EQ(test::events_of(out, StatusCode::camera_calibrated), 1U);

  const auto said = test::records_of<CalibrationRecord>(out);
  ASSERT_GE(said.size(), 2U);
  EXPECT_EQ(said.back().verdict, CalibrationVerdict::ok);
  EXPECT_DOUBLE_EQ(said.back().intrinsics[0], cameras[0].fx);
  EXPECT_EQ(said.front().verdict, CalibrationVerdict::searching);

  intake::Outbox outbox = intake::read_outbox(out / "outbox");
  const intake::Flight flight = intake::build_flight(outbox);
  std::size_t posed = 0;
  for (const auto& [id, keyframe] : flight.keyframes) {
    posed += keyframe.posed() ? 1 : 0;
    EXPECT_NEAR(keyframe.camera.fx, cameras[0].fx, 1e-9) << "the products' camera, keyframe " << id;
  }
  EXPECT_EQ(posed, flight.keyframes.size()) << "also those before keyframe " << said.back().id;
  ASSERT_EQ(flight.strips.size(), 1U);
  const report::ReferenceFiles reference(rugged / "truth" / "poses.txt", rugged / "truth" / "depth");
  const auto accuracy = report::measure_accuracy(flight, flight.strips.begin()->second, reference);
  ASSERT_TRUE(accuracy);
  EXPECT_LT(accuracy->percent_of_length(accuracy->position.max), 0.5);
}

TEST_F(CalibrationFlightTest, APowerCutWhileItWaitsForTheCameraChangesNothing) {
  const fs::path camera = camera_off_by(rugged, -0.12, 2);
  fly(rugged, camera, unknown_camera);
  const auto uninterrupted = test::results_of(out);
  const auto frozen = test::records_of<CameraRecord>(out);
  ASSERT_EQ(frozen.size(), 3U);
  ASSERT_EQ(frozen[0].frozen, 1);
  // The flight takes an image every 4 s for 160 s; the calibration falls between.
  for (const char* frames : {"1", "402", "841", "1290"}) {
    out = folder / (std::string("cut-") + frames);
    ASSERT_EQ(test::run_program(command(rugged, camera, unknown_camera, {"--power-cut-after", frames})).exit_status, 9);
    test::run_well(command(rugged, camera, unknown_camera, {"--resume"}));
    test::expect_same_files(uninterrupted, test::results_of(out));
    EXPECT_DOUBLE_EQ(test::records_of<CameraRecord>(out)[0].fx, frozen[0].fx);
  }
}

TEST_F(CalibrationFlightTest, KilledAtAnyInstantAgainAndAgainItFindsTheSameCamera) {
  const fs::path camera = camera_off_by(rugged, -0.12, 2);
  fly(rugged, camera, unknown_camera);
  const auto uninterrupted = test::results_of(out);
  out = folder / "killed";
  ASSERT_EQ(test::run_program(command(rugged, camera, unknown_camera, {"--power-cut-after", "3"})).exit_status, 9);
  const auto resume = command(rugged, camera, unknown_camera, {"--resume"});
  bool ended = false;
  for (int boot = 0; boot < 10 && !ended; ++boot) ended = test::run_and_kill(resume, 80 + 61 * boot);
  if (!ended) {
    test::run_well(resume);
  }
  test::expect_same_files(uninterrupted, test::results_of(out));
}

TEST_F(CalibrationFlightTest, OverFlatGroundTheLensIsFoundAndTheFocalLengthHasAnHonestError) {
  fly(flat, camera_off_by(flat, 0.05, 3), unknown_camera);
  const auto cameras = test::records_of<CameraRecord>(out);
  ASSERT_EQ(cameras.size(), 3U);
  EXPECT_EQ(cameras[0].frozen, 1);
  const double truth = host::read_colmap_camera(flat / "cameras.txt").fx;
  EXPECT_NEAR(cameras[0].fx, truth, 3 * cameras[0].sigma_focal_px);
  const auto poses = test::records_of<PoseRecord>(out);
  EXPECT_EQ(poses.size(), test::records_of<KeyframeRecord>(out).size());
  for (const PoseRecord& pose : poses) EXPECT_EQ(pose.state, PoseState::final) << "keyframe " << pose.id;
  const auto depths = test::records_of<DepthRecord>(out);
  EXPECT_TRUE(std::any_of(depths.begin(), depths.end(),
                          [](const DepthRecord& depth) { return depth.verdict == DepthVerdict::ok; }));
}

TEST_F(CalibrationFlightTest, AShortPatienceFreezesTheCameraEarlyAndEveryKeyframeIsPosed) {
  fly(rugged, camera_off_by(rugged, 0.1, 3), std::string(unknown_camera) + "calibration_patience_keyframes = 6\n");
  const auto cameras = test::records_of<CameraRecord>(out);
  ASSERT_EQ(cameras.size(), 3U);
  EXPECT_EQ(cameras[0].frozen, 1);
  const auto said = test::records_of<CalibrationRecord>(out);
  ASSERT_FALSE(said.empty());
  EXPECT_EQ(said.back().id, 7);
  for (const PoseRecord& pose : test::records_of<PoseRecord>(out)) EXPECT_EQ(pose.state, PoseState::final) << pose.id;
}

/// Plains under a camera that swings, with a rolling shutter of 30 ms of which the flight is not told.
TEST_F(CalibrationFlightTest, TheReadoutTimeIsFoundWhereTheFlightSwings) {
  test::write_file(folder / "mission.ini", "[calibration]\nreadout_sigma_s = 0.05\n");
  test::run_well({ILP_SIL,
                  "--scenario",
                  "mars-plains",
                  "--seed",
                  "21",
                  "--frames",
                  "36",
                  "--set",
                  "flight.drift_m_s=10",
                  "--set",
                  "flight.interval_s=0.5",
                  "--set",
                  "flight.gravity_m_s2=9.81",
                  "--set",
                  "flight.swing_rad=0.08",
                  "--set",
                  "flight.suspension_m=4",
                  "--set",
                  "effects.readout_s=0.03",
                  "--mission",
                  folder / "mission.ini",
                  "--out",
                  out.string()});
  const auto cameras = test::records_of<CameraRecord>(out);
  ASSERT_EQ(cameras.size(), 3U);
  EXPECT_EQ(cameras[0].frozen, 1);
  EXPECT_NEAR(cameras[0].readout_s, 0.03, 0.0015);
  EXPECT_NEAR(cameras[0].readout_s, 0.03, 3 * cameras[0].sigma_readout_s);
  EXPECT_LT(cameras[0].sigma_readout_s, 0.0015);
  EXPECT_NEAR(cameras[0].fx, cameras[1].fx, 1e-3) << "the lens was given";
  EXPECT_EQ(cameras[0].source, CameraSource::given);
  EXPECT_EQ(test::events_of(out, StatusCode::camera_calibrated), 1U);
  const auto said = test::records_of<CalibrationRecord>(out);
  EXPECT_EQ(said.back().verdict, CalibrationVerdict::ok);
  EXPECT_DOUBLE_EQ(said.back().readout_s, cameras[0].readout_s);
  EXPECT_DOUBLE_EQ(said.back().prior_sigma_readout_s, 0.05);
}

TEST_F(CalibrationFlightTest, AGivenCameraThatIsWrongIsContradictedWhileTheStripFlies) {
  fly(rugged, camera_off_by(rugged, 0.08, 0), "");
  const auto checks = test::records_of<CalibrationCheckRecord>(out);
  ASSERT_EQ(checks.size(), 1U) << "one of the strip, with all its windows";
  const CalibrationCheckRecord& check = checks[0];
  EXPECT_EQ(check.verdict, CameraCheckVerdict::contradicts);
  EXPECT_EQ(check.worst, Intrinsic::focal_length);
  const double truth = host::read_colmap_camera(rugged / "cameras.txt").fx;
  EXPECT_NEAR(1.08 * truth + check.corrections[0], truth, 3 * check.correction_sigmas[0]);
  EXPECT_GE(check.windows, 2U);
  EXPECT_EQ(test::events_of(out, StatusCode::camera_contradicted), 1U);
  EXPECT_TRUE(test::records_of<CalibrationRecord>(out).empty()) << "a given camera is never changed";
  const auto cameras = test::records_of<CameraRecord>(out);
  ASSERT_EQ(cameras.size(), 2U) << "the camera and its copy";
  EXPECT_EQ(cameras[0].fx, cameras[1].fx);
  // It is said before anything else.
  const test::ProgramResult map = test::run_well({ILP_GROUND, (out / "outbox").string(), "--out", folder / "map"});
  const std::size_t said = map.output.find("contradict the camera: their statistic is");
  EXPECT_LT(said, map.output.find("posed,")) << map.output;
  ILP_NEED_TOOL("node");
  const std::string page = test::page_text(fs::path(folder / "map") / "report.html");
  EXPECT_LT(page.find("contradict the camera"), page.find("class=\"lede\""));
}

TEST_F(CalibrationFlightTest, AGivenCameraThatIsRightIsNotContradicted) {
  // Images of the plain flight have little noise: what is wrong with its matches leaves hardly a residual.
  for (const fs::path& flight : {rugged, flat, test::prepared_flights() / "plain"}) {
    out = folder / ("right-" + flight.filename().string());
    fly(flight, flight / "cameras.txt", "");
    const auto checks = test::records_of<CalibrationCheckRecord>(out);
    EXPECT_FALSE(checks.empty());
    for (const CalibrationCheckRecord& check : checks) EXPECT_EQ(check.verdict, CameraCheckVerdict::fits);
    EXPECT_EQ(test::events_of(out, StatusCode::camera_contradicted), 0U);
    EXPECT_EQ(test::events_of(out, StatusCode::camera_unexplained), 0U);
  }
}

TEST_F(CalibrationFlightTest, ImagesWithoutACameraFileAreFlownWithAGuess) {
  const test::ProgramResult result = test::run_well({ILP_SIL, "--images", rugged.string(), "--out", out.string()});
  EXPECT_NE(result.output.find("not known"), std::string::npos) << result.output;
  const auto cameras = test::records_of<CameraRecord>(out);
  ASSERT_EQ(cameras.size(), 3U);
  EXPECT_NEAR(cameras[1].fx, 160 * std::sqrt(3.0), 1e-9) << "60 degrees over 320 px";
  EXPECT_DOUBLE_EQ(cameras[1].cx, 159.5);
}

TEST_F(CalibrationFlightTest, ResumingAFlightOfAnUnknownCameraAsIfItWereKnownIsRefused) {
  const fs::path camera = camera_off_by(rugged, 0.1, 3);
  ASSERT_EQ(test::run_program(command(rugged, camera, unknown_camera, {"--power-cut-after", "50"})).exit_status, 9);
  const test::ProgramResult result = test::run_program(command(rugged, camera, "", {"--resume"}));
  EXPECT_EQ(result.exit_status, 1);
  EXPECT_NE(result.output.find("camera"), std::string::npos) << result.output;
}

}  // namespace
}  // namespace ilp
