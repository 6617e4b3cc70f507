// Computes the depth of the ground in each cell of an image (seen_cells.hpp).
#pragma once

#include <array>

#include "fsw/vision/terrain/seen_cells.hpp"

namespace ilp {

/// Mean inverse depth of each cell along the optical axis, 1 / world unit of the strip, row by row; 0 for a cell
/// without depth.
using CellDepths = std::array<float, max_seen_cells>;

/// Averages the inverse depth of the pixels with sigma > 0, for each cell that has at least `min_pixels` of them.
/// Returns `invalid_argument` if the sizes differ, `image_too_large` if the cells exceed the capacity.
Status cell_depths(ImageView<const float> inverse_depth, ImageView<const float> sigma, std::int32_t min_pixels,
                   CellDepths& depths);

}  // namespace ilp
