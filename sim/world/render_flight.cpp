#include "sim/world/render_flight.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <fstream>
#include <iomanip>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "sim/io/colmap_camera.hpp"
#include "sim/io/image_io.hpp"
#include "sim/io/reference_cameras.hpp"
#include "sim/world/renderer.hpp"

namespace ilp::sim {
namespace fs = std::filesystem;
namespace {

std::string frame_name(std::size_t k) {
  std::ostringstream name;
  name << std::setw(4) << std::setfill('0') << k + 1;
  return name.str();
}

void write_text(const fs::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  if (!out.flush()) throw std::runtime_error(path.string() + ": cannot be written");
}

std::string index_text(const std::vector<CameraState>& states) {
  std::ostringstream out;
  for (std::size_t k = 0; k < states.size(); ++k) {
    out << states[k].time_ns << " images/" << frame_name(k) << ".pgm\n";
  }
  return out.str();
}

std::vector<ReferenceCamera> true_cameras(const std::vector<CameraState>& states, const CameraModel& camera) {
  CameraModel ideal = camera;  // the format has no distortion; cameras.txt has it
  ideal.k1 = ideal.k2 = ideal.p1 = ideal.p2 = 0;
  std::vector<ReferenceCamera> cameras;
  for (std::size_t k = 0; k < states.size(); ++k) {
    cameras.push_back({frame_name(k) + ".pgm", ideal, states[k].rotation, states[k].centre});
  }
  return cameras;
}

/// Calls work(k) for k in [0, count) on all cores; the first exception stops the others and is thrown here.
template <typename Work>
void for_each_parallel(std::size_t count, Work work) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr error;
  std::mutex error_mutex;
  const auto run = [&] {
    try {
      for (std::size_t k = next++; k < count; k = next++) work(k);
    } catch (...) {
      next = count;
      const std::lock_guard lock(error_mutex);
      if (!error) error = std::current_exception();
    }
  };
  const std::size_t cores = std::clamp<std::size_t>(std::thread::hardware_concurrency(), 1, 16);
  {
    std::vector<std::jthread> threads;
    for (std::size_t k = 1; k < std::min(cores, count); ++k) threads.emplace_back(run);
    run();
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace

void render_flight(const fs::path& dir, const WorldParams& world, const FlightParams& flight,
                   const std::function<void(int done, int total)>& progress) {
  const Terrain terrain(world);
  const Trajectory trajectory(flight);
  const std::vector<CameraState> states = fly(flight);
  CameraEffects effects;
  effects.read_noise_grey = 1;
  const Renderer renderer(terrain, flight.camera, effects, flight.seed);
  const fs::path images = dir / "images";
  const fs::path depths = dir / "truth" / "depth";
  fs::create_directories(images);
  fs::create_directories(depths);
  write_colmap_camera(dir / "cameras.txt", flight.camera);
  write_reference_cameras(dir / "truth" / "poses.txt", "true cameras of a simulated flight; world in metres, z up",
                          true_cameras(states, flight.camera));

  int done = 0;
  std::mutex progress_mutex;
  for_each_parallel(states.size(), [&](std::size_t k) {
    RenderedFrame frame;
    renderer.render(trajectory.motion(states[k].time_ns), static_cast<std::int64_t>(k), frame);
    write_pgm(images / (frame_name(k) + ".pgm"), frame.grey.view());
    write_pfm(depths / (frame_name(k) + ".pfm"), frame.depth_m.view());
    const std::lock_guard lock(progress_mutex);
    ++done;
    if (progress) progress(done, static_cast<int>(states.size()));
  });
  // Last, so that an index stands for a complete flight.
  write_text(dir / "index.txt", index_text(states));
}

}  // namespace ilp::sim
