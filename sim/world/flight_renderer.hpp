// Renders the frames of one flight, whose passes may have different light.
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
  /// The same exceptions as Terrain, Trajectory and Renderer.
  explicit FlightRenderer(const Scenario& scenario);

  [[nodiscard]] const Trajectory& trajectory() const { return trajectory_; }
  /// Its heights are those of every pass, its light is that of the first.
  [[nodiscard]] const Terrain& terrain() const { return terrains_.front(); }

  /// For the next frames. Not to be called while one is rendered.
  void set_effects(const CameraEffects& effects);
  /// The frame at a time of the flight. Safe to call from several threads.
  void render(std::int64_t time_ns, std::int64_t frame_index, RenderedFrame& out) const;

 private:
  Trajectory trajectory_;
  std::vector<Terrain> terrains_;    // one for each sun
  std::vector<Renderer> renderers_;  // likewise; they borrow the terrains
};

}  // namespace ilp::world
