#include "sim/world/render_flight.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <mutex>
#include <span>
#include <stdexcept>
#include <vector>

#include "sim/host/colmap.hpp"
#include "sim/host/files.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/parallel.hpp"
#include "sim/host/reference_cameras.hpp"
#include "sim/world/flight.hpp"
#include "sim/world/flight_renderer.hpp"
#include "sim/world/truth.hpp"

namespace ilp::world {
namespace fs = std::filesystem;
namespace {

void write_text(const fs::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  if (!out.flush()) throw std::runtime_error(path.string() + ": cannot be written: " + host::write_failure(errno));
}

std::string image_name(std::size_t number) {
  return frame_stem(number) + ".pgm";
}

std::string index_text(const Scenario& scenario, const Terrain& terrain, const std::vector<CameraState>& states) {
  std::string text;
  for (std::size_t k = 0; k < states.size(); ++k) {
    char altitude[40] = "";
    if (scenario.flight.altimeter) {
      std::snprintf(altitude, sizeof(altitude), " %.3f", height_above_ground(terrain, states[k]));
    }
    text += std::to_string(states[k].time_ns) + " images/" + image_name(k + 1) + altitude + "\n";
  }
  return text;
}

std::vector<host::ReferenceCamera> true_cameras(const std::vector<CameraState>& states, const CameraModel& camera) {
  CameraModel ideal = camera;  // the format has no distortion; cameras.txt has it
  ideal.k1 = ideal.k2 = ideal.p1 = ideal.p2 = ideal.k3 = ideal.k4 = ideal.k5 = ideal.k6 = 0;
  ideal.lens = Lens::brown;
  std::vector<host::ReferenceCamera> cameras;
  for (std::size_t k = 0; k < states.size(); ++k) {
    cameras.push_back({image_name(k + 1), ideal, states[k].rotation, states[k].centre});
  }
  return cameras;
}

/// Bilinear between the posts, as the renderer sees the ground.
void read_row(const Terrain& terrain, double x0, double y, double spacing, std::span<double> height) {
  const SurfacePatch patch = terrain.patch({x0, y, x0 + spacing * static_cast<double>(height.size() - 1), y});
  const double v = y / patch.spacing_m - patch.first_j;
  for (std::size_t k = 0; k < height.size(); ++k) {
    const double column = (x0 + spacing * static_cast<double>(k)) / patch.spacing_m - patch.first_i;
    const std::int32_t i = std::clamp(static_cast<std::int32_t>(column), 0, patch.columns - 2);
    const auto post = [&](std::int32_t di, std::int32_t dj) -> double {
      return patch.height_m[patch.index(i + di, dj)];
    };
    const double u = column - i;
    height[k] = (1 - v) * ((1 - u) * post(0, 0) + u * post(1, 0)) + v * ((1 - u) * post(0, 1) + u * post(1, 1));
  }
}

}  // namespace

std::string frame_stem(std::size_t number) {
  char text[24];
  std::snprintf(text, sizeof(text), "%04zu", number);
  return text;
}

double height_above_ground(const Terrain& terrain, const CameraState& state) {
  return state.centre.z() - terrain.height(state.centre.x(), state.centre.y());
}

void begin_flight_files(const fs::path& dir, const Scenario& scenario, const Terrain& terrain) {
  fs::create_directories(dir / "images");
  fs::create_directories(dir / "truth" / "depth");
  write_scenario(dir / "scenario.ini", scenario);
  host::write_colmap_camera(dir / "cameras.txt", scenario.flight.camera);
  if (!scenario.navigation.any()) return;
  const Trajectory trajectory(scenario.flight);
  write_text(dir / "navigation.csv", navigation_text(scenario.navigation, terrain, trajectory, scenario.flight.seed));
}

void write_flight_frame(const fs::path& dir, std::size_t number, const RenderedFrame& frame) {
  host::write_pgm(dir / "images" / image_name(number), frame.grey.view());
  host::write_pfm(dir / "truth" / "depth" / (frame_stem(number) + ".pfm"), frame.depth_m.view());
}

void end_flight_files(const fs::path& dir, const Scenario& scenario, const Terrain& terrain,
                      const std::vector<CameraState>& states, std::size_t threads) {
  host::write_reference_cameras(dir / "truth" / "poses.txt",
                                "true cameras of a simulated flight; world in metres, z up",
                                true_cameras(states, scenario.flight.camera));
  TruthSource truth;
  truth.camera = scenario.flight.camera;
  truth.states = states;
  for (std::size_t k = 1; k <= states.size(); ++k) truth.names.push_back(image_name(k));
  truth.heights = [&](double x0, double y, double spacing, std::span<double> height) {
    read_row(terrain, x0, y, spacing, height);
  };
  write_truth(dir / "truth", truth, threads);
  write_text(dir / "index.txt", index_text(scenario, terrain, states));
}

void check_scenario(const Scenario& scenario) {
  check_flight(Terrain(scenario.world), scenario.flight.camera, fly(scenario.flight));
}

void render_flight(const fs::path& dir, const Scenario& scenario, const RenderProgress& progress, std::size_t threads) {
  const CameraModel& camera = scenario.flight.camera;
  const FlightRenderer renderer(scenario);
  const std::vector<CameraState> states = fly(scenario.flight);
  check_flight(renderer.terrain(), camera, states);
  begin_flight_files(dir, scenario, renderer.terrain());

  int done = 0;
  std::mutex progress_mutex;
  host::for_each_parallel(
      states.size(),
      [&](std::size_t k) {
        RenderedFrame frame;
        renderer.render(states[k].time_ns, static_cast<std::int64_t>(k), frame);
        write_flight_frame(dir, k + 1, frame);
        const std::lock_guard lock(progress_mutex);
        ++done;
        if (progress) progress(done, static_cast<int>(states.size()));
      },
      threads);
  end_flight_files(dir, scenario, renderer.terrain(), states, threads);
}

}  // namespace ilp::world
