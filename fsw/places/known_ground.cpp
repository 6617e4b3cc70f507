#include "fsw/places/known_ground.hpp"

#include <algorithm>

#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

constexpr std::uint64_t all_pixels = ~std::uint64_t{0};

/// A rest of a mask that is smaller than four cells is not worth a product: image and depth take 3 KB at least, 12
/// bytes for each of its pixels.
constexpr std::uint32_t smallest_rest = 4 * seen_cell_px * seen_cell_px;

// Values of the mask while known ground is taken out of it.
constexpr std::uint8_t outside = 0;
constexpr std::uint8_t is_known = 1;
constexpr std::uint8_t is_known_at_border = 2;
constexpr std::uint8_t is_thin = 3, is_sliver = 4;
constexpr std::uint8_t is_new = 128;
// Added to is_new by the search for squares of new ground: the last pixel of a row of it, the last row of a square, a
// column of a square, any pixel of a square.
constexpr std::uint8_t ends_row = 64, ends_square = 32, in_column = 16, in_square = 8;

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

/// A place in the other image, and how many times as far away it is there; not valid where there is no ground, or
/// behind the other camera.
struct There {
  double u = 0, v = 0, farther = 0;
  bool valid = false;
};

There between(const There& a, const There& b, double share) {
  return {a.u + share * (b.u - a.u), a.v + share * (b.v - a.v), a.farther + share * (b.farther - a.farther), true};
}

There project(const CameraModel& camera, const Similarity& other_from_camera, double x, double y,
              double inverse_depth) {
  const Vec2 normalised = normalised_from_pixel(camera, Vec2(x, y));
  const Vec3 there = other_from_camera * Vec3(Vec3(normalised.x(), normalised.y(), 1) / inverse_depth);
  if (!(there.z() > 0)) return {};
  const Vec2 pixel = pixel_from_normalised(camera, Vec2(there.x() / there.z(), there.y() / there.z()));
  return {pixel.x(), pixel.y(), there.z() * inverse_depth / other_from_camera.scale, true};
}

/// The mean inverse depth of the cells that are at most `reach` away from the corner at the top left of a cell; 0 if
/// none has a depth.
double depth_about(const NewView& view, std::int32_t column, std::int32_t row, std::int32_t reach) {
  const SeenCells& seen = view.seen;
  double sum = 0;
  int count = 0;
  for (std::int32_t r = std::max(row - reach, 0); r < std::min(row + reach, seen.rows); ++r) {
    for (std::int32_t c = std::max(column - reach, 0); c < std::min(column + reach, seen.columns); ++c) {
      const float depth = view.depths[static_cast<std::size_t>(r) * static_cast<std::size_t>(seen.columns) +
                                      static_cast<std::size_t>(c)];
      if (!(depth > 0)) continue;
      sum += static_cast<double>(depth);
      ++count;
    }
  }
  return count == 0 ? 0 : sum / count;
}

/// The corner at the top left of a cell.
There corner_of(const NewView& view, const Similarity& other_from_camera, std::int32_t column, std::int32_t row) {
  double depth = depth_about(view, column, row, 1);
  if (!(depth > 0)) depth = depth_about(view, column, row, 2);
  if (!(depth > 0)) return {};
  return project(view.camera, other_from_camera, column * seen_cell_px - 0.5, row * seen_cell_px - 0.5, depth);
}

struct CellCorners {
  There top_left, top_right, bottom_left, bottom_right;

  [[nodiscard]] bool valid() const {
    return top_left.valid && top_right.valid && bottom_left.valid && bottom_right.valid;
  }
  [[nodiscard]] bool meets(std::int32_t width, std::int32_t height) const {
    const auto [left, right] = std::minmax({top_left.u, top_right.u, bottom_left.u, bottom_right.u});
    const auto [top, bottom] = std::minmax({top_left.v, top_right.v, bottom_left.v, bottom_right.v});
    return right > -1 && bottom > -1 && left < width && top < height;
  }
};

CellCorners corners_of(const NewView& view, const Similarity& other_from_camera, std::int32_t column,
                       std::int32_t row) {
  const auto corner = [&](std::int32_t c, std::int32_t r) { return corner_of(view, other_from_camera, c, r); };
  return {corner(column, row), corner(column + 1, row), corner(column, row + 1), corner(column + 1, row + 1)};
}

