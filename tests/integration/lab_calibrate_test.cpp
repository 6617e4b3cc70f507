// ilp-lab calibrate on the matches of simulated flights, whose camera is known.

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "cfg/limits.hpp"
#include "sim/host/colmap.hpp"
#include "sim/host/image_io.hpp"
#include "tests/integration/lab_program.hpp"
#include "tests/support/strip.hpp"
#include "tests/unit/vision/calibration/synthetic_flight.hpp"

namespace ilp::test {
namespace {

class LabCalibrate : public LabTest {
 protected:
  /// One file per pair of keyframes, the way another program would write it; returns the arguments that read them.
  std::string write_matches(const SyntheticFlight& flight) const {
    std::filesystem::create_directory(path("matches"));
    for (std::size_t k = 1; k < flight.keyframes.size(); ++k) {
      const Corners& before = flight.keyframes[k - 1].corners;
      const FlightKeyframe& frame = flight.keyframes[k];
      std::ostringstream text;
      text.precision(9);
      text << "# x_a y_a x_b y_b score\n";
      for (const Match& m : frame.matches) {
        const Corner &a = before[m.a], &b = frame.corners[m.b];
        text << a.x << " " << a.y << " " << b.x << " " << b.y << " " << m.score << "\n";
      }
      write("matches/" + std::to_string(100 + k) + ".txt", text.str());
    }
    return "calibrate --matches " + path("matches");
  }
  void refused(const std::string& arguments, int status, const std::string& part) const {
    const LabRun run = lab(arguments);
    EXPECT_EQ(run.status, status) << arguments << "\n" << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << arguments << "\n" << run.err;
    EXPECT_EQ(run.out, "") << arguments;
  }
  /// Without a focal length, and with the reason in words.
  void refused_with_a_reason(const LabRun& run, const std::vector<std::string>& verdicts) const {
    ASSERT_EQ(run.status, 0) << run.err;
    EXPECT_NE(std::find(verdicts.begin(), verdicts.end(), run.verdict()), verdicts.end()) << run.verdict();
    EXPECT_GT(run.json.at("reason").get<std::string>().size(), 20U);
    for (const char* name : {"fx", "fy", "cx", "cy", "sigma_fx", "sigma_cx"}) EXPECT_TRUE(run.json.at(name).is_null());
    EXPECT_FALSE(std::filesystem::exists(path("camera.txt")));
  }
};

FlightScene rugged_flight(unsigned seed) {
  FlightScene scene;
  scene.seed = seed;
  scene.ruggedness = 2;
  return scene;
}

TEST_F(LabCalibrate, FindsTheCameraFromMatchesAndWritesIt) {
  for (const unsigned seed : {11U, 12U, 13U}) {
    FlightScene scene = rugged_flight(seed);
    scene.field_of_view_rad = 0.6 + 0.05 * seed;
    const SyntheticFlight flight(scene);
    const LabRun run = lab(write_matches(flight) + " --size 640 480 --out " + path("camera.txt"));
    ASSERT_EQ(run.status, 0) << run.err;
    ASSERT_EQ(run.verdict(), "ok") << seed << run.out;
    const double error_px = std::abs(run.number("fx") - flight.camera.fx);
    EXPECT_LT(error_px, 0.01 * flight.camera.fx) << seed;
    EXPECT_LT(error_px, 3 * run.number("sigma_fx")) << seed;
    EXPECT_LT(std::abs(run.number("cx") - flight.camera.cx), 3 * run.number("sigma_cx")) << seed;
    EXPECT_LT(std::abs(run.number("cy") - flight.camera.cy), 3 * run.number("sigma_cy")) << seed;
    EXPECT_NEAR(run.number("noise_px"), scene.noise_px, 0.1);
    const CameraModel written = host::read_colmap_camera(path("camera.txt"));
    EXPECT_EQ(written.width, 640);
    EXPECT_EQ(written.height, 480);
    EXPECT_NEAR(written.fx, run.number("fx"), 1e-6);
    EXPECT_NEAR(written.fy, run.number("fy"), 1e-6);
    EXPECT_NEAR(written.cx, run.number("cx"), 1e-6);
    EXPECT_NEAR(written.cy, run.number("cy"), 1e-6);
  }
}

TEST_F(LabCalibrate, TheFocalLengthOfTheGivenCameraIsNotBelieved) {
  const SyntheticFlight flight(rugged_flight(11));
  const std::string command = write_matches(flight);
  const LabRun by_size = lab(command + " --size 640 480");
  ASSERT_EQ(by_size.verdict(), "ok");
  for (const double focal : {200.0, 2000.0}) {
    const LabRun run = lab(command + " --camera " + write("c.txt", pinhole_text(640, 480, focal, 319.5, 239.5)));
    ASSERT_EQ(run.status, 0) << run.err;
    EXPECT_NEAR(run.number("fx"), by_size.number("fx"), 1e-6 * by_size.number("fx"));
  }
}

TEST_F(LabCalibrate, FlatGroundIsRefusedWithAReason) {
  FlightScene scene;
  scene.world = "flat";
  const LabRun run = lab(write_matches(SyntheticFlight(scene)) + " --size 640 480 --out " + path("camera.txt"));
  refused_with_a_reason(run, {"planar", "too_little_parallax"});
  ASSERT_FALSE(run.json.at("pairs").empty());
  EXPECT_LT(run.json["pairs"].back()["gric_h"], run.json["pairs"].back()["gric_f"]);
}

TEST_F(LabCalibrate, AStraightLevelFlightOverRuggedGroundIsRefusedWithAReason) {
  FlightScene scene = rugged_flight(3);
  scene.line = true;
  const LabRun run = lab(write_matches(SyntheticFlight(scene)) + " --size 640 480 --out " + path("camera.txt"));
  refused_with_a_reason(run, {"critical_motion"});
  EXPECT_NE(run.json.at("reason").get<std::string>().find("translation"), std::string::npos);
}

TEST_F(LabCalibrate, ImagesOfAPlaneAreRefusedWithAReason) {
  std::string command = "calibrate --out " + path("camera.txt");
  for (int k = 0; k < 5; ++k) {
    host::Raster<std::uint8_t> image(320, 240);
    for (int y = 0; y < 240; ++y) {
      for (int x = 0; x < 320; ++x) {
        image.at(x, y) = static_cast<std::uint8_t>(std::clamp(fractal_texture(x + 40 * k, y + 9 * k, 2, 5), 0., 255.));
      }
    }
    const std::string name = path(std::to_string(k) + ".pgm");
    host::write_pgm(name, image.view());
    command += " " + name;
  }
  const LabRun run = lab(command);
  refused_with_a_reason(run, {"planar", "too_little_parallax"});
  EXPECT_EQ(run.number("images"), 5);
  ASSERT_FALSE(run.json.at("pairs").empty());
  EXPECT_GT(run.json["pairs"].back()["inliers"], 100);
  EXPECT_NEAR(run.json["pairs"].back()["motion_px"].get<double>(), std::hypot(40, 9), 1);
}

TEST_F(LabCalibrate, BadMatchesAndSizesAreRefused) {
  const std::string size = " --size 640 480";
  const std::string folder = path("bad");
  refused("calibrate --matches " + folder + size, 1, "no such folder");
  std::filesystem::create_directory(folder);
  refused("calibrate --matches " + folder + size, 1, "no matches");
  write("bad/1.txt", "1 2 3 4\n1 2 3\n");
  refused("calibrate --matches " + folder + size, 1, "line 2");
  write("bad/1.txt", "10 20 30 40\n600 470 630 500\n");
  refused("calibrate --matches " + folder + size, 1, "480");
  refused("calibrate --matches " + folder + " --size 640 1", 2, "--size");
  refused("calibrate --matches " + folder + size + " --views 9", 2, "--views");
  refused("calibrate --matches " + folder + size + " --min-field 2 --max-field 1", 2, "--min-field");
  const std::string camera = write("c.txt", pinhole_text(96, 80, 100, 47.5, 39.5));
  refused("calibrate --matches " + folder + size + " --camera " + camera, 2, "--size");
  host::write_pgm(path("small.pgm"), host::Raster<std::uint8_t>(64, 80).view());
  refused("calibrate " + path("small.pgm") + size, 2, "--size");
  refused("calibrate " + path("small.pgm") + " --camera " + camera, 1, "c.txt");
  refused("calibrate " + path("missing.pgm"), 1, "missing.pgm");
}

}  // namespace
}  // namespace ilp::test
