// Reconstructs the depths that the flight knew of a keyframe from downlinked products. A depth product contains only
// the ground that is new in its keyframe; the rest comes from the keyframes before.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::fixes {

/// Computes mean inverse depths (along the optical axis) of image cells of seen_cell_px pixels a side.
class ViewCells {
 public:
  /// Returns the cells of a keyframe row by row; 0: unknown. Cells without depths in the keyframe's own product use the
  /// ground of the 12 keyframes before that projects into them. The keyframe must have a pose, `rasters` are its
  /// decoded rasters, and the keyframes of a strip must be added in their order.
  [[nodiscard]] std::vector<float> add(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters);

 private:
  struct Ground {
    std::int64_t strip_id = 0;
    std::vector<Vec3> points;  ///< in the strip's world
  };
  std::deque<Ground> before_;
};

}  // namespace ilp::fixes
