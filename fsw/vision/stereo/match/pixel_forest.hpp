// Connected pixels, as a forest that grows while rows come in order.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"

namespace ilp {

/// A link >= 0 is the index of a parent; a link < 0 is a root with minus the sum of its tree, so that a sum must stay
/// positive.
struct PixelForest {
  std::array<std::int32_t, limits::max_rectified_pixels> links;
};

/// Parents always have a smaller index, so the walk ends; halving keeps it short.
inline std::int32_t root_of(std::int32_t* links, std::int32_t pixel) {
  while (links[pixel] >= 0) {  // bound: the pixels; parents have smaller indices
    const std::int32_t parent = links[pixel];
    if (links[parent] >= 0) links[pixel] = links[parent];
    pixel = parent;
  }
  return pixel;
}

/// `offset` is what every sum has besides its pixels'.
inline void join(std::int32_t* links, std::int32_t a, std::int32_t b, std::int32_t offset) {
  a = root_of(links, a);
  b = root_of(links, b);
  if (a == b) return;
  const std::int32_t keep = a < b ? a : b;
  const std::int32_t merge = a < b ? b : a;
  links[keep] += links[merge] + offset;
  links[merge] = keep;
}

}  // namespace ilp
