#include "tests/unit/vision/map/map_world.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "fsw/base/math.hpp"
#include "fsw/vision/map/ground_point.hpp"

namespace ilp::test {
namespace {

constexpr double heights_step_px = 0.02;

/// Values on a regular grid, bilinear between.
struct Grid {
  std::int32_t columns = 0, rows = 0;
  std::vector<float> values;

  [[nodiscard]] double at(double column, double row) const {
    const double c = std::clamp(column, 0.0, columns - 1.001), r = std::clamp(row, 0.0, rows - 1.001);
    const auto ci = static_cast<std::int32_t>(c), ri = static_cast<std::int32_t>(r);
    const double fc = c - ci, fr = r - ri;
    const auto value = [&](std::int32_t x, std::int32_t y) {
      return static_cast<double>(
          values[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x)]);
    };
    return (1 - fr) * ((1 - fc) * value(ci, ri) + fc * value(ci + 1, ri)) +
           fr * ((1 - fc) * value(ci, ri + 1) + fc * value(ci + 1, ri + 1));
  }
  /// Mean over a square about a place.
  [[nodiscard]] double mean(double column, double row, double side) const {
    const int n = std::max(2, static_cast<int>(std::ceil(side)) + 1);
    double sum = 0;
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) sum += at(column + ((i + 0.5) / n - 0.5) * side, row + ((j + 0.5) / n - 0.5) * side);
    }
    return sum / (n * n);
  }
  /// By a kernel of three along each axis.
  void smooth(double side_weight) {
    const std::vector<float> from = values;
    const auto get = [&](std::int32_t c, std::int32_t r) {
      c = std::clamp(c, 0, columns - 1);
      r = std::clamp(r, 0, rows - 1);
      return static_cast<double>(
          from[static_cast<std::size_t>(r) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(c)]);
    };
    const double k[3] = {side_weight, 1 - 2 * side_weight, side_weight};
    std::size_t at = 0;
    for (std::int32_t r = 0; r < rows; ++r) {
      for (std::int32_t c = 0; c < columns; ++c) {
        double sum = 0;
        for (int j = 0; j < 3; ++j) {
          for (int i = 0; i < 3; ++i) sum += k[i] * k[j] * get(c + i - 1, r + j - 1);
        }
        values[at++] = static_cast<float>(sum);
      }
    }
  }
};

Grid smooth_noise(std::int32_t columns, std::int32_t rows, double sigma, Rng& rng) {
  Grid grid{columns, rows, std::vector<float>(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows))};
  for (float& value : grid.values) value = static_cast<float>(normal(rng));
  grid.smooth(0.25);
  grid.smooth(0.25);
  double squares = 0;
  for (const float value : grid.values) squares += static_cast<double>(value) * static_cast<double>(value);
  const double scale = sigma / std::sqrt(squares / static_cast<double>(grid.values.size()));
  for (float& value : grid.values) value = static_cast<float>(scale * static_cast<double>(value));
  return grid;
}

world::Scenario scenario_of(const std::string& name, std::uint64_t seed) {
  world::Scenario scenario =
      name == "dunes" ? world::load_scenario("sim/campaigns/revisit/dunes.ini", {}) : world::scenario_preset(name);
  scenario.world.seed = seed;
  return scenario;
}

}  // namespace

double normal(Rng& rng) {
  const double u = std::max(rng.uniform(), 1e-12);
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * pi * rng.uniform());
}

