#include "sim/world/flight.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/world/parameter.hpp"

namespace ilp::world {
namespace {

constexpr double linear_swing_rad = 0.7;

/// What a kind of flight does not do is zero: one model moves them all.
FlightParams as_flown(FlightParams p) {
  const bool balloon = p.kind == "balloon";
  if (!balloon) p.meander_m = p.gust_m_s = 0;
  if (!balloon && p.kind != "hover") p.altitude_oscillation = p.swing_rad = p.yaw_rad = p.yaw_rate_rad_s = 0;
  if (!balloon && p.kind != "line") p.drift_m_s = p.revisit = 0;
  if (p.kind != "descent") p.descent_m_s = p.descent_ratio = 0;
  if (p.descent_ratio > 0) p.descent_m_s = 0;
  return p;
}

std::int64_t nanoseconds(double time_s) {
  return std::llround(time_s * 1e9);
}

std::vector<std::int64_t> exposure_times(const FlightParams& p) {
  std::vector<std::int64_t> times;
  for (int k = 0; k < p.frames; ++k) {
    const double time_s = time_of_frame_s(p, k);
    if (time_s >= p.gap_start_s && time_s < p.gap_start_s + p.gap_length_s) continue;
    times.push_back(nanoseconds(time_s));
  }
  return times;
}

/// d/dt exp([v]x) = [left_jacobian(v) v']x exp([v]x).
Mat3 left_jacobian(const Vec3& v) {
  const double angle = v.norm();
  const double square = angle * angle;
  const bool tiny = angle < 1e-3;
  const double a = tiny ? 0.5 - square / 24 : (1 - det_cos(angle)) / square;
  const double b = tiny ? 1.0 / 6 - square / 120 : (angle - det_sin(angle)) / (square * angle);
  const Mat3 cross = cross_matrix(v);
  return Mat3::Identity() + a * cross + b * (cross * cross);
}

constexpr double least_sine = 0.25;       // of the angle below the horizon; the renderer itself needs 0.2
constexpr double most_image_posts = 4e7;  // about a gigabyte

/// Unit directions along the image's border, in the camera.
std::vector<Vec3> border_directions(const CameraModel& camera) {
  constexpr int steps = 16;
  std::vector<Vec3> directions;
  const auto add = [&](double u, double v) {
    const Vec2 n = normalised_from_pixel(camera, Vec2(u - 0.5, v - 0.5));
    directions.push_back(Vec3(n.x(), n.y(), 1).normalized());
  };
  for (int k = 0; k <= steps; ++k) {
    const double u = k * camera.width / double{steps};
    const double v = k * camera.height / double{steps};
    add(u, 0);
    add(u, camera.height);
    add(0, v);
    add(camera.width, v);
  }
  return directions;
}

[[noreturn]] void refuse(std::size_t frame, const CameraState& state, const std::string& message) {
  throw std::invalid_argument("frame " + std::to_string(frame + 1) + ", at " +
                              number_text(1e-9 * static_cast<double>(state.time_ns)) + " s: " + message);
}

double rounded(double value) {
  return std::floor(100 * value + 0.5) / 100;
}

}  // namespace

Course Trajectory::wave(double time_s, double amplitude, double period_s, double phase) const {
  const double turns = time_s / period_s;
  const double angle = 2 * pi * (turns - std::floor(turns)) + phase;
  const double frequency = 2 * pi / period_s;
  const double value = amplitude * det_sin(angle);
  return {value, amplitude * frequency * det_cos(angle), -frequency * frequency * value};
}

/// From 0 before the turn back to 1 after it, with a continuous acceleration.
Course Trajectory::turned_back(double time_s) const {
  const double length = params_.revisit_turn_s;
  const double begin = params_.revisit * flight_length_s(params_) - 0.5 * length;
  const double u = params_.revisit > 0 ? std::clamp((time_s - begin) / length, 0.0, 1.0) : 0.0;
  const double v = u * (1 - u);
  return {u * u * u * (10 + u * (6 * u - 15)), 30 * v * v / length, 60 * v * (1 - 2 * u) / (length * length)};
}

Course Trajectory::way_along(double time_s) const {
  const double speed = params_.drift_m_s;
  if (params_.revisit <= 0) return passes_.at(time_s).along;
  // Speed times (1 - 2 turned): the integral of the quintic is u^4 (2.5 - 3 u + u^2), 1/2 at its end.
  const double length = params_.revisit_turn_s;
  const double begin = params_.revisit * flight_length_s(params_) - 0.5 * length;
  const double u = std::clamp((time_s - begin) / length, 0.0, 1.0);
  const double after = std::max(0.0, time_s - begin - length);
  const double turned_s = length * u * u * u * u * (2.5 + u * (u - 3)) + after;
  const Course turned = turned_back(time_s);
  return {speed * (time_s - 2 * turned_s), speed * (1 - 2 * turned.value), -2 * speed * turned.rate};
}

Course Trajectory::way_across(double time_s) const {
  const Course pattern = passes_.at(time_s).across;
  const Course meander = wave(time_s, params_.meander_m, params_.meander_period_s, phases_.meander);
  const Course turned = turned_back(time_s);
  const double offset = params_.revisit_offset_m;
  return {meander.value + offset * turned.value + pattern.value, meander.rate + offset * turned.rate + pattern.rate,
          meander.acceleration + offset * turned.acceleration + pattern.acceleration};
}

Course Trajectory::yaw(double time_s) const {
  const Course pattern = passes_.at(time_s).yaw;
  const Course swinging = wave(time_s, params_.yaw_rad, params_.yaw_period_s, phases_.yaw);
  const Course turned = turned_back(time_s);
  return {within_a_turn(params_.drift_heading_rad + swinging.value + params_.yaw_rate_rad_s * time_s +
                        params_.revisit_yaw_rad * turned.value + pattern.value),
          swinging.rate + params_.yaw_rate_rad_s + params_.revisit_yaw_rad * turned.rate + pattern.rate, 0};
}

Course Trajectory::way_down(double time_s) const {
  const double length_s = flight_length_s(params_);
  if (!(params_.descent_ratio > 0) || !(length_s > 0)) return {};
  const double decay = det_log(params_.descent_ratio) / length_s;
  const double height = params_.altitude_m * det_exp(-decay * time_s);
  return {params_.altitude_m - height, decay * height, -decay * decay * height};
}

Pendulum Trajectory::swing(double angle_rad, double phase, const Gusts& gusts, double length_s,
                           Course (Trajectory::*way)(double) const) const {
  PendulumParams pendulum;
  pendulum.length_m = params_.suspension_m;
  pendulum.gravity_m_s2 = params_.gravity_m_s2;
  pendulum.damping = params_.swing_damping;
  pendulum.angle_rad = angle_rad * det_sin(phase);
  pendulum.rate_rad_s = angle_rad * det_cos(phase) * std::sqrt(params_.gravity_m_s2 / params_.suspension_m);
  pendulum.balloon_lag_s = params_.balloon_lag_s;
  const PivotDrive drive{[&](double t) { return gusts.at(t); }, [&](double t) { return (this->*way)(t).acceleration; }};
  Pendulum result(pendulum, drive, length_s);
  if (result.largest_angle_rad() > linear_swing_rad) {
    throw std::invalid_argument("[flight] gust_m_s, revisit_turn_s, pattern: the gondola would swing by " +
                                number_text(result.largest_angle_rad()) +
                                " rad: expected weaker gusts or slower turns, so that it stays within " +
                                number_text(linear_swing_rad) + " rad");
  }
  return result;
}

Trajectory::Trajectory(const FlightParams& params) : params_((validate(params), as_flown(params))), passes_(params_) {
  exposures_ = exposure_times(params_);
  const double length_s = (1 + slack) * flight_length_s(params_);
  end_ns_ = nanoseconds(length_s);
  Rng rng(params_.seed, 2);
  const auto phase = [&] { return 2 * pi * rng.uniform(); };
  phases_.altitude = phase();
  phases_.meander = phase();
  phases_.along = phase();
  phases_.across = phase();
  phases_.yaw = phase();
  const double azimuth = params_.off_nadir_azimuth_rad;
  const Vec3 tilt(params_.off_nadir_rad * det_sin(azimuth), -params_.off_nadir_rad * det_cos(azimuth), 0);
  mount_ = rotation_from_vector(tilt) * Vec3(1, -1, -1).asDiagonal();
  if (params_.kind == "balloon" || params_.kind == "hover") {
    const auto gusts = [&](std::uint64_t stream) {
      return Gusts(params_.gust_m_s, params_.gust_time_s, length_s, Normal(Rng(params_.seed, stream)));
    };
    along_ = swing(params_.swing_rad, phases_.along, gusts(3), length_s, &Trajectory::way_along);
    across_ = swing(0.5 * params_.swing_rad, phases_.across, gusts(4), length_s, &Trajectory::way_across);
  }
}

int Trajectory::pass_at(std::int64_t time_ns) const {
  return passes_.pass_at(1e-9 * static_cast<double>(time_ns));
}

CameraMotion Trajectory::motion(std::int64_t time_ns) const {
  if (time_ns < 0 || time_ns > end_ns_) {
    throw std::out_of_range("flight: asked for the camera at " + std::to_string(time_ns) + " ns, expected 0 to " +
                            std::to_string(end_ns_) + " ns");
  }
  const double t = 1e-9 * static_cast<double>(time_ns);
  const double c = det_cos(params_.drift_heading_rad);
  const double s = det_sin(params_.drift_heading_rad);
  const Vec3 ahead(c, s, 0);
  const Vec3 left(-s, c, 0);
  const Vec3 up(0, 0, 1);
  const PendulumState along = along_ ? along_->at(t) : PendulumState{};
  const PendulumState across = across_ ? across_->at(t) : PendulumState{};
  const Course way = way_along(t);
  const Course side = way_across(t);
  const Course height =
      wave(t, params_.altitude_m * params_.altitude_oscillation, params_.altitude_period_s, phases_.altitude);
  const Course heading = yaw(t);
  const Course level = passes_.at(t).height;
  const double altitude = params_.altitude_m + height.value;
  const Vec3 start(params_.start_x_m, params_.start_y_m, 0);

  // The gondola hangs rigidly below the pivot: it looks the way it swings.
  const Vec3 tilt = left * -along.angle_rad + ahead * across.angle_rad;
  const Mat3 swung = rotation_from_vector(tilt);
  const Vec3 swing_rate = left_jacobian(tilt) * (left * -along.rate_rad_s + ahead * across.rate_rad_s);
  const Mat3 world_from_cam = swung * rotation_from_vector(up * heading.value) * mount_;
  const Vec3 hanging = swung * (up * -params_.suspension_m);
  const Vec3 descent = world_from_cam.col(2) * params_.descent_m_s;
  const Course down = way_down(t);
  const Vec3 slope = ahead * params_.descent_drift - up;

  CameraMotion motion;
  motion.state.time_ns = time_ns;
  motion.state.rotation = world_from_cam.transpose();
  motion.state.centre = ahead * (way.value + along.shift_m) + left * (side.value + across.shift_m) +
                        up * (level.value * altitude + params_.suspension_m) + hanging + descent * t +
                        slope * down.value + start;
  motion.velocity_m_s = ahead * (way.rate + along.speed_m_s) + left * (side.rate + across.speed_m_s) +
                        up * (level.value * height.rate + level.rate * altitude) + swing_rate.cross(hanging) + descent +
                        slope * down.rate;
  motion.turn_rad_s = -(motion.state.rotation * (swing_rate + swung * (up * heading.rate)));
  return motion;
}

std::vector<CameraState> fly(const FlightParams& params) {
  const Trajectory trajectory(params);
  std::vector<CameraState> states;
  states.reserve(trajectory.exposures().size());
  for (const std::int64_t time_ns : trajectory.exposures()) states.push_back(trajectory.at(time_ns));
  return states;
}

void check_flight(const Terrain& terrain, const CameraModel& camera, std::span<const CameraState> states) {
  const std::vector<Vec3> border = border_directions(camera);
  for (std::size_t k = 0; k < states.size(); ++k) {
    const CameraState& state = states[k];
    const double z = state.centre.z();
    if (z <= terrain.highest()) {
      refuse(k, state,
             "the camera is at " + number_text(rounded(z)) + " m and the ground reaches up to " +
                 number_text(rounded(terrain.highest())) +
                 " m: expected a higher [flight] altitude_m, less descent or a lower [world] relief");
    }
    Vec2 low(std::numeric_limits<double>::max(), std::numeric_limits<double>::max());
    Vec2 high = -low;
    for (const Vec3& direction : border) {
      const Vec3 d = state.rotation.transpose() * direction;
      if (d.z() > -least_sine) {
        refuse(k, state,
               "the camera sees the horizon: expected a smaller [flight] off_nadir_rad or swing, or a longer [camera] "
               "focal length");
      }
      const Vec2 place = (terrain.lowest() - z) / d.z() * d.head<2>();
      low = low.cwiseMin(place);
      high = high.cwiseMax(place);
    }
    const double spacing = terrain.params().post_spacing_m;
    const double posts = (high - low).prod() / (spacing * spacing);
    if (posts > most_image_posts) {
      refuse(k, state,
             "the image shows " + number_text(std::floor(posts / 1e6)) +
                 " million posts of ground: expected a wider [world] post_spacing_m (and wavelengths), a lower "
                 "[flight] altitude_m or a smaller off_nadir_rad");
    }
  }
}

}  // namespace ilp::world
