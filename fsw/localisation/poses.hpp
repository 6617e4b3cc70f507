// Small conversions of poses that the parts of the stage share.
#pragma once

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {

[[nodiscard]] inline Vec3 vector_of(const double (&v)[3]) {
  return {v[0], v[1], v[2]};
}
[[nodiscard]] constexpr double square(double x) {
  return x * x;
}

}  // namespace ilp
