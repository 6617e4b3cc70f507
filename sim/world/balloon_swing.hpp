// A gondola on its tether below a balloon that gusts push: how both move along one horizontal axis.
#pragma once

#include <functional>
#include <vector>

#include "fsw/base/rng.hpp"

namespace ilp::world {

// Gusts: how the wind's speed along one horizontal axis differs from its mean.

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

/// An Ornstein-Uhlenbeck process in its steady state: normal with the given standard deviation, correlation
/// exp(-t / time constant) (G. E. Uhlenbeck, L. S. Ornstein, 1930); it is also the longitudinal gust of the Dryden
/// model (MIL-F-8785C). Sampled exactly every hundredth of the time constant, linear between.
class Gusts {
 public:
  static constexpr double max_steps = 4e6;

  /// Computes the wind from time 0 to `duration_s`. A longer duration does not change the beginning.
  /// std::invalid_argument when it takes more than `max_steps`.
  Gusts(double deviation_m_s, double time_constant_s, double duration_s, Normal normal);

  /// m/s; the last value beyond the end, the first before the beginning.
  [[nodiscard]] double at(double time_s) const;

 private:
  double step_s_;
  std::vector<double> speed_m_s_;
};

/// Linear, damped: angle'' = -w^2 angle - 2 damping w angle' - (acceleration of the pivot) / length, w^2 = g / length.
struct PendulumParams {
  double length_m = 15;
  double gravity_m_s2 = 3.73;
  double damping = 0;        ///< ratio to critical damping
  double angle_rad = 0;      ///< at time 0; positive: the gondola is ahead of the pivot on this axis
  double rate_rad_s = 0;     ///< at time 0
  double balloon_lag_s = 1;  ///< time constant with which the pivot takes on the speed of a gust
};

/// What moves the pivot besides its lag, as functions of time in seconds.
struct PivotDrive {
  std::function<double(double)> gust_m_s;
  std::function<double(double)> acceleration_m_s2;  ///< of the path that the pivot follows without gusts
};

struct PendulumState {
  double shift_m = 0;  ///< of the pivot off its path, by gusts
  double speed_m_s = 0;
  double angle_rad = 0;
  double rate_rad_s = 0;
};

/// Integrated once (Runge-Kutta of fourth order, at least 64 steps per period), then a smooth function of time: cubic
/// between the steps, rates are the derivatives of the values.
class Pendulum {
 public:
  static constexpr double max_steps = 4e6;

  /// Computes the swing from time 0 to `duration_s`. std::invalid_argument when that takes more than `max_steps`.
  Pendulum(const PendulumParams& params, const PivotDrive& drive, double duration_s);

  /// `time_s` from 0 to the duration.
  [[nodiscard]] PendulumState at(double time_s) const;
  [[nodiscard]] double largest_angle_rad() const;

 private:
  double step_s_;
  std::vector<PendulumState> states_;
};

}  // namespace ilp::world
