// Renders the flights that the integration tests share, and flies the first of them once without interruption.
//   prepare_flights FOLDER ILP_SIL

#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iostream>

#include "sim/world/render_flight.hpp"
#include "tests/support/calm_scenario.hpp"

namespace {

/// Half the default camera's resolution, every second of its frames: the same overlap costs an eighth.
ilp::world::Scenario small_flight(int frames) {
  return ilp::test::calm_scenario(frames, 320, 240, 275);
}

/// A gondola that goes on swinging over steep or flat ground: it shows the camera, or would if the ground had relief.
ilp::world::Scenario swinging_flight(const char* world, int frames) {
  ilp::world::Scenario scenario = ilp::world::load_scenario(
      world, {{"world", "seed", "2", "prepare_flights"}, {"flight", "seed", "2", "prepare_flights"}});
  const ilp::world::Scenario small = small_flight(frames);
  scenario.flight.camera = small.flight.camera;
  scenario.flight.frames = frames;
  scenario.flight.interval_s = 4;
  scenario.flight.swing_rad = 0.1;
  scenario.flight.swing_damping = 0.005;
  return scenario;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  namespace fs = std::filesystem;
  const fs::path folder = argv[1];
  try {
    fs::remove_all(folder);
    fs::create_directories(folder);
    ilp::world::render_flight(folder / "plain", small_flight(20));
    ilp::world::Scenario curved = small_flight(10);
    curved.flight.camera.k1 = -0.1;
    ilp::world::render_flight(folder / "distorted", curved);
    ilp::world::render_flight(folder / "rugged", swinging_flight("mars-canyon", 40));
    ilp::world::render_flight(folder / "flat", swinging_flight("flat", 40));
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
  const std::string command = std::string(argv[2]) + " --images " + (folder / "plain").string() + " --camera " +
                              (folder / "plain" / "cameras.txt").string() + " --out " +
                              (folder / "uninterrupted").string();
  return std::system(command.c_str()) == 0 ? 0 : 1;
}
