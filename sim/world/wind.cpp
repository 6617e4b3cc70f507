#include "sim/world/wind.hpp"

#include <cmath>
#include <cstddef>
#include <stdexcept>

#include "fsw/base/math.hpp"
#include "sim/world/parameter.hpp"

namespace ilp::world {

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

}  // namespace ilp::world
