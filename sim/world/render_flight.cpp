#include "sim/world/render_flight.hpp"

#include <mutex>
#include <vector>

#include "sim/host/parallel.hpp"
#include "sim/world/flight.hpp"
#include "sim/world/flight_check.hpp"
#include "sim/world/flight_files.hpp"
#include "sim/world/renderer.hpp"

namespace ilp::world {
namespace fs = std::filesystem;

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
  begin_flight_files(dir, scenario);

  int done = 0;
  std::mutex progress_mutex;
  host::for_each_parallel(
      states.size(),
      [&](std::size_t k) {
        RenderedFrame frame;
        renderer.render(trajectory.motion(states[k].time_ns), static_cast<std::int64_t>(k), frame);
        write_flight_frame(dir, k + 1, frame);
        const std::lock_guard lock(progress_mutex);
        ++done;
        if (progress) progress(done, static_cast<int>(states.size()));
      },
      threads);
  end_flight_files(dir, scenario, terrain, states, threads);
}

}  // namespace ilp::world
