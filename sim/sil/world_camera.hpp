// A triggered camera on a simulated flight: what it sees is rendered when it is told to expose.
#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <vector>

#include "hal/camera/camera.hpp"
#include "sim/world/flight.hpp"
#include "sim/world/renderer.hpp"
#include "sim/world/scenario.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::sim {

/// Exposes at the commanded time, rounded to its own granularity; ends with the flight. Every exposure becomes files of
/// the flight's folder (flight_files.hpp) and a line of exposures.txt, so that a resumed flight goes on: an exposure
/// that is already there is given again.
class WorldCamera final : public Camera {
 public:
  static constexpr TimeNs granularity_ns = ns_per_ms;

  /// std::invalid_argument for a flight that cannot be rendered, std::runtime_error for a folder that cannot be written
  /// or, with `resume`, does not hold the earlier exposures.
  WorldCamera(const Scenario& scenario, std::filesystem::path folder, bool resume);

  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override;
  [[nodiscard]] bool triggered() const override { return true; }
  Status trigger(TimeNs time) override;

  /// Writes the truth of all exposures.
  void finish(std::size_t threads);

 private:
  /// Number of the exposure at this time, counted from 1; made first if it is not there yet.
  std::size_t expose(TimeNs time);

  Scenario scenario_;
  std::filesystem::path folder_;
  Terrain terrain_;
  Trajectory trajectory_;
  Renderer renderer_;
  std::vector<CameraState> exposures_;
  std::optional<TimeNs> trigger_;
  std::ofstream list_;
  RenderedFrame rendered_;
};

}  // namespace ilp::sim
