// A coarse map of the ground that the flight has reconstructed so far (decisions.md, 8).
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {

inline constexpr std::int32_t coverage_grid_side = 256;

/// Square cells on the world's horizontal plane; cell (column, row) spans
/// origin + [column, column + 1) * cell, origin + [row, row + 1) * cell. Trivially copyable.
struct CoverageGrid {
  double origin_x = 0, origin_y = 0;  ///< world units
  double cell = 0;                    ///< world units
  std::array<std::uint8_t, static_cast<std::size_t>(coverage_grid_side) * coverage_grid_side>
      images{};  ///< that saw the cell, up to 255

  [[nodiscard]] std::uint8_t at(std::int32_t column, std::int32_t row) const {
    const std::int32_t cell_index = row * coverage_grid_side + column;
    return images[static_cast<std::size_t>(cell_index)];
  }
};

/// An empty grid centred on (x, y). `invalid_argument` for a cell that is not positive and finite.
Status clear_grid(double x, double y, double cell, CoverageGrid& grid);

struct GridUpdate {
  std::uint32_t cells = 0;      ///< that the image saw
  std::uint32_t new_cells = 0;  ///< of these, seen by none before
  std::uint32_t outside = 0;    ///< sampled points beyond the grid
};

struct CoverageGridWorkspace {
  std::array<std::uint8_t, static_cast<std::size_t>(coverage_grid_side) * coverage_grid_side> seen;
  std::array<double, static_cast<std::size_t>(limits::max_image_width)> ray_x, ray_y;
};

/// Adds one image: every `stride`-th pixel with depth (sigma > 0), lifted to the world. `invalid_argument`: a = 1
/// sizes, 2 stride below 1, 3 the grid was never cleared.
Status add_to_grid(const CameraModel& camera, const RigidTransform& cam_from_world,
                   ImageView<const float> inverse_depth, ImageView<const float> sigma, std::int32_t stride,
                   CoverageGridWorkspace& workspace, CoverageGrid& grid, GridUpdate& update);

}  // namespace ilp
