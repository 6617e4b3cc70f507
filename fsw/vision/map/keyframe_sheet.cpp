#include "fsw/vision/map/keyframe_sheet.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/map/map_light.hpp"

namespace ilp {
namespace {

constexpr std::int32_t sixteenths = 16;
constexpr std::int32_t most_count = 255;
constexpr std::int32_t points_at_once = 64;
constexpr double widest_cell_px = 256;  // image px in a cell
constexpr double shadow_share = 0.6;    // of the mean grey; the sky's light alone is less
constexpr double beyond_border = 1.05;  // of the farthest corner, squared: lenses bend back farther out

/// The squared distance from the optical axis, at distance 1, of the farthest pixel of the border.
double farthest_squared(const CameraModel& camera) {
  double farthest = 0;
  constexpr int steps = 4;
  for (int k = 0; k <= steps; ++k) {
    const double u = (camera.width - 1) * k / double{steps}, v = (camera.height - 1) * k / double{steps};
    const Vec2 border[] = {{u, 0}, {u, camera.height - 1.0}, {0, v}, {camera.width - 1.0, v}};
    for (const Vec2& pixel : border) farthest = std::max(farthest, normalised_from_pixel(camera, pixel).squaredNorm());
  }
  return farthest;
}

/// A range of pixels along an axis, in sixteenths: whole ones between two that count in part.
struct Span {
  std::int32_t first, last, first_weight, last_weight;
};
Span span_about(double middle_px, std::int32_t side) {
  const auto from = static_cast<std::int32_t>(std::floor((middle_px + 0.5) * sixteenths - 0.5 * side + 0.5));
  const std::int32_t to = from + side;  // pixel i covers [16 i, 16 (i + 1))
  const std::int32_t first = from >> 4, last = (to - 1) >> 4;
  if (first == last) return {first, last, side, 0};
  return {first, last, sixteenths - (from & 15), to - last * sixteenths};
}

/// Grey in sixteenths of the square about a pixel.
std::int32_t mean_of_square(const GrayView& image, const Span& across, const Span& down, std::int32_t side) {
  std::int64_t total = 0;
  for (std::int32_t y = down.first; y <= down.last; ++y) {
    const std::uint8_t* const row = image.row(y);
    std::int32_t whole = 0;
    for (std::int32_t x = across.first + 1; x < across.last; ++x) whole += row[x];
    const std::int32_t sum =
        across.first_weight * row[across.first] + across.last_weight * row[across.last] + sixteenths * whole;
    const std::int32_t weight = y == down.first ? down.first_weight : (y == down.last ? down.last_weight : sixteenths);
    total += std::int64_t{weight} * sum;
  }
  return static_cast<std::int32_t>(total * sixteenths / (std::int64_t{side} * side));
}

/// Of every fourth pixel, in sixteenths.
std::int32_t mean_of_image(const GrayView& image) {
  std::int64_t sum = 0, count = 0;
  for (std::int32_t y = 0; y < image.height; y += 4) {
    for (std::int32_t x = 0; x < image.width; x += 4) sum += image.at(x, y);
    count += (image.width + 3) / 4;
  }
  return static_cast<std::int32_t>(sixteenths * sum / std::max(count, std::int64_t{1}));
}

void add(const SheetSums& sums, std::size_t cell, std::int32_t value) {
  if (sums.count[cell] >= most_count) return;
  sums.sum[cell] += value;
  ++sums.count[cell];
}

}  // namespace

Status SheetPainter::begin(const MapKeyframe& keyframe, const MapPlan& plan, const MapWindow& window,
                           double fallback_m) {
  ILP_TRY(validate(keyframe.camera));
  const GrayView& image = keyframe.image;
  if (image.data == nullptr || image.width != keyframe.camera.width || image.height != keyframe.camera.height) {
    return {StatusCode::image_size_changed, image.width, image.height};
  }
  image_ = image;
  camera_ = keyframe.camera;
  plain_ = camera_.is_plain();
  camera_from_map_ = keyframe.camera_from_map;
  first_column_ = plan.sheet_column;
  first_row_ = plan.sheet_row;
  fallback_m_ = fallback_m;
  const double image_m = image_pixel_m(camera_, camera_from_map_, fallback_m);
  if (!(image_m > 0)) return out_of_range(Argument::map_keyframe, image_m);
  const double pixels = std::clamp(window.pixel_m / image_m, 1.0, widest_cell_px);
  side_ = static_cast<std::int32_t>(std::floor(pixels * sixteenths + 0.5));
  farthest2_ = beyond_border * farthest_squared(camera_);
  mean_grey_ = mean_of_image(image_);
  return {};
}

bool SheetPainter::look(const Vec3& p, Vec2& pixel) const {
  if (!(p.z() > 0)) return false;
  const double inverse_depth = 1 / p.z(), x = p.x() * inverse_depth, y = p.y() * inverse_depth;
  if (!(x * x + y * y < farthest2_)) return false;
  if (plain_) {
    const Distorted d = plain_distort(camera_, x, y);
    pixel = Vec2(camera_.fx * d.x + camera_.cx, camera_.fy * d.y + camera_.cy);
  } else {
    pixel = pixel_from_normalised(camera_, Vec2(x, y));
  }
  return true;
}

void SheetPainter::paint_rows(const MapWindow& window, std::int32_t first, std::int32_t last,
                              const SheetSums& sums) const {
  const double reach = 0.5 * side_ / sixteenths;  // of the square; its cell is shown with a margin of half a cell
  const double margin = std::max(reach, 1.0);
  for (std::int32_t row = first; row < last; ++row) {
    const std::int32_t window_row = row + first_row_;
    const double y = window.y0_m - (window_row + 0.5) * window.pixel_m;
    const Vec3 level = camera_from_map_ * Vec3(0, y, 0);
    for (std::int32_t column = 0; column < sums.width; ++column) {
      const std::int32_t window_column = column + first_column_;
      const std::size_t at = static_cast<std::size_t>(window_row) * static_cast<std::size_t>(window.width) +
                             static_cast<std::size_t>(window_column);
      const double z = window.known[at] != 0 ? static_cast<double>(window.height_m[at]) : fallback_m_;
      Vec2 pixel;
      const double x = window.x0_m + (window_column + 0.5) * window.pixel_m;
      if (!look(level + x * camera_from_map_.rotation.col(0) + z * camera_from_map_.rotation.col(2), pixel)) continue;
      if (!(pixel.x() >= margin && pixel.y() >= margin && pixel.x() < image_.width - 1 - margin &&
            pixel.y() < image_.height - 1 - margin)) {
        continue;
      }
      const std::int32_t grey =
          mean_of_square(image_, span_about(pixel.x(), side_), span_about(pixel.y(), side_), side_);
      add(sums, static_cast<std::size_t>(row) * static_cast<std::size_t>(sums.width) + static_cast<std::size_t>(column),
          grey - mean_grey_);
    }
  }
}

std::int32_t SheetPainter::darkest_lit() const {
  return static_cast<std::int32_t>((shadow_share - 1) * mean_grey_);
}

void add_depths(const MapKeyframe& keyframe, ImageView<const float> depth_m, double first_px, double step_px,
                const MapPlan& plan, double level_m, std::int32_t first_row, std::int32_t last_row,
                const SheetSums& sums) {
  const RigidTransform map_from_camera = inverse(keyframe.camera_from_map);
  const CameraModel& camera = keyframe.camera;
  for (std::int32_t j = first_row; j < last_row; ++j) {
    for (std::int32_t first = 0; first < depth_m.width; first += points_at_once) {
      const std::int32_t count = std::min(points_at_once, depth_m.width - first);
      double x[points_at_once], y[points_at_once];
      for (std::int32_t i = 0; i < count; ++i) {
        x[i] = (first_px + (first + i) * step_px - camera.cx) / camera.fx;
        y[i] = (first_px + j * step_px - camera.cy) / camera.fy;
      }
      undistort(camera, count, x, y);
      for (std::int32_t i = 0; i < count; ++i) {
        const auto depth = static_cast<double>(depth_m.at(first + i, j));
        if (!(depth > 0) || !std::isfinite(depth)) continue;
        const Vec3 place = map_from_camera * Vec3(x[i] * depth, y[i] * depth, depth);
        const double column = (place.x() - plan.x0_m()) / plan.pixel_m - plan.sheet_column;
        const double row = (plan.y0_m() - place.y()) / plan.pixel_m - plan.sheet_row;
        if (!(column >= 0 && row >= 0 && column < sums.width && row < sums.height)) continue;
        const std::size_t cell =
            static_cast<std::size_t>(row) * static_cast<std::size_t>(sums.width) + static_cast<std::size_t>(column);
        add(sums, cell, raw_height(place.z() - level_m, plan.pixel_m));
      }
    }
  }
}

void finish_sheet(const SheetSums& sums, MapChannels<max_map_sheet_side>& sheet) {
  sheet.width = sums.width;
  sheet.height = sums.height;
  const std::size_t cells = static_cast<std::size_t>(sums.width) * static_cast<std::size_t>(sums.height);
  for (std::size_t k = 0; k < cells; ++k) {
    sheet.value[k] = sums.count[k] > 0 ? static_cast<std::int16_t>(sums.sum[k] / sums.count[k]) : unknown_value;
  }
}

void hide_dark_cells(std::int32_t least, MapChannels<max_map_sheet_side>& sheet) {
  for (std::int32_t row = 0; row < sheet.height; ++row) {
    for (std::int32_t column = 0; column < sheet.width; ++column) {
      std::int16_t& value = sheet.value[sheet.at(column, row)];
      if (value == unknown_value || value >= least) continue;
      value = unknown_value;
      const std::int32_t left = std::max(column - 1, 0), right = std::min(column + 1, sheet.width - 1);
      for (std::int32_t y = std::max(row - 1, 0); y <= std::min(row + 1, sheet.height - 1); ++y) {
        std::fill_n(sheet.direction.data() + 2 * sheet.at(left, y), 2 * (right - left + 1), std::int8_t{0});
      }
    }
  }
}

}  // namespace ilp
