// Computes pose and motion of the camera at any time of a simulated flight, and the times of its frames.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "sim/world/balloon_swing.hpp"
#include "sim/world/camera_state.hpp"
#include "sim/world/flight_params.hpp"
#include "sim/world/passes.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::world {

/// The trajectory of a flight. Position, attitude and their rates are continuous functions of time, the same on every
/// machine.
class Trajectory {
 public:
  /// Part of the trajectory after the last exposure, as a share of the flight's length.
  static constexpr double slack = 0.05;

  /// Throws std::invalid_argument that names the field that is out of range; also if gusts would swing the gondola by
  /// more than 0.7 rad, where the linear model of the pendulum is invalid.
  explicit Trajectory(const FlightParams& params);

  /// The state at a time from 0 to end_ns(). Throws std::out_of_range for other times.
  [[nodiscard]] CameraState at(std::int64_t time_ns) const { return motion(time_ns).state; }
  /// The state with its rates, which are the exact derivatives of the states.
  [[nodiscard]] CameraMotion motion(std::int64_t time_ns) const;
  [[nodiscard]] std::int64_t end_ns() const { return end_ns_; }
  /// Index of the pass at a time, from 0.
  [[nodiscard]] int pass_at(std::int64_t time_ns) const;

  /// Times of the frames in ns: at regular intervals from time 0 on, except in the gap and between passes.
  [[nodiscard]] const std::vector<std::int64_t>& exposures() const { return exposures_; }

 private:
  /// Phases of the oscillations at time 0, rad.
  struct Phases {
    double altitude = 0, meander = 0, along = 0, across = 0, yaw = 0;
  };
  [[nodiscard]] Course wave(double time_s, double amplitude, double period_s, double phase) const;
  [[nodiscard]] Course turned_back(double time_s) const;
  [[nodiscard]] Course way_along(double time_s) const;
  [[nodiscard]] Course way_across(double time_s) const;
  [[nodiscard]] Course yaw(double time_s) const;
  /// Metres downwards since time 0 in a descent with a descent_ratio.
  [[nodiscard]] Course way_down(double time_s) const;
  [[nodiscard]] Pendulum swing(double angle_rad, double phase, const Gusts& gusts, double length_s,
                               Course (Trajectory::*way)(double) const) const;

  FlightParams params_;
  Passes passes_;
  Phases phases_;
  Mat3 mount_ = Mat3::Identity();  // world_from_camera at rest
  std::optional<Pendulum> along_, across_;
  std::vector<std::int64_t> exposures_;
  std::int64_t end_ns_ = 0;
};

/// The states of all exposures.
[[nodiscard]] std::vector<CameraState> fly(const FlightParams& params);

// Checks whether a flight can be rendered over a terrain: the camera must stay above the ground and see only ground.

/// Throws std::invalid_argument that names frame, time and the parameters to change if the camera is not above the
/// highest ground, if the image's border looks less than about 14 degrees below the horizon, or if the image shows more
/// ground than fits into memory.
void check_flight(const Terrain& terrain, const CameraModel& camera, std::span<const CameraState> states);

}  // namespace ilp::world
