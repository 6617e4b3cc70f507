#include "sim/world/vehicle_sensors.hpp"

#include <array>
#include <cmath>
#include <cstdio>

#include "cfg/choices.hpp"
#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/shared/body_figure.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/world/balloon_swing.hpp"
#include "sim/world/render_flight.hpp"

namespace ilp::world {
namespace {

constexpr std::uint64_t sensor_stream = 71;
constexpr double position_time_s = 30;

std::string numbers(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) {
    std::array<char, 40> number{};
    std::snprintf(number.data(), number.size(), ",%.12g", value);
    text += number.data();
  }
  return text;
}

/// An error that is correlated over position_time_s, of one axis.
class SlowError {
 public:
  double step(double sigma, double dt_s, double normal) {
    const double keep = det_exp(-dt_s / position_time_s);
    value_ = begun_ ? keep * value_ + sigma * std::sqrt(1 - keep * keep) * normal : sigma * normal;
    begun_ = true;
    return value_;
  }

 private:
  double value_ = 0;
  bool begun_ = false;
};

std::string header(const VehicleSensors& s) {
  std::string text = "time_s";
  if (s.altimeter) text += ",height_m,height_sigma_m";
  if (s.attitude) text += ",qw,qx,qy,qz,tilt_sigma_rad";
  if (s.attitude && s.heading_noise_rad > 0) text += ",heading_sigma_rad";
  if (s.position) text += ",longitude_deg,latitude_deg,horizontal_sigma_m,elevation_m,vertical_sigma_m";
  if (s.velocity) text += ",velocity_east_m_s,velocity_north_m_s,velocity_up_m_s,velocity_sigma_m_s";
  return text + "\n";
}

class Sensors {
 public:
  Sensors(const VehicleSensors& sensors, const Terrain& terrain, std::uint64_t seed)
      : s_(sensors), terrain_(terrain), rng_(seed, sensor_stream), normal_(Rng(seed, sensor_stream + 1)) {
    degree_ = degree_lengths(body_of(sensors), sensors.latitude_deg, sensors.elevation_m);
  }

  std::string line(const CameraMotion& motion, double time_s) {
    std::array<char, 40> time{};
    std::snprintf(time.data(), time.size(), "%.9f", time_s);
    std::string text = time.data();
    if (s_.altimeter) text += height(motion.state);
    if (s_.attitude) text += attitude(motion.state, time_s);
    if (s_.position) text += position(motion.state);
    if (s_.velocity) text += velocity(motion);
    return text + "\n";
  }

 private:
  std::string height(const CameraState& state) {
    const double truth = height_above_ground(terrain_, state);
    double measured = truth * (1 + s_.height_noise * normal_.next());
    if (rng_.uniform() < s_.height_outliers) measured = truth * (0.1 + 2.4 * rng_.uniform());
    return numbers({measured, s_.height_noise * truth});
  }
  std::string attitude(const CameraState& state, double time_s) {
    // Two slow waves that are not in step.
    const double drift_x = s_.attitude_drift_rad * det_sin(2 * pi * time_s / 900);
    const double drift_y = s_.attitude_drift_rad * det_sin(2 * pi * time_s / 700 + 1);
    const Vec3 level_error(drift_x + s_.tilt_noise_rad * normal_.next(), drift_y + s_.tilt_noise_rad * normal_.next(),
                           s_.heading_noise_rad * normal_.next());
    RigidTransform reported;
    reported.rotation = state.rotation * rotation_from_vector(level_error);
    const Pose pose = pose_from(reported);
    const double(&q)[4] = pose.q_cam_from_world;
    std::string text = numbers({q[0], q[1], q[2], q[3], s_.tilt_noise_rad});
    if (s_.heading_noise_rad > 0) text += numbers({s_.heading_noise_rad});
    return text;
  }
  std::string position(const CameraState& state) {
    const double dt = 1 / s_.rate_hz;
    const double east = state.centre.x() + slow_[0].step(s_.horizontal_noise_m, dt, normal_.next());
    const double north = state.centre.y() + slow_[1].step(s_.horizontal_noise_m, dt, normal_.next());
    const double up = state.centre.z() + slow_[2].step(s_.vertical_noise_m, dt, normal_.next());
    return numbers({s_.longitude_deg + east / degree_.east_m, s_.latitude_deg + north / degree_.north_m,
                    s_.horizontal_noise_m, s_.elevation_m + up, s_.vertical_noise_m});
  }
  std::string velocity(const CameraMotion& motion) {
    const Vec3& v = motion.velocity_m_s;
    const double sigma = s_.velocity_noise_m_s;
    return numbers(
        {v.x() + sigma * normal_.next(), v.y() + sigma * normal_.next(), v.z() + sigma * normal_.next(), sigma});
  }

