// Corners and matches: what the feature kernels give to the geometry kernels.
#pragma once

#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"

namespace ilp {

/// A corner with sub-pixel position in the real (distorted) image.
struct Corner {
  float x = 0;         ///< px
  float y = 0;         ///< px
  float response = 0;  ///< Harris response divided by the strongest one of the image
};
using Corners = FixedVector<Corner, limits::max_corners>;

/// Corner `a` of one image is corner `b` of the other.
struct Match {
  std::uint16_t a = 0;
  std::uint16_t b = 0;
  float score = 0;  ///< normalised cross correlation, -1 to 1
  /// Position of corner a in image b, px in the real (distorted) image, accurate to a few hundredths of a pixel. Corner
  /// b was detected separately and lies within a few pixels of this position. A track that continues from image b
  /// starts at this position, not at corner b.
  float xb = 0, yb = 0;
};
using Matches = FixedVector<Match, limits::max_matches>;

}  // namespace ilp
