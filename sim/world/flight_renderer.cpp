#include "sim/world/flight_renderer.hpp"

namespace ilp::world {
namespace {

/// One for each pass, or a single one if the sun stays where it is.
std::vector<Terrain> terrains_of(const Scenario& scenario) {
  const FlightParams& flight = scenario.flight;
  const int suns = flight.pass_sun_azimuth_rad == 0 ? 1 : flight.passes;
  std::vector<Terrain> terrains;
  for (int k = 0; k < suns; ++k) {
    WorldParams world = scenario.world;
    world.sun_azimuth_rad += k * flight.pass_sun_azimuth_rad;
    terrains.emplace_back(world);
  }
  return terrains;
}

}  // namespace

FlightRenderer::FlightRenderer(const Scenario& scenario)
    : trajectory_(scenario.flight), terrains_(terrains_of(scenario)) {
  for (const Terrain& terrain : terrains_) {
    renderers_.emplace_back(terrain, scenario.flight.camera, scenario.effects, scenario.flight.seed);
  }
}

void FlightRenderer::set_effects(const CameraEffects& effects) {
  for (Renderer& renderer : renderers_) renderer.set_effects(effects);
}

void FlightRenderer::render(std::int64_t time_ns, std::int64_t frame_index, RenderedFrame& out) const {
  const auto sun = renderers_.size() == 1 ? 0 : static_cast<std::size_t>(trajectory_.pass_at(time_ns));
  renderers_[sun].render(trajectory_.motion(time_ns), frame_index, out);
}

}  // namespace ilp::world
