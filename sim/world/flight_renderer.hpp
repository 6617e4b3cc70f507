// Renders the frames of one flight. Its passes may have different light.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/world/flight.hpp"
#include "sim/world/renderer.hpp"
#include "sim/world/scenario.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::world {

class FlightRenderer {
 public:
  /// Throws the exceptions of Terrain, Trajectory and Renderer.
  explicit FlightRenderer(const Scenario& scenario);

  [[nodiscard]] const Trajectory& trajectory() const { return trajectory_; }
  /// The terrain with the light of the first pass. All passes have the same heights.
  [[nodiscard]] const Terrain& terrain() const { return terrains_.front(); }

  /// Sets the effects for the next frames. Must not be called while a frame is rendered.
  void set_effects(const CameraEffects& effects);
  /// Renders the frame at a time of the flight. Thread-safe.
  void render(std::int64_t time_ns, std::int64_t frame_index, RenderedFrame& out) const;

 private:
  Trajectory trajectory_;
  std::vector<Terrain> terrains_;    // one per direction of the sun
  std::vector<Renderer> renderers_;  // one per terrain, to which it keeps a reference
};

}  // namespace ilp::world
