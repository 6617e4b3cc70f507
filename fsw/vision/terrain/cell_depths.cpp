#include "fsw/vision/terrain/cell_depths.hpp"

#include <algorithm>

#include "fsw/base/argument.hpp"

namespace ilp {

Status cell_depths(ImageView<const float> inverse_depth, ImageView<const float> sigma, std::int32_t min_pixels,
                   CellDepths& depths) {
  if (inverse_depth.width != sigma.width || inverse_depth.height != sigma.height) {
    return out_of_range(Argument::depth_size, sigma.width);
  }
  const std::int32_t columns = seen_cells_side(sigma.width);
  const std::int32_t rows = seen_cells_side(sigma.height);
  if (static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows) > depths.size()) {
    return {StatusCode::image_too_large, sigma.width, sigma.height};
  }
  std::size_t cell = 0;
  for (std::int32_t row = 0; row < rows; ++row) {
    for (std::int32_t column = 0; column < columns; ++column, ++cell) {
      const std::int32_t right = std::min((column + 1) * seen_cell_px, sigma.width);
      const std::int32_t bottom = std::min((row + 1) * seen_cell_px, sigma.height);
      float sum = 0;
      std::int32_t count = 0;
      for (std::int32_t y = row * seen_cell_px; y < bottom; ++y) {
        for (std::int32_t x = column * seen_cell_px; x < right; ++x) {
          if (!(sigma.at(x, y) > 0)) continue;
          sum += inverse_depth.at(x, y);
          ++count;
        }
      }
      depths[cell] = count >= min_pixels && count > 0 ? sum / static_cast<float>(count) : 0.0F;
    }
  }
  return {};
}

}  // namespace ilp
