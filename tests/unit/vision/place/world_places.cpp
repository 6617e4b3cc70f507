#include "tests/unit/vision/place/world_places.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/world/renderer.hpp"
#include "tests/unit/vision/place/place_images.hpp"

namespace ilp::test {
namespace {

constexpr double sun_step_rad = 0.593;  // 34 degrees
constexpr std::int32_t truth_stride_px = 15;

double between(double low, double high, Rng& rng) {
  return low + (high - low) * rng.uniform();
}

world::CameraState look_down_at(double x, double y, double height_m, double aside_m, Rng& rng) {
  const Vec3 tilt(between(-0.06, 0.06, rng), between(-0.06, 0.06, rng), 0);
  const Vec3 heading(0, 0, between(-pi, pi, rng));
  world::CameraState state;
  state.rotation = rotation_from_vector(tilt) * rotation_from_vector(heading) * Vec3(1, -1, -1).asDiagonal();
  state.centre = Vec3(x + between(-aside_m, aside_m, rng), y + between(-aside_m, aside_m, rng), height_m);
  return state;
}

}  // namespace

world::Scenario world_of_places(const std::string& name) {
  const char* const dunes = "sim/campaigns/revisit/dunes.ini";
  world::Scenario scenario;
  if (name == "dunes") {
    scenario = world::load_scenario(dunes, {});
  } else if (name == "low-sun") {
    scenario = world::load_scenario(dunes, {});
    scenario.world.sun_elevation_rad = 0.25;
  } else if (name == "long-dunes") {
    scenario = world::load_scenario(dunes, {});
    scenario.world.dune_wavelength_m = 30;
    scenario.world.dune_height_m = 4;
    scenario.world.albedo_contrast = 0.1;
  } else if (name == "ripples") {
    scenario = world::load_scenario(dunes, {});
    scenario.world.relief_m = 1;
    scenario.world.dune_wavelength_m = 7;
    scenario.world.dune_height_m = 0.8;
    scenario.world.dune_asymmetry = 0.2;
    scenario.world.albedo_contrast = 0.1;
  } else {
    scenario = world::scenario_preset(name);
  }
  return scenario;
}

void add_views(const WorldVisits& visits, std::vector<WorldView>& views) {
  const world::Scenario scenario = world_of_places(visits.world);
  const CameraModel& camera = scenario.flight.camera;
  const double altitude = scenario.flight.altitude_m;
  const double footprint = altitude * camera.width / camera.fx;
  Rng rng(visits.seed);
  std::int64_t frame = 0;
  for (const bool further_sun : {false, true}) {
    world::WorldParams world = scenario.world;
    world.seed = visits.seed;
    world.sun_azimuth_rad += further_sun ? sun_step_rad : 0;
    const world::Terrain terrain(world);
    const world::Renderer renderer(terrain, camera, scenario.effects, visits.seed);
    for (int spot = 0; spot < visits.spots; ++spot) {
      // Farther apart than the widest views.
      const double x = 3.1 * footprint * (spot % 4), y = 3.3 * footprint * (spot / 4);
      for (int k = 0; k < (further_sun ? visits.views_under_further_sun : visits.views); ++k) {
        const double height = altitude * std::sqrt(0.7) * std::pow(2, rng.uniform());
        world::CameraMotion motion{.state = look_down_at(x, y, height, footprint / 6, rng)};
        world::RenderedFrame rendered;
        renderer.render(motion, frame++, rendered);
        Image image(camera.width, camera.height);
        image.pixels = rendered.grey.samples;
        views.push_back({visits.world, visits.seed, further_sun, features_of(image, visits.features),
                         world::true_frame(camera, motion.state.rotation, motion.state.centre,
                                           std::as_const(rendered.depth_m).view(), truth_stride_px)});
      }
    }
  }
}

double common_ground(const WorldView& a, const WorldView& b) {
  if (a.world != b.world || a.seed != b.seed) return 0;
  return std::min(world::true_overlap(a.truth, b.truth), world::true_overlap(b.truth, a.truth));
}

bool nothing_in_common(const WorldView& a, const WorldView& b) {
  if (a.seed != b.seed) return true;
  if (a.world != b.world) return false;
  return world::true_overlap(a.truth, b.truth) <= 0 && world::true_overlap(b.truth, a.truth) <= 0;
}

}  // namespace ilp::test
