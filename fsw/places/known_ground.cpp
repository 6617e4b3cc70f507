#include "fsw/places/known_ground.hpp"

#include <algorithm>

#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

constexpr std::uint64_t all_pixels = ~std::uint64_t{0};

// Values of the mask while known ground is taken out of it.
constexpr std::uint8_t outside = 0;
constexpr std::uint8_t is_known = 1;
constexpr std::uint8_t is_known_at_border = 2;
constexpr std::uint8_t is_new = 255;

struct CellRange {
  std::int32_t left, top, right, bottom;
};

CellRange pixels_of(std::int32_t column, std::int32_t row, std::int32_t width, std::int32_t height) {
  const std::int32_t left = column * seen_cell_px;
  const std::int32_t top = row * seen_cell_px;
  return {left, top, std::min(left + seen_cell_px, width), std::min(top + seen_cell_px, height)};
}

bool has_new(MaskView mask, const CellRange& cell) {
  for (std::int32_t y = cell.top; y < cell.bottom; ++y) {
    const std::uint8_t* row = mask.row(y);
    for (std::int32_t x = cell.left; x < cell.right; ++x) {
      if (row[x] != 0) return true;
    }
  }
  return false;
}

std::uint64_t bit_of(const CellRange& cell, std::int32_t x, std::int32_t y) {
  return std::uint64_t{1} << static_cast<unsigned>((y - cell.top) * seen_cell_px + x - cell.left);
}

/// The quality with which the other keyframe has seen what it shows at a pixel; 0 outside.
std::uint8_t quality_at(const SeenCells& other, std::int32_t width, std::int32_t height, double u, double v) {
  const double x = u + 0.5;
  const double y = v + 0.5;
  if (!(x >= 0 && y >= 0 && x < width && y < height)) return 0;
  return other.at(static_cast<std::int32_t>(x), static_cast<std::int32_t>(y));
}

/// A place in the other image; not valid where there is no ground, or behind the other camera.
struct There {
  double u = 0, v = 0;
  bool valid = false;
};

There project(const CameraModel& camera, const Similarity& other_from_camera, double x, double y,
              double inverse_depth) {
  const Vec2 normalised = normalised_from_pixel(camera, Vec2(x, y));
  const Vec3 there = other_from_camera * Vec3(Vec3(normalised.x(), normalised.y(), 1) / inverse_depth);
  if (!(there.z() > 0)) return {};
  const Vec2 pixel = pixel_from_normalised(camera, Vec2(there.x() / there.z(), there.y() / there.z()));
  return {pixel.x(), pixel.y(), true};
}

/// The corner at the top left of a cell, with the mean depth of the cells that meet there.
There corner_of(const SeenCells& seen, const CellDepths& depths, const CameraModel& camera,
                const Similarity& other_from_camera, std::int32_t column, std::int32_t row) {
  double sum = 0;
  int count = 0;
  for (std::int32_t r = std::max(row - 1, 0); r <= std::min(row, seen.rows - 1); ++r) {
    for (std::int32_t c = std::max(column - 1, 0); c <= std::min(column, seen.columns - 1); ++c) {
      const float depth =
          depths[static_cast<std::size_t>(r) * static_cast<std::size_t>(seen.columns) + static_cast<std::size_t>(c)];
      if (!(depth > 0)) continue;
      sum += static_cast<double>(depth);
      ++count;
    }
  }
  if (count == 0) return {};
  return project(camera, other_from_camera, column * seen_cell_px - 0.5, row * seen_cell_px - 0.5, sum / count);
}

struct Corners4 {
  There top_left, top_right, bottom_left, bottom_right;

  [[nodiscard]] bool valid() const {
    return top_left.valid && top_right.valid && bottom_left.valid && bottom_right.valid;
  }
};

std::uint64_t known_in_cell(MaskView mask, const CellRange& cell, const Corners4& corners, const SeenCells& other,
                            std::uint8_t now, std::int32_t finer_steps) {
  std::uint64_t bits = 0;
  for (std::int32_t y = cell.top; y < cell.bottom; ++y) {
    const double down = (y - cell.top + 0.5) / seen_cell_px;
    const double left_u = corners.top_left.u + down * (corners.bottom_left.u - corners.top_left.u);
    const double left_v = corners.top_left.v + down * (corners.bottom_left.v - corners.top_left.v);
    const double right_u = corners.top_right.u + down * (corners.bottom_right.u - corners.top_right.u);
    const double right_v = corners.top_right.v + down * (corners.bottom_right.v - corners.top_right.v);
    const std::uint8_t* row = mask.row(y);
    for (std::int32_t x = cell.left; x < cell.right; ++x) {
      if (row[x] == 0) continue;
      const double across = (x - cell.left + 0.5) / seen_cell_px;
      const double u = left_u + across * (right_u - left_u);
      const double v = left_v + across * (right_v - left_v);
      const std::uint8_t quality = quality_at(other, mask.width, mask.height, u, v);
      if (at_least_as_well(quality, now, finer_steps)) bits |= bit_of(cell, x, y);
    }
  }
  return bits;
}

