// Simulates the motion of a balloon in gusts, and the swing of the gondola below it, along one horizontal axis.
#pragma once

#include <functional>
#include <vector>

#include "fsw/base/rng.hpp"

namespace ilp::world {

// Gusts: deviations of the wind's speed from its mean along one horizontal axis.

/// Standard normal numbers in pairs (G. E. P. Box, M. E. Muller, 1958), the same on every machine.
class Normal {
 public:
  explicit Normal(const Rng& rng) : rng_(rng) {}
  double next();

 private:
  Rng rng_;
  double spare_ = 0;
  bool has_spare_ = false;
};

/// A stationary Ornstein-Uhlenbeck process (G. E. Uhlenbeck, L. S. Ornstein, 1930): normal with the given standard
/// deviation and the correlation exp(-t / time constant). It equals the longitudinal gust of the Dryden model
/// (MIL-F-8785C). It is sampled exactly at steps of a hundredth of the time constant, with linear interpolation.
class Gusts {
 public:
  static constexpr double max_steps = 4e6;

  /// Computes gusts from time 0 to `duration_s`. A longer duration does not change the beginning. Throws
  /// std::invalid_argument if more than `max_steps` steps are needed.
  Gusts(double deviation_m_s, double time_constant_s, double duration_s, Normal normal);

  /// Gust at a time, m/s. Times outside the duration give the first or the last value.
  [[nodiscard]] double at(double time_s) const;

 private:
  double step_s_;
  std::vector<double> speed_m_s_;
};

/// A linear damped pendulum: angle'' = -w^2 angle - 2 damping w angle' - (acceleration of the pivot) / length, w^2 =
/// gravity / length.
struct PendulumParams {
  double length_m = 15;
  double gravity_m_s2 = 3.73;
  double damping = 0;        ///< ratio to critical damping
  double angle_rad = 0;      ///< at time 0; positive: the gondola is ahead of the pivot along the axis
  double rate_rad_s = 0;     ///< at time 0
  double balloon_lag_s = 1;  ///< time constant with which the pivot takes on the speed of a gust
};

/// Motion of the pivot, as functions of time in seconds.
struct PivotDrive {
  std::function<double(double)> gust_m_s;
  std::function<double(double)> acceleration_m_s2;  ///< of the pivot's path without gusts
};

struct PendulumState {
  double shift_m = 0;     ///< displacement of the pivot from its path by gusts
  double speed_m_s = 0;   ///< rate of shift_m
  double angle_rad = 0;   ///< of the pendulum
  double rate_rad_s = 0;  ///< rate of angle_rad
};

/// The motion is integrated once, by a fourth-order Runge-Kutta method with at least 64 steps per period. Between the
/// steps it is a cubic whose derivatives are the rates.
class Pendulum {
 public:
  static constexpr double max_steps = 4e6;

  /// Computes the motion from time 0 to `duration_s`. Throws std::invalid_argument if more than `max_steps` steps are
  /// needed.
  Pendulum(const PendulumParams& params, const PivotDrive& drive, double duration_s);

  /// The state at `time_s`, from 0 to the duration.
  [[nodiscard]] PendulumState at(double time_s) const;
  [[nodiscard]] double largest_angle_rad() const;

 private:
  double step_s_;
  std::vector<PendulumState> states_;
};

}  // namespace ilp::world
