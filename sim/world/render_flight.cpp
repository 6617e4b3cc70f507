#include "sim/world/render_flight.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/io/colmap_camera.hpp"
#include "sim/io/image_io.hpp"
#include "sim/io/reference_cameras.hpp"
#include "sim/world/flight.hpp"
#include "sim/world/flight_check.hpp"
#include "sim/world/parallel.hpp"
#include "sim/world/renderer.hpp"
#include "sim/world/truth.hpp"

namespace ilp::sim {
namespace fs = std::filesystem;
namespace {

std::vector<std::string> stems(std::size_t count) {
  std::vector<std::string> names;
  for (std::size_t k = 1; k <= count; ++k) {
    char text[24];
    std::snprintf(text, sizeof(text), "%04zu", k);
    names.emplace_back(text);
  }
  return names;
}

void write_text(const fs::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  if (!out.flush()) throw std::runtime_error(path.string() + ": cannot be written");
}

std::string index_text(const Scenario& scenario, const Terrain& terrain, const std::vector<CameraState>& states,
                       const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t k = 0; k < states.size(); ++k) {
    const Vec3& c = states[k].centre;
    char altitude[40] = "";
    if (scenario.flight.altimeter)
      std::snprintf(altitude, sizeof(altitude), " %.3f", c.z() - terrain.height(c.x(), c.y()));
    text += std::to_string(states[k].time_ns) + " images/" + names[k] + ".pgm" + altitude + "\n";
  }
  return text;
}

std::vector<ReferenceCamera> true_cameras(const std::vector<CameraState>& states, const std::vector<std::string>& names,
                                          const CameraModel& camera) {
  CameraModel ideal = camera;  // the format has no distortion; cameras.txt has it
  ideal.k1 = ideal.k2 = ideal.p1 = ideal.p2 = 0;
  std::vector<ReferenceCamera> cameras;
  for (std::size_t k = 0; k < states.size(); ++k) {
    cameras.push_back({names[k] + ".pgm", ideal, states[k].rotation, states[k].centre});
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

void derive_truth(const fs::path& dir, const Scenario& scenario, const Terrain& terrain,
                  const std::vector<CameraState>& states, const std::vector<std::string>& names, std::size_t threads) {
  TruthSource truth;
  truth.camera = scenario.flight.camera;
  truth.states = states;
  for (const std::string& name : names) truth.names.push_back(name + ".pgm");
  truth.heights = [&](double x0, double y, double spacing, std::span<double> height) {
    read_row(terrain, x0, y, spacing, height);
  };
  write_truth(dir / "truth", truth, threads);
}

}  // namespace

void check_scenario(const Scenario& scenario) {
  check_flight(Terrain(scenario.world), scenario.flight.camera, fly(scenario.flight));
}

void render_flight(const fs::path& dir, const Scenario& scenario, const RenderProgress& progress, std::size_t threads) {
  const CameraModel& camera = scenario.flight.camera;
  const Terrain terrain(scenario.world);
  const Trajectory trajectory(scenario.flight);
  const std::vector<CameraState> states = fly(scenario.flight);
  check_flight(terrain, camera, states);
  const Renderer renderer(terrain, camera, scenario.effects, scenario.flight.seed);
  const std::vector<std::string> names = stems(states.size());
  fs::create_directories(dir / "images");
  fs::create_directories(dir / "truth" / "depth");
  write_scenario(dir / "scenario.ini", scenario);
  write_colmap_camera(dir / "cameras.txt", camera);
  write_reference_cameras(dir / "truth" / "poses.txt", "true cameras of a simulated flight; world in metres, z up",
                          true_cameras(states, names, camera));

  int done = 0;
  std::mutex progress_mutex;
  for_each_parallel(
      states.size(),
      [&](std::size_t k) {
        RenderedFrame frame;
        renderer.render(trajectory.motion(states[k].time_ns), static_cast<std::int64_t>(k), frame);
        write_pgm(dir / "images" / (names[k] + ".pgm"), frame.grey.view());
        write_pfm(dir / "truth" / "depth" / (names[k] + ".pfm"), frame.depth_m.view());
        const std::lock_guard lock(progress_mutex);
        ++done;
        if (progress) progress(done, static_cast<int>(states.size()));
      },
      threads);
  derive_truth(dir, scenario, terrain, states, names, threads);
  // Last, so that an index stands for a complete flight.
  write_text(dir / "index.txt", index_text(scenario, terrain, states, names));
}

}  // namespace ilp::sim
