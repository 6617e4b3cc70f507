// The depth of the ground in each cell of an image (seen_cells.hpp).
#pragma once

#include <array>

#include "fsw/vision/terrain/seen_cells.hpp"

namespace ilp {

/// Mean inverse depths of cells, 1 / strip unit, row by row; 0 where there is none.
using CellDepths = std::array<float, max_seen_cells>;

/// The mean over the pixels with sigma > 0 of every cell that has at least `min_pixels` of them, along the optical
/// axis. `invalid_argument` when the sizes differ, `image_too_large`.
Status cell_depths(ImageView<const float> inverse_depth, ImageView<const float> sigma, std::int32_t min_pixels,
                   CellDepths& depths);

}  // namespace ilp
