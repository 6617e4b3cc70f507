// Keyframes of simulated flights without images: points of the simulated ground, seen with noise, missed detections
// and wrong matches by a camera on a simulated trajectory.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <unordered_map>
#include <vector>

#include "fsw/vision/features/feature_types.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "sim/world/flight.hpp"
#include "sim/world/terrain.hpp"
#include "sim/world/world_params.hpp"

namespace ilp::test {

struct FlightScene {
  std::string world = "mars-canyon";
  unsigned seed = 1;
  double ruggedness = 1;
  double swing_rad = 0.1;  ///< amplitude along the drift at the beginning
  double yaw_rad = 0.2;
  double field_of_view_rad = 1.047;
  double centre_offset_px = 6;  ///< standard deviation of the true principal point about the image's middle
  double overlap = 0.82;
  std::size_t keyframes = 10;
  int corners = 500;      ///< in an image
  double noise_px = 0.2;  ///< of every observation
  double drift_px = 0;    ///< of the random walk along a track
  double found = 0.85;    ///< share of a keyframe's points that are matched again
  double wrong = 0.1;     ///< share of matches that join different corners
  bool line = false;      ///< straight, one altitude, one attitude
  bool hover = false;     ///< stays where it is but for what swings it
};

struct FlightKeyframe {
  world::CameraState truth;
  Corners corners;
  Matches matches;  ///< to the keyframe before
};

struct SyntheticFlight {
  CameraModel camera;   ///< true
  CameraModel nominal;  ///< what is known of it: the size; its focal length is another one
  std::vector<FlightKeyframe> keyframes;

  explicit SyntheticFlight(const FlightScene& scene) : random_(scene.seed * 7919 + 17) {
    const world::WorldPreset& preset = world::world_preset(scene.world);
    choose_camera(scene);
    world::FlightParams flight = flight_of(scene, preset);
    const world::Trajectory trajectory(flight);
    world::WorldParams world = preset.world;
    world.seed = scene.seed;
    world.ruggedness *= scene.ruggedness;
    const world::Terrain terrain(world);
    const std::vector<world::CameraState> states = choose_keyframes(scene, preset, trajectory);
    plant(scene, preset, terrain, states);
    std::unordered_map<std::size_t, std::uint16_t> previous;
    std::unordered_map<std::size_t, Vec2> walk;
    for (const world::CameraState& state : states) {
      keyframes.push_back({state, {}, {}});
      previous = observe(scene, previous, walk, keyframes.back());
    }
  }

 private:
  void choose_camera(const FlightScene& scene) {
    std::normal_distribution<double> normal(0, 1);
    camera.width = 640;
    camera.height = 480;
    camera.fx = camera.fy = 320 / std::tan(0.5 * scene.field_of_view_rad);
    camera.cx = 319.5 + scene.centre_offset_px * normal(random_);
    camera.cy = 239.5 + scene.centre_offset_px * normal(random_);
    nominal = camera;
    nominal.fx = nominal.fy = 700;
    nominal.cx = 319.5;
    nominal.cy = 239.5;
  }

  world::FlightParams flight_of(const FlightScene& scene, const world::WorldPreset& preset) const {
    world::FlightParams flight;
    flight.seed = scene.seed;
    flight.kind = scene.line ? "line" : scene.hover ? "hover" : "balloon";
    flight.frames = std::max(400, 40 * static_cast<int>(scene.keyframes));
    flight.interval_s = 0.5;
    flight.camera = camera;
    flight.altitude_m = preset.altitude_m;
    flight.drift_m_s = preset.drift_m_s;
    flight.swing_rad = scene.swing_rad;
    flight.yaw_rad = scene.yaw_rad;
    flight.swing_damping = 0.005;
    return flight;
  }

  [[nodiscard]] static bool project(const CameraModel& camera, const world::CameraState& state, const Vec3& ground,
                                    Vec2& pixel) {
    const Vec3 x = state.rotation * (ground - state.centre);
    if (!(x.z() > 0)) return false;
    pixel = {camera.fx * x.x() / x.z() + camera.cx, camera.fy * x.y() / x.z() + camera.cy};
    return pixel.x() > 4 && pixel.y() > 4 && pixel.x() < camera.width - 5 && pixel.y() < camera.height - 5;
  }

