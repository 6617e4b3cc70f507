#include "sim/world/balloon_swing.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

#include "fsw/base/math.hpp"
#include "sim/world/parameter.hpp"

namespace ilp::world {
namespace {

PendulumState moved(const PendulumState& state, const PendulumState& rates, double dt) {
  return {state.shift_m + dt * rates.shift_m, state.speed_m_s + dt * rates.speed_m_s,
          state.angle_rad + dt * rates.angle_rad, state.rate_rad_s + dt * rates.rate_rad_s};
}

PendulumState rates(const PendulumParams& p, const PivotDrive& drive, const PendulumState& state, double time_s) {
  const double square = p.gravity_m_s2 / p.length_m;
  const double gust = (drive.gust_m_s(time_s) - state.speed_m_s) / p.balloon_lag_s;
  const double pivot = gust + drive.acceleration_m_s2(time_s);
  return {state.speed_m_s, gust, state.rate_rad_s,
          -square * state.angle_rad - 2 * p.damping * std::sqrt(square) * state.rate_rad_s - pivot / p.length_m};
}

PendulumState runge_kutta(const PendulumParams& p, const PivotDrive& drive, const PendulumState& state, double time_s,
                          double dt) {
  const PendulumState k1 = rates(p, drive, state, time_s);
  const PendulumState k2 = rates(p, drive, moved(state, k1, 0.5 * dt), time_s + 0.5 * dt);
  const PendulumState k3 = rates(p, drive, moved(state, k2, 0.5 * dt), time_s + 0.5 * dt);
  const PendulumState k4 = rates(p, drive, moved(state, k3, dt), time_s + dt);
  return moved(moved(moved(moved(state, k1, dt / 6), k2, dt / 3), k3, dt / 3), k4, dt / 6);
}

struct Hermite {
  double value, rate;
};

Hermite between(double y0, double rate0, double y1, double rate1, double u, double dt) {
  const double rise = y1 - y0;
  const double a = dt * rate0 - rise;
  const double b = rise - dt * rate1;
  const double bend = a * (1 - u) + b * u;
  return {y0 + u * rise + u * (1 - u) * bend, (rise + (1 - 2 * u) * bend + u * (1 - u) * (b - a)) / dt};
}

}  // namespace

double Normal::next() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const double radius = std::sqrt(-2 * det_log(1 - rng_.uniform()));
  const double angle = 2 * pi * rng_.uniform();
  spare_ = radius * det_sin(angle);
  has_spare_ = true;
  return radius * det_cos(angle);
}

Gusts::Gusts(double deviation_m_s, double time_constant_s, double duration_s, Normal normal)
    : step_s_(time_constant_s / 100) {
  const double exact_steps = std::ceil(duration_s / step_s_);
  if (exact_steps > max_steps) {
    throw std::invalid_argument("[flight] gust_time_s = " + number_text(time_constant_s) +
                                ": gusts as brief as this cannot be followed over " + number_text(duration_s) +
                                " s, expected at most " + number_text(std::floor(max_steps * step_s_)) + " s");
  }
  const auto steps = static_cast<std::size_t>(exact_steps);
  const double decay = det_exp(-step_s_ / time_constant_s);
  const double kick = std::sqrt(1 - decay * decay) * deviation_m_s;
  speed_m_s_.reserve(steps + 1);
  speed_m_s_.push_back(deviation_m_s * normal.next());
  for (std::size_t k = 0; k < steps; ++k) speed_m_s_.push_back(decay * speed_m_s_.back() + kick * normal.next());
}

double Gusts::at(double time_s) const {
  const double place = time_s / step_s_;
  if (!(place > 0)) return speed_m_s_.front();
  if (place >= static_cast<double>(speed_m_s_.size() - 1)) return speed_m_s_.back();
  const auto k = static_cast<std::size_t>(place);
  return speed_m_s_[k] + (place - static_cast<double>(k)) * (speed_m_s_[k + 1] - speed_m_s_[k]);
}

Pendulum::Pendulum(const PendulumParams& params, const PivotDrive& drive, double duration_s)
    : step_s_(std::min(2 * pi * std::sqrt(params.length_m / params.gravity_m_s2) / 64, params.balloon_lag_s / 4)) {
  const double steps = std::ceil(duration_s / step_s_);
  if (steps > max_steps) {
    throw std::invalid_argument("[flight] suspension_m = " + number_text(params.length_m) +
                                ": a pendulum as short as this cannot be followed over " + number_text(duration_s) +
                                " s, expected at most " + number_text(std::floor(max_steps * step_s_)) + " s");
  }
  states_.reserve(static_cast<std::size_t>(steps) + 1);
  states_.push_back({0, 0, params.angle_rad, params.rate_rad_s});
  for (std::size_t k = 0; k < static_cast<std::size_t>(steps); ++k) {
    states_.push_back(runge_kutta(params, drive, states_.back(), static_cast<double>(k) * step_s_, step_s_));
  }
}

PendulumState Pendulum::at(double time_s) const {
  if (states_.size() < 2) return states_.front();
  const double place = std::clamp(time_s / step_s_, 0.0, static_cast<double>(states_.size() - 1));
  const std::size_t k = std::min(static_cast<std::size_t>(place), states_.size() - 2);
  const double u = place - static_cast<double>(k);
  const PendulumState& a = states_[k];
  const PendulumState& b = states_[k + 1];
  const Hermite shift = between(a.shift_m, a.speed_m_s, b.shift_m, b.speed_m_s, u, step_s_);
  const Hermite angle = between(a.angle_rad, a.rate_rad_s, b.angle_rad, b.rate_rad_s, u, step_s_);
  return {shift.value, shift.rate, angle.value, angle.rate};
}

double Pendulum::largest_angle_rad() const {
  double largest = 0;
  for (const PendulumState& state : states_) largest = std::max(largest, std::fabs(state.angle_rad));
  return largest;
}

}  // namespace ilp::world
