// The median of a list that may be reordered.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

namespace ilp {

/// Returns the median; for an even number of values, the larger one of the two in the middle. `values` must not be
/// empty and is reordered.
template <typename Value>
[[nodiscard]] Value upper_median(std::span<Value> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace ilp