/// Marks known ground within `border_px` of new ground along one line of pixels.
template <typename At>
void mark_border(std::int32_t length, std::int32_t border_px, At at) {
  std::int32_t near = 0;
  for (std::int32_t i = 0; i < length; ++i) {
    near = at(i) == is_new ? border_px + 1 : near - 1;
    if (near > 0 && at(i) == is_known) at(i) = is_known_at_border;
  }
  near = 0;
  for (std::int32_t i = length - 1; i >= 0; --i) {
    near = at(i) == is_new ? border_px + 1 : near - 1;
    if (near > 0 && at(i) == is_known) at(i) = is_known_at_border;
  }
}

}  // namespace

void mark_known(MaskView mask, const SeenCells& seen, const CellDepths& depths, const CameraModel& camera,
                const Similarity& other_from_camera, const SeenCells& other, std::int32_t finer_steps,
                KnownGround& known) {
  std::size_t index = 0;
  for (std::int32_t row = 0; row < seen.rows; ++row) {
    for (std::int32_t column = 0; column < seen.columns; ++column, ++index) {
      if (known[index] == all_pixels || seen.quality[index] == 0) continue;
      const CellRange cell = pixels_of(column, row, mask.width, mask.height);
      if (!has_new(mask, cell)) continue;
      const auto corner = [&](std::int32_t c, std::int32_t r) {
        return corner_of(seen, depths, camera, other_from_camera, c, r);
      };
      const Corners4 corners{corner(column, row), corner(column + 1, row), corner(column, row + 1),
                             corner(column + 1, row + 1)};
      if (!corners.valid()) continue;
      const std::uint8_t now = in_other_unit(seen.quality[index], other_from_camera.scale);
      known[index] |= known_in_cell(mask, cell, corners, other, now, finer_steps);
    }
  }
}

void mark_known_over_plane(MaskView mask, const Mat3& other_from_keyframe, const SeenCells& other, KnownGround& known) {
  std::size_t index = 0;
  for (std::int32_t row = 0; row < other.rows; ++row) {
    for (std::int32_t column = 0; column < other.columns; ++column, ++index) {
      const CellRange cell = pixels_of(column, row, mask.width, mask.height);
      for (std::int32_t y = cell.top; y < cell.bottom; ++y) {
        for (std::int32_t x = cell.left; x < cell.right; ++x) {
          if (mask.at(x, y) == 0) continue;
          const Vec3 there = other_from_keyframe * Vec3(x, y, 1);
          if (!(there.z() > 0)) continue;
          const double u = there.x() / there.z();
          const double v = there.y() / there.z();
          if (quality_at(other, mask.width, mask.height, u, v) != 0) known[index] |= bit_of(cell, x, y);
        }
      }
    }
  }
}

std::uint32_t take_known(const KnownGround& known, std::int32_t border_px, const ImageView<std::uint8_t>& mask) {
  const std::int32_t columns = seen_cells_side(mask.width);
  for (std::int32_t y = 0; y < mask.height; ++y) {
    for (std::int32_t x = 0; x < mask.width; ++x) {
      if (mask.at(x, y) == outside) continue;
      const std::int32_t column = x / seen_cell_px;
      const std::int32_t row = y / seen_cell_px;
      const std::uint64_t bits =
          known[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)];
      const std::uint64_t bit = bit_of(pixels_of(column, row, mask.width, mask.height), x, y);
      mask.at(x, y) = (bits & bit) != 0 ? is_known : is_new;
    }
  }
  for (std::int32_t y = 0; y < mask.height; ++y) {
    mark_border(mask.width, border_px, [&](std::int32_t x) -> std::uint8_t& { return mask.at(x, y); });
  }
  for (std::int32_t x = 0; x < mask.width; ++x) {
    mark_border(mask.height, border_px, [&](std::int32_t y) -> std::uint8_t& { return mask.at(x, y); });
  }
  std::uint32_t taken = 0;
  for (std::int32_t y = 0; y < mask.height; ++y) {
    for (std::int32_t x = 0; x < mask.width; ++x) {
      std::uint8_t& pixel = mask.at(x, y);
      taken += pixel == is_known ? 1U : 0U;
      pixel = pixel == is_known || pixel == outside ? outside : is_new;
    }
  }
  return taken;
}

}  // namespace ilp
