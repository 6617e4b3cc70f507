// Connected components of pixels as a union-find forest that grows row by row.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"

namespace ilp {

/// A link >= 0 is the index of the parent. A link < 0 marks a root; it is minus the sum of its tree, so sums must stay
/// positive.
struct PixelForest {
  std::array<std::int32_t, limits::max_rectified_pixels> links;
};

/// Returns the root of a pixel's tree. Parents always have a smaller index, so the loop ends; path halving keeps it
/// short.
inline std::int32_t root_of(std::int32_t* links, std::int32_t pixel) {
  while (links[pixel] >= 0) {  // bound: the pixels; parents have smaller indices
    const std::int32_t parent = links[pixel];
    if (links[parent] >= 0) links[pixel] = links[parent];
    pixel = parent;
  }
  return pixel;
}

/// Joins the trees of pixels a and b and adds their sums. `offset` is the constant part that every sum contains once.
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