/// The earlier view has seen all ground that may be the one it shows there.
bool sees_about(const EarlierView& earlier, const MaskView& mask, const There& there) {
  const double e = earlier.error_px;
  const auto seen = [&](double u, double v) {
    return quality_at(earlier.seen, mask.width, mask.height, there.u + u, there.v + v) != 0;
  };
  return !(e > 0) || (seen(-e, -e) && seen(e, -e) && seen(-e, e) && seen(e, e));
}

std::uint64_t known_in_cell(const NewView& view, const CellRange& cell, const CellCorners& corners,
                            const EarlierView& earlier, std::uint8_t now, double claim_ratio) {
  const MaskView& mask = view.mask;
  std::uint64_t bits = 0;
  for (std::int32_t y = cell.top; y < cell.bottom; ++y) {
    const double down = (y - cell.top + 0.5) / seen_cell_px;
    const There left = between(corners.top_left, corners.bottom_left, down);
    const There right = between(corners.top_right, corners.bottom_right, down);
    const std::uint8_t* row = mask.row(y);
    for (std::int32_t x = cell.left; x < cell.right; ++x) {
      if (row[x] == 0) continue;
      const There there = between(left, right, (x - cell.left + 0.5) / seen_cell_px);
      const std::uint8_t quality = quality_at(earlier.seen, mask.width, mask.height, there.u, there.v);
      if (at_least_as_well(quality, now, there.farther, claim_ratio) && sees_about(earlier, mask, there)) {
        bits |= bit_of(cell, x, y);
      }
    }
  }
  return bits;
}

/// Adds `to` where `side` pixels in a row, this one last, have `from`.
template <typename At>
void mark_ends(std::int32_t length, std::int32_t side, std::uint8_t from, std::uint8_t to, At at) {
  std::int32_t run = 0;
  for (std::int32_t i = 0; i < length; ++i) {
    run = (at(i) & from) != 0 ? run + 1 : 0;
    if (run >= side) at(i) = static_cast<std::uint8_t>(at(i) | to);
  }
}

/// Adds `to` to the `side` pixels that end in one with `from`.
template <typename At>
void mark_back(std::int32_t length, std::int32_t side, std::uint8_t from, std::uint8_t to, At at) {
  std::int32_t left = 0;
  for (std::int32_t i = length - 1; i >= 0; --i) {
    left = (at(i) & from) != 0 ? side : left - 1;
    if (left > 0) at(i) = static_cast<std::uint8_t>(at(i) | to);
  }
}

template <typename Each>
void each_row(const ImageView<std::uint8_t>& mask, Each each) {
  for (std::int32_t y = 0; y < mask.height; ++y) {
    each(mask.width, [&](std::int32_t x) -> std::uint8_t& { return mask.at(x, y); });
  }
}

template <typename Each>
void each_column(const ImageView<std::uint8_t>& mask, Each each) {
  for (std::int32_t x = 0; x < mask.width; ++x) {
    each(mask.height, [&](std::int32_t y) -> std::uint8_t& { return mask.at(x, y); });
  }
}

/// Marks what has `from` within `reach` pixels of what has `beside`, along one line of pixels.
template <typename At>
void mark_near(std::int32_t length, std::int32_t reach, std::uint8_t beside, std::uint8_t from, std::uint8_t to,
               At at) {
  const auto forth = [&](std::int32_t i, std::int32_t& near) {
    near = at(i) == beside ? reach + 1 : near - 1;
    if (near > 0 && at(i) == from) at(i) = to;
  };
  std::int32_t near = 0;
  for (std::int32_t i = 0; i < length; ++i) forth(i, near);
  near = 0;
  for (std::int32_t i = length - 1; i >= 0; --i) forth(i, near);
}

void mark_near(const ImageView<std::uint8_t>& mask, std::int32_t reach, std::uint8_t beside, std::uint8_t from,
               std::uint8_t to) {
  const auto mark = [&](std::int32_t length, auto at) { mark_near(length, reach, beside, from, to, at); };
  each_row(mask, mark);
  each_column(mask, mark);
}

