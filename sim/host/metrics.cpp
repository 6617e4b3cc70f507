#include "sim/host/metrics.hpp"

#include <cmath>

#include "sim/host/text_format.hpp"

namespace ilp::host {

std::span<const Metric> metrics() {
  static constexpr Metric table[] = {
#define ILP_METRIC(key, group, label, better, ideal) {key, group, label, ideal},
#include "sim/host/metrics.inc"
#undef ILP_METRIC
  };
  return table;
}

std::string score_text(double value) {
  return value == std::floor(value) ? fixed(value, 0) : brief(value);
}

}  // namespace ilp::host