  const VehicleSensors& s_;
  const Terrain& terrain_;
  Rng rng_;
  Normal normal_;
  DegreeLengths degree_;
  std::array<SlowError, 3> slow_;
};

}  // namespace

std::vector<Parameter> parameters(VehicleSensors& s) {
  return {
      {"altimeter", &s.altimeter, "", "measures the height above the ground straight below"},
      {"height_noise", &s.height_noise, "", "one sigma, share of the height", 1e-6, 1},
      {"height_outliers", &s.height_outliers, "", "share of the heights that are wrong", 0, 1},
      {"attitude", &s.attitude, "", "measures the camera's attitude"},
      {"tilt_noise_rad", &s.tilt_noise_rad, "rad", "one sigma about each horizontal axis", 1e-7, 1},
      {"heading_noise_rad", &s.heading_noise_rad, "rad", "one sigma about the vertical; 0: north is not known", 0, 1},
      {"attitude_drift_rad", &s.attitude_drift_rad, "rad", "amplitude of a slow error of the tilt", 0, 1},
      {"position", &s.position, "", "measures longitude, latitude and elevation"},
      {"horizontal_noise_m", &s.horizontal_noise_m, "m", "one sigma, correlated over half a minute", 1e-4, 1e5},
      {"vertical_noise_m", &s.vertical_noise_m, "m", "one sigma, correlated over half a minute", 1e-4, 1e5},
      {"velocity", &s.velocity, "", "measures the velocity"},
      {"velocity_noise_m_s", &s.velocity_noise_m_s, "m/s", "one sigma", 1e-4, 1e3},
      {"rate_hz", &s.rate_hz, "Hz", "of all sensors", 0.01, 50},
      {"begin_s", &s.begin_s, "s", "when the sensors begin to measure", 0, 1e9},
      {"end_s", &s.end_s, "s", "when they end", 0, 1e9},
      {"outage_begin_s", &s.outage_begin_s, "s", "when an outage begins", 0, 1e9},
      {"outage_length_s", &s.outage_length_s, "s", "how long it lasts", 0, 1e9},
      {"body", &s.body, "", "mars, titan, venus, moon or earth; empty: that of the scenario, or mars"},
      {"longitude_deg", &s.longitude_deg, "deg", "of the world's origin", -180, 360},
      {"latitude_deg", &s.latitude_deg, "deg", "of the world's origin", -89, 89},
      {"elevation_m", &s.elevation_m, "m", "of the world's origin", -1e5, 1e5},
  };
}

Body body_of(const VehicleSensors& sensors) {
  const EnumValue* const found = find_value(values_of(Body{}), sensors.body.c_str());
  return found != nullptr && found->number != 0 ? static_cast<Body>(found->number) : Body::mars;
}

std::string navigation_text(const VehicleSensors& sensors, const Terrain& terrain, const Trajectory& trajectory,
                            std::uint64_t seed) {
  std::string text = header(sensors);
  Sensors vehicle(sensors, terrain, seed);
  const auto period_ns = static_cast<std::int64_t>(1e9 / sensors.rate_hz);
  for (std::int64_t time = 0; time <= trajectory.end_ns(); time += period_ns) {
    const double time_s = static_cast<double>(time) / 1e9;
    const std::string line = vehicle.line(trajectory.motion(time), time_s);
    const bool out = time_s >= sensors.outage_begin_s && time_s < sensors.outage_begin_s + sensors.outage_length_s;
    if (!out && time_s >= sensors.begin_s && time_s <= sensors.end_s) text += line;
  }
  return text;
}

}  // namespace ilp::world