OrbitalMap make_orbital_map(const world::Terrain& terrain, const world::Rectangle& area,
                            const OrbitalMapParams& params) {
  const double m = params.pixel_m;
  OrbitalMap map;
  map.pixel_m = m;
  map.x0_m = std::floor(area.x0 / m) * m;
  map.y0_m = std::ceil(area.y1 / m) * m;
  map.columns = static_cast<std::int32_t>((area.x1 - map.x0_m) / m);
  map.rows = static_cast<std::int32_t>((map.y0_m - area.y0) / m);
  map.sun_azimuth_rad = terrain.params().sun_azimuth_rad;
  map.sun_elevation_rad = terrain.params().sun_elevation_rad;
  const world::SurfacePatch patch = terrain.patch({area.x0 - m, area.y0 - m, area.x1 + m, area.y1 + m});
  Grid light{patch.columns, patch.rows, patch.radiance}, heights{patch.columns, patch.rows, patch.height_m};
  const double s = patch.spacing_m;
  for (std::int32_t j = 0; j < patch.rows; ++j) {
    for (std::int32_t i = 0; i < patch.columns; ++i) {
      const std::size_t k = patch.index(i, j);
      light.values[k] *= static_cast<float>(
          terrain.detail((patch.first_i + i) * s, (patch.first_j + j) * s, static_cast<double>(patch.height_m[k]), s));
    }
  }
  const auto column_of = [&](double x) { return x / s - patch.first_i; };
  const auto row_of = [&](double y) { return y / s - patch.first_j; };
  const auto place_x = [&](double column) { return map.x0_m + (column + 0.5) * m; };
  const auto place_y = [&](double row) { return map.y0_m - (row + 0.5) * m; };

  Grid grey{map.columns, map.rows, {}};
  for (std::int32_t r = 0; r < map.rows; ++r) {
    for (std::int32_t c = 0; c < map.columns; ++c) {
      grey.values.push_back(static_cast<float>(light.mean(column_of(place_x(c)), row_of(place_y(r)), m / s)));
    }
  }
  const double neighbour = std::exp(-0.5 / (params.blur_px * params.blur_px));
  grey.smooth(neighbour / (1 + 2 * neighbour));
  Rng rng(params.seed, 71);
  for (const float light_at : grey.values) {
    const double l = static_cast<double>(light_at);
    const double value = 255 * l / (l + 1) + params.noise_grey * normal(rng);
    map.image.push_back(static_cast<std::uint8_t>(std::lround(std::clamp(value, 1.0, 255.0))));
  }

  const double d = params.posts_px;  // map px
  Grid posts{static_cast<std::int32_t>(map.columns / d) + 2, static_cast<std::int32_t>(map.rows / d) + 2, {}};
  const Grid errors = smooth_noise(posts.columns, posts.rows, params.height_error_px * m, rng);
  for (std::int32_t r = 0; r < posts.rows; ++r) {
    for (std::int32_t c = 0; c < posts.columns; ++c) {
      const double height =
          heights.mean(column_of(place_x(c * d - 0.5)), row_of(place_y(r * d - 0.5)), std::max(1.5 * d * m / s, 1.0));
      const double with_error = height + static_cast<double>(errors.values[posts.values.size()]);
      const double step = heights_step_px * m;
      posts.values.push_back(static_cast<float>(std::round(with_error / step) * step));
    }
  }
  for (std::int32_t r = 0; r < map.rows; ++r) {
    for (std::int32_t c = 0; c < map.columns; ++c) {
      map.height_m.push_back(static_cast<float>(posts.at((c + 0.5) / d, (r + 0.5) / d)));
    }
  }
  return map;
}

OrbitalMap mirrored(const OrbitalMap& map) {
  OrbitalMap other = map;
  for (std::int32_t r = 0; r < map.rows; ++r) {
    const auto first = static_cast<std::ptrdiff_t>(r) * map.columns;
    std::reverse(other.image.begin() + first, other.image.begin() + first + map.columns);
    std::reverse(other.height_m.begin() + first, other.height_m.begin() + first + map.columns);
  }
  return other;
}

