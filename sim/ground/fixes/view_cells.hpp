// What the flight knew of a keyframe's depths, from what came down: a depth product has the ground that is new in its
// keyframe only, and the rest is that of the keyframes before.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::fixes {

/// Mean inverse depths of cells of seen_cell_px pixels, row by row, along the optical axis; 0: not known.
class ViewCells {
 public:
  /// `rasters` are those of the keyframe, which has a pose; its strip's keyframes come in order. Cells that its own
  /// product does not have take the ground of the keyframes before, where that lies in them.
  [[nodiscard]] std::vector<float> add(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters);

 private:
  struct Ground {
    std::int64_t strip_id = 0;
    std::vector<Vec3> points;  ///< in the strip's world
  };
  std::deque<Ground> before_;
};

}  // namespace ilp::fixes
