// Renders the flights that the integration tests share, and flies the first of them once without interruption.
//   prepare_flights FOLDER ILP_SIL

#include <cmath>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iostream>
#include <numbers>

#include "sim/world/render_flight.hpp"

namespace {

/// Half the default camera's resolution, every second of its frames: the same overlap costs an eighth. Calm air and a
/// slow swing of 70 s: what these tests look at does not hang on how a gust moves the keyframes.
ilp::world::Scenario small_flight(int frames) {
  ilp::world::Scenario scenario;
  scenario.effects.read_noise_grey = 1;
  ilp::world::FlightParams& flight = scenario.flight;
  flight.frames = frames;
  flight.interval_s = 4;
  flight.gust_m_s = 0;
  flight.swing_damping = 0;
  flight.swing_rad = 0.044;
  flight.gravity_m_s2 = flight.suspension_m * std::pow(2 * std::numbers::pi / 70, 2);
  flight.camera.width /= 2;
  flight.camera.height /= 2;
  flight.camera.fx /= 2;
  flight.camera.fy /= 2;
  flight.camera.cx = (flight.camera.width - 1) / 2.0;
  flight.camera.cy = (flight.camera.height - 1) / 2.0;
  return scenario;
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