  /// Share of a grid of level ground below `a` that `b` sees too.
  [[nodiscard]] double overlap(const world::CameraState& a, const world::CameraState& b) const {
    int seen = 0, common = 0;
    const double reach = 2 * a.centre.z();
    for (int i = -20; i <= 20; ++i) {
      for (int j = -20; j <= 20; ++j) {
        const Vec3 x(a.centre.x() + 0.05 * i * reach, a.centre.y() + 0.05 * j * reach, 0);
        Vec2 pixel;
        if (!project(camera, a, x, pixel)) continue;
        ++seen;
        common += project(camera, b, x, pixel) ? 1 : 0;
      }
    }
    return seen > 0 ? static_cast<double>(common) / seen : 0;
  }

  [[nodiscard]] std::vector<world::CameraState> choose_keyframes(const FlightScene& scene, const world::WorldPreset&,
                                                                 const world::Trajectory& trajectory) const {
    std::vector<world::CameraState> states;
    for (const std::int64_t time : trajectory.exposures()) {
      const world::CameraState state = trajectory.at(time);
      const bool next = states.empty() || overlap(states.back(), state) <= scene.overlap ||
                        (scene.hover && time - states.back().time_ns > 3'000'000'000);
      if (next) states.push_back(state);
      if (states.size() == scene.keyframes) break;
    }
    return states;
  }

  void plant(const FlightScene& scene, const world::WorldPreset& preset, const world::Terrain& terrain,
             const std::vector<world::CameraState>& states) {
    const double half = 1.6 * preset.altitude_m * 320 / camera.fx;
    double x0 = 1e9, x1 = -1e9, y0 = 1e9, y1 = -1e9;
    for (const world::CameraState& s : states) {
      const Vec3 axis = s.rotation.row(2);
      const Vec3 foot = s.centre - axis * (s.centre.z() / axis.z());
      x0 = std::min(x0, foot.x() - half);
      x1 = std::max(x1, foot.x() + half);
      y0 = std::min(y0, foot.y() - half);
      y1 = std::max(y1, foot.y() + half);
    }
    const double image_area = preset.altitude_m * preset.altitude_m * (640 / camera.fx) * (480 / camera.fx);
    const auto count = static_cast<std::size_t>(scene.corners * (x1 - x0) * (y1 - y0) / image_area);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (std::size_t i = 0; i < count; ++i) {
      const double x = x0 + (x1 - x0) * uniform(random_);
      const double y = y0 + (y1 - y0) * uniform(random_);
      ground_.emplace_back(x, y, terrain.height(x, y));
    }
  }

  std::unordered_map<std::size_t, std::uint16_t> observe(const FlightScene& scene,
                                                         const std::unordered_map<std::size_t, std::uint16_t>& previous,
                                                         std::unordered_map<std::size_t, Vec2>& walk,
                                                         FlightKeyframe& frame) {
    std::normal_distribution<double> normal(0, 1);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::unordered_map<std::size_t, std::uint16_t> seen;
    std::vector<Match> matches;
    for (std::size_t i = 0; i < ground_.size() && !frame.corners.full(); ++i) {
      Vec2 pixel;
      if (!project(camera, frame.truth, ground_[i], pixel)) continue;
      const auto before = previous.find(i);
      Vec2& error = walk[i];
      error =
          before == previous.end() ? Vec2(0, 0) : Vec2(error + scene.drift_px * Vec2(normal(random_), normal(random_)));
      pixel += error + scene.noise_px * Vec2(normal(random_), normal(random_));
      seen[i] = static_cast<std::uint16_t>(frame.corners.size());
      (void)frame.corners.push_back({static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), 1});
      if (before == previous.end()) continue;
      if (uniform(random_) < scene.found) {
        matches.push_back({before->second, seen[i], 0.9F, 0, 0});
      }
    }
    // Wrong matches trade their partners, as repeated texture makes them.
    std::vector<std::size_t> wrong;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      if (uniform(random_) < scene.wrong) wrong.push_back(i);
    }
    std::shuffle(wrong.begin(), wrong.end(), random_);
    for (std::size_t i = 1; i < wrong.size(); ++i) std::swap(matches[wrong[i - 1]].b, matches[wrong[i]].b);
    std::sort(matches.begin(), matches.end(), [](const Match& a, const Match& b) { return a.a < b.a; });
    for (Match& m : matches) {
      m.xb = frame.corners[m.b].x;
      m.yb = frame.corners[m.b].y;
      (void)frame.matches.push_back(m);
    }
    return seen;
  }

  std::mt19937 random_;
  std::vector<Vec3> ground_;
};

}  // namespace ilp::test