MapWindow WindowStore::fill(const OrbitalMap& map, const MapPlan& plan, double east_m, double south_m) {
  const std::size_t cells = static_cast<std::size_t>(plan.width) * static_cast<std::size_t>(plan.height);
  image.assign(cells, 0);
  known.assign(cells, 0);
  height_m.assign(cells, 0);
  const double ratio = plan.pixel_m / map.pixel_m;
  const int n = std::max(1, static_cast<int>(std::ceil(2 * ratio - 1e-9)) - 1);
  std::size_t at = 0;
  for (std::int32_t row = 0; row < plan.height; ++row) {
    for (std::int32_t column = 0; column < plan.width; ++column, ++at) {
      const double x = plan.x0_m() + (column + 0.5) * plan.pixel_m + east_m;
      const double y = plan.y0_m() - (row + 0.5) * plan.pixel_m - south_m;
      int grey = 0, count = 0;
      double height = 0;
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
          const double px = x + ((i + 0.5) / n - 0.5) * plan.pixel_m, py = y + ((j + 0.5) / n - 0.5) * plan.pixel_m;
          const auto c = static_cast<std::int32_t>(std::floor((px - map.x0_m) / map.pixel_m));
          const auto r = static_cast<std::int32_t>(std::floor((map.y0_m - py) / map.pixel_m));
          if (!map.holds(c, r)) continue;
          const std::size_t k =
              static_cast<std::size_t>(r) * static_cast<std::size_t>(map.columns) + static_cast<std::size_t>(c);
          if (map.image[k] == 0) continue;
          grey += map.image[k];
          height += static_cast<double>(map.height_m[k]);
          ++count;
        }
      }
      if (2 * count < n * n) continue;
      image[at] = static_cast<std::uint8_t>(std::max(1, grey / count));
      known[at] = 1;
      height_m[at] = static_cast<float>(height / count);
    }
  }
  MapWindow window;
  window.width = plan.width;
  window.height = plan.height;
  window.pixel_m = plan.pixel_m;
  window.x0_m = plan.x0_m();
  window.y0_m = plan.y0_m();
  window.image = image.data();
  window.height_m = height_m.data();
  window.known = known.data();
  window.sun_azimuth_rad = map.sun_azimuth_rad;
  window.sun_elevation_rad = map.sun_elevation_rad;
  return window;
}

MapWorld::MapWorld(const std::string& name, std::uint64_t seed) : scenario_(scenario_of(name, seed)) {
  terrain_ = std::make_unique<world::Terrain>(scenario_.world);
  renderer_ = std::make_unique<world::Renderer>(*terrain_, scenario_.flight.camera, scenario_.effects, seed);
}

world::Rectangle MapWorld::flight_area() const {
  const double a = altitude_m();
  return {0, 0, 2 * a, 0.8 * a};
}

world::Rectangle MapWorld::map_area() const {
  const world::Rectangle area = flight_area();
  const double a = 1.35 * altitude_m();
  return {area.x0 - a, area.y0 - a, area.x1 + a, area.y1 + a};
}

OrbitalMap MapWorld::map(double sun_offset_rad, const OrbitalMapParams& params) const {
  world::WorldParams world = scenario_.world;
  world.sun_azimuth_rad += sun_offset_rad;
  if (world.sun_azimuth_rad > pi) world.sun_azimuth_rad -= 2 * pi;
  return make_orbital_map(world::Terrain(world), map_area(), params);
}

void MapWorld::look(const Vec3& centre, double heading_rad, const PriorErrors& errors, Rng& rng,
                    MapTrial& trial) const {
  const Vec3 tilt(0.03 * normal(rng), 0.03 * normal(rng), 0);
  trial.motion.state.rotation =
      rotation_from_vector(tilt) * rotation_from_vector(Vec3(0, 0, heading_rad)) * Vec3(1, -1, -1).asDiagonal();
  trial.motion.state.centre = centre;
  renderer_->render(trial.motion, static_cast<std::int64_t>(rng.next() % 100000), trial.frame);
  const Mat3& rotation = trial.motion.state.rotation;
  trial.truth = {rotation, -(rotation * centre)};
  trial.ground = ground_below(trial.truth);

  const double a = altitude_m(), most = errors.place_share * a;
  const Vec3 turn = errors.attitude_rad * Vec3(normal(rng), normal(rng), normal(rng));
  const Vec3 moved = centre + Vec3(most * (2 * rng.uniform() - 1), most * (2 * rng.uniform() - 1),
                                   errors.height_share * a * normal(rng));
  trial.prior.camera_from_map.rotation = rotation_from_vector(turn) * rotation;
  trial.prior.camera_from_map.translation = -(trial.prior.camera_from_map.rotation * moved);
  trial.prior.covariance.setZero();
  for (int k = 0; k < 3; ++k) trial.prior.covariance(k, k) = errors.attitude_rad * errors.attitude_rad;
  trial.prior.covariance(3, 3) = trial.prior.covariance(4, 4) = most * most / (2.8 * 2.8);
  trial.prior.covariance(5, 5) = errors.height_share * errors.height_share * a * a;
  trial.prior.attitude_is_measured = true;
  trial.keyframe = {trial.frame.grey.view(), camera(), trial.prior.camera_from_map};
}

