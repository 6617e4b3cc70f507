// Scratch of estimate_two_view: keep it static, it is too large for a stack.
#pragma once

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"

namespace ilp {

struct TwoViewWorkspace {
  FixedVector<double, limits::max_matches> scratch;
};

}  // namespace ilp
