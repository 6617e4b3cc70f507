// The files of a simulated flight, read back the way others read them.

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "hal/camera/directory/directory_camera.hpp"
#include "sim/host/colmap.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/reference_cameras.hpp"
#include "sim/world/flight.hpp"
#include "sim/world/render_flight.hpp"
#include "sim/world/terrain.hpp"
#include "tests/unit/host/scratch_folder.hpp"

namespace ilp::world {
namespace {

namespace fs = std::filesystem;
using test::says;
using test::ScratchFolder;
using test::text_of;

Scenario small_scenario() {
  Scenario scenario{.name = "small"};
  scenario.flight.camera = {96, 72, 82, 83, 47, 36, -0.05, 0, 0, 0};
  scenario.flight.frames = 5;
  scenario.effects.read_noise_grey = 1;
  return scenario;
}

std::vector<std::pair<std::string, std::string>> all_files(const fs::path& folder) {
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.emplace_back(fs::relative(entry.path(), folder), text_of(entry.path()));
  }
  std::sort(files.begin(), files.end());
  return files;
}

TEST(RenderFlight, SameScenarioGivesTheSameBytesForAnyNumberOfThreadsAndAnotherSeedDoesNot) {
  const ScratchFolder folder;
  Scenario scenario = small_scenario();
  scenario.effects = realistic_effects();
  render_flight(folder / "one", scenario, {}, 1);
  render_flight(folder / "two", scenario, {}, 3);
  render_flight(folder / "three", scenario);
  const auto one = all_files(folder / "one");
  EXPECT_GE(one.size(), 14U);
  EXPECT_TRUE(one == all_files(folder / "two"));
  EXPECT_TRUE(one == all_files(folder / "three"));
  scenario.world.seed = 2;
  render_flight(folder / "four", scenario);
  EXPECT_NE(text_of(folder / "one/images/0003.pgm"), text_of(folder / "four/images/0003.pgm"));
  EXPECT_EQ(text_of(folder / "one/truth/poses.txt"), text_of(folder / "four/truth/poses.txt"));
}

TEST(RenderFlight, EachPassHasTheLightOfItsSun) {
  const ScratchFolder folder;
  Scenario scenario = small_scenario();
  scenario.flight.kind = "line";
  scenario.flight.frames = 4;
  scenario.flight.passes = 2;
  scenario.effects = {};
  render_flight(folder / "same", scenario);
  scenario.flight.pass_sun_azimuth_rad = 0.6;
  render_flight(folder / "moved", scenario);
  scenario.flight.pass_sun_azimuth_rad = 0;
  scenario.world.sun_azimuth_rad += 0.6;
  render_flight(folder / "later", scenario);
  const auto image = [&](const char* flight, const char* name) { return text_of(folder / flight / "images" / name); };
  EXPECT_EQ(image("same", "0001.pgm"), image("same", "0003.pgm")) << "the second pass begins where the first began";
  EXPECT_EQ(image("moved", "0002.pgm"), image("same", "0002.pgm"));
  EXPECT_EQ(image("moved", "0003.pgm"), image("later", "0003.pgm"));
  EXPECT_EQ(image("moved", "0004.pgm"), image("later", "0004.pgm"));
  EXPECT_NE(image("moved", "0003.pgm"), image("same", "0003.pgm"));
  EXPECT_EQ(text_of(folder / "moved/truth/depth/0004.pfm"), text_of(folder / "same/truth/depth/0004.pfm"));
}

TEST(RenderFlight, FrameThatACloudHidesHasNoDepthAndSeesNoGround) {
  const ScratchFolder folder;
  Scenario scenario = small_scenario();
  scenario.flight.kind = "line";
  scenario.flight.drift_m_s = 0;
  scenario.effects.cloud_from_s = 0;
  scenario.effects.cloud_for_s = 3;  // frames at 0 and 2 s, and not those from 4 s on
  render_flight(folder.path(), scenario);
  const auto none = [](const auto& samples) {
    return std::all_of(samples.begin(), samples.end(), [](auto value) { return !(value > 0); });
  };
  EXPECT_TRUE(none(host::read_pfm(folder / "truth/depth/0002.pfm").samples));
  EXPECT_FALSE(none(host::read_pfm(folder / "truth/depth/0003.pfm").samples));
  // What nobody saw for clouds is new to the first frame without them.
  EXPECT_TRUE(none(host::read_gray(folder / "truth/visible-before/0003.png").samples));
  EXPECT_FALSE(none(host::read_gray(folder / "truth/visible-before/0004.png").samples));
}

TEST(RenderFlight, ScenarioAsFlownFliesAgain) {
  const ScratchFolder folder;
  Scenario scenario = small_scenario();
  scenario.flight.gust_m_s = 0.1;
  scenario.flight.off_nadir_rad = 0.1 / 3;
  scenario.world.sun_elevation_rad = 0.7;
  render_flight(folder / "one", scenario);
  render_flight(folder / "again", load_scenario(folder / "one/scenario.ini", {}));
  EXPECT_TRUE(all_files(folder / "one") == all_files(folder / "again"));
}

TEST(RenderFlight, CameraPosesImagesAndDepthsReadBack) {
  const ScratchFolder folder;
  const Scenario scenario = small_scenario();
  const FlightParams& flight = scenario.flight;
  std::vector<int> progress;
  render_flight(folder.path(), scenario, [&](int done, int total) {
    EXPECT_EQ(total, 5);
    progress.push_back(done);
  });
  EXPECT_EQ(progress, (std::vector<int>{1, 2, 3, 4, 5}));

  const CameraModel camera = host::read_colmap_camera(folder / "cameras.txt");
  EXPECT_EQ(camera.k1, flight.camera.k1);
  EXPECT_NEAR(camera.cx, flight.camera.cx, 1e-12);

  const std::vector<CameraState> states = fly(flight);
  const std::vector<host::ReferenceCamera> truth = host::read_reference_cameras(folder / "truth/poses.txt");
  ASSERT_EQ(truth.size(), states.size());
  DirectoryCamera source;
  ASSERT_TRUE(source.open((folder / "index.txt").c_str(), camera.width, camera.height, host::decode_image).ok());
  const auto image = std::make_unique<FrameImage>();
  CameraFrame frame;
  for (std::size_t k = 0; k < states.size(); ++k) {
    ASSERT_TRUE(source.capture(states[k].time_ns, *image, frame).ok());
    EXPECT_EQ(frame.time_ns, states[k].time_ns);
    EXPECT_EQ(frame.name, truth[k].name);
    EXPECT_EQ(truth[k].cam_from_world, states[k].rotation);
    EXPECT_EQ(truth[k].centre, states[k].centre);
    EXPECT_EQ(truth[k].camera.fy, flight.camera.fy);
    const host::Raster<float> depth =
        host::read_pfm(folder / ("truth/depth/" + fs::path(frame.name).stem().string() + ".pfm"));
    ASSERT_EQ(depth.width, camera.width);
    ASSERT_EQ(depth.height, camera.height);
    // The optical axis meets the ground somewhere within the relief.
    EXPECT_NEAR(depth.at(47, 36), states[k].centre.z(), 15);
  }
  EXPECT_EQ(source.capture(1'000'000'000'000, *image, frame).code, StatusCode::end_of_stream);
}

TEST(RenderFlight, FolderThatCannotBeWrittenIsAnError) {
  const ScratchFolder folder;
  folder.write("file", "");
  EXPECT_THROW(render_flight(folder / "file", small_scenario()), std::runtime_error);
}

TEST(RenderFlight, WhatProgressThrowsStopsTheRendering) {
  const ScratchFolder folder;
  EXPECT_THROW(render_flight(folder.path(), small_scenario(), [](int, int) { throw std::logic_error("enough"); }),
               std::logic_error);
  EXPECT_FALSE(fs::exists(folder / "index.txt"));
}

TEST(RenderFlight, AltimeterGivesTheHeightAboveTheGroundBelow) {
  const ScratchFolder folder;
  Scenario scenario = small_scenario();
  scenario.flight.altimeter = true;
  render_flight(folder.path(), scenario);
  DirectoryCamera source;
  ASSERT_TRUE(source.open((folder / "index.txt").c_str(), 96, 72, host::decode_image).ok());
  const auto image = std::make_unique<FrameImage>();
  CameraFrame frame;
  const Terrain terrain(scenario.world);
  for (const CameraState& state : fly(scenario.flight)) {
    ASSERT_TRUE(source.capture(state.time_ns, *image, frame).ok());
    EXPECT_NEAR(frame.altitude, state.centre.z() - terrain.height(state.centre.x(), state.centre.y()), 6e-4);
    EXPECT_NE(frame.altitude, 0);
  }
}

TEST(RenderFlight, GapLeavesFramesOutOfTheIndex) {
  const ScratchFolder folder;
  Scenario scenario = small_scenario();
  scenario.flight.gap_start_s = 3;
  scenario.flight.gap_length_s = 4;
  render_flight(folder.path(), scenario);
  EXPECT_EQ(text_of(folder / "index.txt"),
            "0 images/0001.pgm\n2000000000 images/0002.pgm\n8000000000 images/0003.pgm\n");
  EXPECT_EQ(host::read_reference_cameras(folder / "truth/poses.txt").size(), 3U);
}

TEST(RenderFlight, FlightThatCannotBeSeenIsRefusedBeforeAnythingIsWritten) {
  const ScratchFolder folder;
  const auto complaint = [&](auto change) -> std::string {
    Scenario scenario = small_scenario();
    change(scenario);
    EXPECT_THROW(check_scenario(scenario), std::invalid_argument);
    const auto said = test::error_of<std::invalid_argument>([&] { render_flight(folder / "flight", scenario); });
    EXPECT_FALSE(fs::exists(folder / "flight"));
    return said;
  };
  EXPECT_TRUE(says(complaint([](Scenario& s) {
                     s.flight.kind = "line";
                     s.flight.altitude_m = 11;
                   }),
                   "frame 1, at 0 s: the camera is at 11 m and the ground reaches up to "));
  EXPECT_TRUE(says(complaint([](Scenario& s) {
                     s.flight.kind = "descent";
                     s.flight.descent_m_s = 12;
                   }),
                   "frame 5, at 8 s: the camera is at 4 m and the ground reaches up to"));
  EXPECT_TRUE(says(complaint([](Scenario& s) { s.flight.off_nadir_rad = 1.2; }), "off_nadir_rad"));
  EXPECT_TRUE(says(complaint([](Scenario& s) { s.flight.altitude_m = 9000; }), "post_spacing_m"));
  EXPECT_TRUE(says(complaint([](Scenario& s) { s.flight.frames = 0; }), "[flight] frames = 0"));
}

}  // namespace
}  // namespace ilp::world