void MapWorld::look_anywhere(const PriorErrors& errors, Rng& rng, MapTrial& trial) const {
  const world::Rectangle area = flight_area();
  const Vec3 centre(area.x0 + rng.uniform() * (area.x1 - area.x0), area.y0 + rng.uniform() * (area.y1 - area.y0),
                    altitude_m() * (0.9 + 0.2 * rng.uniform()));
  look(centre, 2 * pi * rng.uniform(), errors, rng, trial);
}

Vec3 MapWorld::ground_below(const RigidTransform& camera_from_map) const {
  Vec3 ground = Vec3::Zero();
  for (int k = 0; k < 20; ++k) {
    const double height = terrain_->height(ground.x(), ground.y());
    if (!ground_on_level(camera_from_map, Vec3(0, 0, 1), height, ground)) break;
  }
  return ground;
}

MapPlan plan_of(const MapTrial& trial, const OrbitalMap& map) {
  const double image_m = image_pixel_m(trial.keyframe.camera, trial.prior.camera_from_map, 0);
  const double pixel_m = map_working_pixel_m(trial.keyframe.camera, image_m, map.pixel_m);
  return plan_map_window({&trial.keyframe, 1}, trial.prior, 0, pixel_m).value();
}

Vec2 true_shift_px(const MapWorld& world, const MapTrial& trial, const MapPlan& plan) {
  const Vec3 shift = trial.ground - world.ground_below(trial.prior.camera_from_map);
  return Vec2(shift.x(), -shift.y()) / plan.pixel_m;
}

void MapTally::add(const MapFixResult& result, const MapTrial& trial, double pixel_m) {
  ++trials;
  if (result.verdict != MapVerdict::fixed) return;
  ++fixed;
  const double error = (Vec2(result.ground_m[0], result.ground_m[1]) - trial.ground.head<2>()).norm() / pixel_m;
  wrong += error > 2.5 ? 1 : 0;
  ground_px.push_back(error);
  const Vec3 miss = camera_centre(result.camera_from_map) - camera_centre(trial.truth);
  const Mat3 covariance = result.covariance.bottomRightCorner<3, 3>();
  nees.push_back(miss.dot(covariance.inverse() * miss) / 3);
}

double MapTally::ground_quantile(double share) const {
  if (ground_px.empty()) return 1e9;
  std::vector<double> sorted = ground_px;
  std::sort(sorted.begin(), sorted.end());
  return sorted[static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size() - 1)))];
}

double MapTally::mean_nees() const {
  double sum = 0;
  for (const double value : nees) sum += value;
  return nees.empty() ? 1e9 : sum / static_cast<double>(nees.size());
}

NoisyDepths::NoisyDepths(const MapTrial& trial, Rng& rng) {
  const auto& depth = trial.frame.depth_m;
  const double scale = 1 + 0.01 * normal(rng);
  std::int32_t rows = 0;
  for (std::int32_t y = 0; y < depth.height; y += 3, ++rows) {
    for (std::int32_t x = 0; x < depth.width; x += 3) {
      samples.push_back(static_cast<float>(static_cast<double>(depth.at(x, y)) * scale * (1 + 0.002 * normal(rng))));
    }
  }
  depths = {{samples.data(), static_cast<std::int32_t>(samples.size()) / rows, rows}, 0, 3};
}

MapFixResult run_registration(const MapRegistrationInput& input, const MapRegistrationParams& params) {
  static const auto workspace = std::make_unique<MapRegistrationWorkspace>();
  static const auto registration = std::make_unique<MapRegistration>();
  if (!registration->begin(input, params, *workspace).ok()) return {};
  for (int slice = 0; slice < 100000; ++slice) {
    const Result<bool> more = registration->step();
    if (!more.ok()) return {};
    if (!more.value()) break;
  }
  return registration->result();
}

MapFixResult register_on_map(const MapTrial& trial, const MapPlan& plan, const MapWindow& window,
                             const SunDirection& sun, const MapRegistrationParams& params) {
  return run_registration({plan, window, trial.prior, {&trial.keyframe, 1}, sun, nullptr}, params);
}

}  // namespace ilp::test
