// A gondola on its tether below a balloon that gusts push: how both move along one horizontal axis.
#pragma once

#include <functional>
#include <vector>

namespace ilp::world {

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
