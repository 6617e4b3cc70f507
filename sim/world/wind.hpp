// Gusts: how the wind's speed along one horizontal axis differs from its mean.
#pragma once

#include <vector>

#include "fsw/base/rng.hpp"

namespace ilp::world {

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

}  // namespace ilp::world
