#include "sim/world/flight.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp::sim {
namespace {

void check(bool right, const char* field, const char* expected) {
  if (!right) throw std::invalid_argument(std::string("flight: ") + field + " must be " + expected);
}

void validate_flight(const FlightParams& p) {
  check(p.frames > 0 && p.frames <= 9999, "frames", "in 1 to 9999");
  check(p.interval_s > 0 && p.interval_s < 1e5, "interval_s", "positive");
  check(p.altitude_m > 0 && p.altitude_m < 1e6, "altitude_m", "positive");
  check(p.altitude_oscillation >= 0 && p.altitude_oscillation < 0.5, "altitude_oscillation", "in 0 to 0.5");
  check(p.drift_m_s >= 0 && p.drift_m_s < 1e3, "drift_m_s", "in 0 to 1000");
  check(p.drift_heading_rad > -100 && p.drift_heading_rad < 100, "drift_heading_rad", "an angle in radians");
  check(p.meander_m >= 0 && p.meander_m < 1e5, "meander_m", "not negative");
  check(p.swing_rad >= 0 && p.swing_rad < 0.5, "swing_rad", "in 0 to 0.5");
  check(p.suspension_m >= 0 && p.suspension_m < 1e4, "suspension_m", "not negative");
  check(p.yaw_rad >= 0 && p.yaw_rad < 100, "yaw_rad", "not negative");
  check(p.altitude_period_s > 0 && p.meander_period_s > 0 && p.swing_period_s > 0 && p.yaw_period_s > 0, "periods",
        "positive");
  check(p.noise_grey >= 0 && p.noise_grey < 50, "noise_grey", "in 0 to 50");
  check(validate(p.camera).ok(), "camera", "a valid camera");
}

/// Phases of the oscillations at time 0, rad.
struct Phases {
  double altitude, meander, along, across, yaw;
};

double wave(double time_s, double period_s, double phase) {
  const double turns = time_s / period_s;
  return det_sin(2 * pi * (turns - static_cast<double>(static_cast<std::int64_t>(turns))) + phase);
}

CameraState state_at(const FlightParams& p, const Phases& phases, double time_s) {
  const double c = det_cos(p.drift_heading_rad);
  const double s = det_sin(p.drift_heading_rad);
  const Vec3 ahead(c, s, 0);
  const Vec3 left(-s, c, 0);
  const double altitude =
      p.altitude_m * (1 + p.altitude_oscillation * wave(time_s, p.altitude_period_s, phases.altitude));
  const Vec3 pivot = ahead * (p.drift_m_s * time_s) +
                     left * (p.meander_m * wave(time_s, p.meander_period_s, phases.meander)) +
                     Vec3(0, 0, altitude + p.suspension_m);
  // The gondola hangs rigidly below the pivot: it looks the way it swings.
  const double along = p.swing_rad * wave(time_s, p.swing_period_s, phases.along);
  const double across = 0.5 * p.swing_rad * wave(time_s, p.swing_period_s, phases.across);
  const Mat3 swing = rotation_from_vector(left * -along + ahead * across);
  const double yaw = p.drift_heading_rad + p.yaw_rad * wave(time_s, p.yaw_period_s, phases.yaw);
  const Mat3 turn = rotation_from_vector(Vec3(0, 0, yaw));
  const Mat3 nadir = Vec3(1, -1, -1).asDiagonal();

  CameraState state;
  state.centre = pivot + swing * Vec3(0, 0, -p.suspension_m);
  state.rotation = nadir * (swing * turn).transpose();
  return state;
}

}  // namespace

CameraModel default_camera() {
  CameraModel camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = 550;
  camera.fy = 550;
  camera.cx = 319.5;
  camera.cy = 239.5;
  return camera;
}

std::vector<CameraState> fly(const FlightParams& params) {
  validate_flight(params);
  Rng rng(params.seed, 2);
  const auto phase = [&] { return 2 * pi * rng.uniform(); };
  Phases phases{};
  phases.altitude = phase();
  phases.meander = phase();
  phases.along = phase();
  phases.across = phase();
  phases.yaw = phase();
  std::vector<CameraState> states;
  states.reserve(static_cast<std::size_t>(params.frames));
  for (int k = 0; k < params.frames; ++k) {
    const double time_s = k * params.interval_s;
    states.push_back(state_at(params, phases, time_s));
    states.back().time_ns = std::llround(time_s * 1e9);
  }
  return states;
}

}  // namespace ilp::sim
