// A simulated world with an orbital map of it, and keyframes with a prior: trials for the registration against a map.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/vision/map/map_registration.hpp"
#include "sim/world/renderer.hpp"
#include "sim/world/scenario.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::test {

/// What an orbiter delivers: an image, and heights on posts four pixels apart with a smooth error. Rows from the north.
struct OrbitalMap {
  double pixel_m = 1, x0_m = 0, y0_m = 0;
  std::int32_t columns = 0, rows = 0;
  std::vector<std::uint8_t> image;
  std::vector<float> height_m;  ///< at each pixel, bilinear between posts
  double sun_azimuth_rad = 0, sun_elevation_rad = 0;

  [[nodiscard]] bool holds(std::int32_t column, std::int32_t row) const {
    return column >= 0 && row >= 0 && column < columns && row < rows;
  }
};

struct OrbitalMapParams {
  double pixel_m = 1;
  double noise_grey = 2;
  double blur_px = 0.5;
  double posts_px = 4;           ///< distance of two posts
  double height_error_px = 0.3;  ///< standard deviation
  std::uint64_t seed = 1;
};
/// Of the rectangle; pixels begin at whole multiples of the pixel.
[[nodiscard]] OrbitalMap make_orbital_map(const world::Terrain& terrain, const world::Rectangle& area,
                                          const OrbitalMapParams& params);
[[nodiscard]] OrbitalMap mirrored(const OrbitalMap& map);

/// The window of a plan from a map, moved by whole working pixels: what the map has `east_px` and `south_px` beside.
struct WindowStore {
  std::vector<std::uint8_t> image, known;
  std::vector<float> height_m;

  [[nodiscard]] MapWindow fill(const OrbitalMap& map, const MapPlan& plan, double east_m = 0, double south_m = 0);
};

[[nodiscard]] double normal(Rng& rng);

/// Errors of the prior: uniform in x and y, normal in height and attitude.
struct PriorErrors {
  double place_share = 0.2, height_share = 0.01, attitude_rad = 0.0087;
};
struct MapTrial {
  world::CameraMotion motion;
  MapKeyframe keyframe;  ///< its pose is that of the prior
  MapPrior prior;
  RigidTransform truth;
  Vec3 ground = Vec3::Zero();  ///< where the optical axis meets the terrain
  world::RenderedFrame frame;
};

/// A world under the sun of the flight, and cameras over it.
class MapWorld {
 public:
  MapWorld(const std::string& name, std::uint64_t seed);

  [[nodiscard]] double altitude_m() const { return scenario_.flight.altitude_m; }
  [[nodiscard]] double image_pixel_m() const { return altitude_m() / scenario_.flight.camera.fx; }
  [[nodiscard]] SunDirection sun() const {
    return {scenario_.world.sun_azimuth_rad, scenario_.world.sun_elevation_rad};
  }
  [[nodiscard]] const world::Terrain& terrain() const { return *terrain_; }
  [[nodiscard]] const CameraModel& camera() const { return scenario_.flight.camera; }
  /// Where maps are made, and where cameras stand.
  [[nodiscard]] world::Rectangle map_area() const;
  [[nodiscard]] world::Rectangle flight_area() const;
  /// The map under a sun `sun_offset_rad` further in azimuth.
  [[nodiscard]] OrbitalMap map(double sun_offset_rad, const OrbitalMapParams& params) const;
  void look(const Vec3& centre, double heading_rad, const PriorErrors& errors, Rng& rng, MapTrial& trial) const;
  /// Somewhere over the flight area.
  void look_anywhere(const PriorErrors& errors, Rng& rng, MapTrial& trial) const;
  [[nodiscard]] Vec3 ground_below(const RigidTransform& camera_from_map) const;

 private:
  world::Scenario scenario_;
  std::unique_ptr<world::Terrain> terrain_;
  std::unique_ptr<world::Renderer> renderer_;
};

/// The plan of a trial on a map, as a flight makes it: the mean height of the ground is 0.
[[nodiscard]] MapPlan plan_of(const MapTrial& trial, const OrbitalMap& map);
/// Where the keyframe's ground is on the window, from where the prior puts it: columns, rows.
[[nodiscard]] Vec2 true_shift_px(const MapWorld& world, const MapTrial& trial, const MapPlan& plan);

/// What a number of trials gave.
struct MapTally {
  int trials = 0, fixed = 0, wrong = 0;  ///< wrong: by more than 2.5 px
  double largest_evidence = -100;        ///< of those that have three quarters and no edge, in false trials
  std::vector<double> ground_px, nees;   ///< errors of the ground; of the position of the camera, over 3

  void add(const MapFixResult& result, const MapTrial& trial, double pixel_m);
  [[nodiscard]] double ground_quantile(double share) const;
  [[nodiscard]] double mean_nees() const;
};

/// Depths of a trial's frame at every third pixel: with the noise of a dense matcher, 0.2 %, and a strip whose length
/// is wrong by 1 % (one standard deviation).
struct NoisyDepths {
  std::vector<float> samples;
  KeyframeDepths depths;

  NoisyDepths(const MapTrial& trial, Rng& rng);
};
/// Runs the registration to its end. No map when it has failed.
MapFixResult run_registration(const MapRegistrationInput& input, const MapRegistrationParams& params = {});
/// By light, of one keyframe.
MapFixResult register_on_map(const MapTrial& trial, const MapPlan& plan, const MapWindow& window,
                             const SunDirection& sun, const MapRegistrationParams& params = {});

}  // namespace ilp::test