// New ground beside known ground that no square of new ground with sides of `side` px contains counts as known: these
// three in this order.
void find_squares(const ImageView<std::uint8_t>& mask, std::int32_t side) {
  each_row(mask, [&](std::int32_t length, auto at) { mark_ends(length, side, is_new, ends_row, at); });
  each_column(mask, [&](std::int32_t length, auto at) { mark_ends(length, side, ends_row, ends_square, at); });
}

void find_thin_ground(const ImageView<std::uint8_t>& mask, std::int32_t side) {
  each_column(mask, [&](std::int32_t length, auto at) { mark_back(length, side, ends_square, in_column, at); });
  each_row(mask, [&](std::int32_t length, auto at) { mark_back(length, side, in_column, in_square, at); });
  for (std::size_t i = 0; i < mask.area(); ++i) {
    if ((mask.data[i] & is_new) != 0) mask.data[i] = (mask.data[i] & in_square) != 0 ? is_new : is_thin;
  }
}

void know_slivers(const ImageView<std::uint8_t>& mask, std::int32_t side) {
  mark_near(mask, side, is_known, is_thin, is_sliver);
  for (std::size_t i = 0; i < mask.area(); ++i) {
    std::uint8_t& pixel = mask.data[i];
    if (pixel == is_thin) pixel = is_new;
    if (pixel == is_sliver) pixel = is_known;
  }
}

/// Returns whether any ground is known.
bool classify(const KnownGround& known, const ImageView<std::uint8_t>& mask) {
  const std::int32_t columns = seen_cells_side(mask.width);
  bool any = false;
  for (std::int32_t y = 0; y < mask.height; ++y) {
    for (std::int32_t x = 0; x < mask.width; ++x) {
      if (mask.at(x, y) == outside) continue;
      const std::int32_t column = x / seen_cell_px;
      const std::int32_t row = y / seen_cell_px;
      const std::uint64_t bits =
          known[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)];
      const bool taken = (bits & bit_of(pixels_of(column, row, mask.width, mask.height), x, y)) != 0;
      mask.at(x, y) = taken ? is_known : is_new;
      any = any || taken;
    }
  }
  return any;
}

}  // namespace

void mark_known(const NewView& view, const EarlierView& earlier, double claim_ratio, KnownGround& known) {
  const MaskView& mask = view.mask;
  std::size_t index = 0;
  for (std::int32_t row = 0; row < view.seen.rows; ++row) {
    for (std::int32_t column = 0; column < view.seen.columns; ++column, ++index) {
      if (known[index] == all_pixels) continue;
      const CellRange cell = pixels_of(column, row, mask.width, mask.height);
      if (!has_new(mask, cell)) continue;
      const CellCorners corners = corners_of(view, earlier.other_from_camera, column, row);
      if (!corners.valid() || !corners.meets(mask.width, mask.height)) continue;
      known[index] |= known_in_cell(view, cell, corners, earlier, view.seen.quality[index], claim_ratio);
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

bool take_known_slice(const KnownGround& known, std::int32_t sliver_px, std::int32_t border_px,
                      const ImageView<std::uint8_t>& mask, std::size_t part, std::uint32_t& taken) {
  taken = 0;
  switch (part) {
    case 0:
      if (classify(known, mask)) return true;
      for (std::size_t i = 0; i < mask.area(); ++i) mask.data[i] = mask.data[i] == outside ? 0 : 255;
      return false;
    case 1:
      find_squares(mask, sliver_px);
      return true;
    case 2:
      find_thin_ground(mask, sliver_px);
      return true;
    case 3:
      know_slivers(mask, sliver_px);
      return true;
    case 4:
      mark_near(mask, border_px, is_new, is_known, is_known_at_border);
      return true;
    default:
      break;
  }
  std::uint32_t left = 0;
  for (std::size_t i = 0; i < mask.area(); ++i) {
    std::uint8_t& pixel = mask.data[i];
    taken += pixel == is_known ? 1U : 0U;
    pixel = pixel == is_known || pixel == outside ? 0 : 255;
    left += pixel != 0 ? 1U : 0U;
  }
  if (left >= smallest_rest) return false;
  std::fill_n(mask.data, mask.area(), std::uint8_t{0});
  taken += left;
  return false;
}

}  // namespace ilp
