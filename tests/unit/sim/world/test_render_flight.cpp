// The files of a simulated flight, read back the way others read them.

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "hal/camera/directory/directory_camera.hpp"
#include "sim/io/colmap_camera.hpp"
#include "sim/io/image_io.hpp"
#include "sim/io/reference_cameras.hpp"
#include "sim/world/render_flight.hpp"
#include "tests/unit/sim/io/scratch_folder.hpp"

namespace ilp::sim {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::ScratchFolder;

FlightParams small_flight() {
  FlightParams flight;
  flight.camera = {96, 72, 82, 83, 47, 36, -0.05, 0, 0, 0};
  flight.frames = 5;
  return flight;
}

std::vector<std::pair<std::string, std::string>> all_files(const fs::path& folder) {
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.emplace_back(fs::relative(entry.path(), folder), bytes_of(entry.path()));
  }
  std::sort(files.begin(), files.end());
  return files;
}

TEST(RenderFlight, SameSeedGivesTheSameBytesAndAnotherSeedDoesNot) {
  const ScratchFolder folder;
  WorldParams world;
  FlightParams flight = small_flight();
  render_flight(folder / "one", world, flight, {});
  render_flight(folder / "two", world, flight, {});
  const auto one = all_files(folder / "one");
  EXPECT_EQ(one.size(), 13U);
  EXPECT_TRUE(one == all_files(folder / "two"));
  world.seed = 2;
  render_flight(folder / "three", world, flight, {});
  EXPECT_NE(bytes_of(folder / "one/images/0003.pgm"), bytes_of(folder / "three/images/0003.pgm"));
}

TEST(RenderFlight, CameraPosesImagesAndDepthsReadBack) {
  const ScratchFolder folder;
  const FlightParams flight = small_flight();
  std::vector<int> progress;
  render_flight(folder.path(), {}, flight, [&](int done, int total) {
    EXPECT_EQ(total, 5);
    progress.push_back(done);
  });
  EXPECT_EQ(progress, (std::vector<int>{1, 2, 3, 4, 5}));

  const CameraModel camera = read_colmap_camera(folder / "cameras.txt");
  EXPECT_EQ(camera.k1, flight.camera.k1);
  EXPECT_NEAR(camera.cx, flight.camera.cx, 1e-12);

  const std::vector<CameraState> states = fly(flight);
  const std::vector<ReferenceCamera> truth = read_reference_cameras(folder / "truth/poses.txt");
  ASSERT_EQ(truth.size(), states.size());
  DirectoryCamera source;
  ASSERT_TRUE(source.open((folder / "index.txt").c_str(), camera.width, camera.height, decode_image).ok());
  const auto image = std::make_unique<FrameImage>();
  CameraFrame frame;
  for (std::size_t k = 0; k < states.size(); ++k) {
    ASSERT_TRUE(source.capture(states[k].time_ns, *image, frame).ok());
    EXPECT_EQ(frame.time_ns, states[k].time_ns);
    EXPECT_EQ(frame.name, truth[k].name);
    EXPECT_EQ(truth[k].cam_from_world, states[k].rotation);
    EXPECT_EQ(truth[k].centre, states[k].centre);
    EXPECT_EQ(truth[k].camera.fy, flight.camera.fy);
    const Image<float> depth = read_pfm(folder / ("truth/depth/" + fs::path(frame.name).stem().string() + ".pfm"));
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
  EXPECT_THROW(render_flight(folder / "file", {}, small_flight(), {}), std::runtime_error);
}

TEST(RenderFlight, WhatProgressThrowsStopsTheRendering) {
  const ScratchFolder folder;
  EXPECT_THROW(render_flight(folder.path(), {}, small_flight(), [](int, int) { throw std::logic_error("enough"); }),
               std::logic_error);
  EXPECT_FALSE(fs::exists(folder / "index.txt"));
}

}  // namespace
}  // namespace ilp::sim
