#include "fsw/vision/map/map_plan.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/map/ground_point.hpp"

namespace ilp {
namespace {

constexpr double most_diagonal_px = 190;  // of the image: a sheet loses its corners at some headings
constexpr std::int32_t margin_px = 2;
constexpr double farthest_cell = 1e15;

struct Bounds {
  double west = 1e300, east = -1e300, south = 1e300, north = -1e300;

  void add(double x, double y) {
    west = std::min(west, x);
    east = std::max(east, x);
    south = std::min(south, y);
    north = std::max(north, y);
  }
};

/// A range of cells of at most `most`, about the middle one.
void cut(std::int64_t middle, std::int32_t most, std::int64_t& first, std::int64_t& last) {
  if (last - first + 1 <= most) return;
  first = std::clamp(middle - most / 2, first, last - most + 1);
  last = first + most - 1;
}

/// The ground under the border and the middle of an image. False when some of it is not below.
bool add_ground(const MapKeyframe& keyframe, double ground_m, Bounds& bounds) {
  const CameraModel& camera = keyframe.camera;
  for (int iy = 0; iy <= 2; ++iy) {
    for (int ix = 0; ix <= 2; ++ix) {
      const Vec2 at =
          normalised_from_pixel(camera, Vec2(ix * 0.5 * (camera.width - 1), iy * 0.5 * (camera.height - 1)));
      Vec3 ground;
      if (!ground_on_level(keyframe.camera_from_map, Vec3(at.x(), at.y(), 1), ground_m, ground)) return false;
      bounds.add(ground.x(), ground.y());
    }
  }
  return true;
}

}  // namespace

double image_pixel_m(const CameraModel& camera, const RigidTransform& camera_from_map, double ground_m) {
  Vec3 ground;
  if (!ground_on_level(camera_from_map, Vec3(0, 0, 1), ground_m, ground)) return 0;
  return (camera_from_map * ground).z() / camera.fx;
}

double map_working_pixel_m(const CameraModel& camera, double image_pixel_m, double map_pixel_m) {
  const double diagonal =
      std::sqrt(static_cast<double>(camera.width) * camera.width + static_cast<double>(camera.height) * camera.height);
  return std::max(map_pixel_m, image_pixel_m * std::max(least_map_image_pixels, diagonal / most_diagonal_px));
}

double map_relief_pixel_m(double image_pixel_m, double map_pixel_m) {
  return std::max(map_pixel_m, least_relief_image_pixels * image_pixel_m);
}

std::int32_t map_patch_px(double image_pixels) {
  if (image_pixels < 8) return 16;
  return image_pixels < 14 ? 12 : map_least_patch_px;
}

Result<MapPlan> plan_map_window(std::span<const MapKeyframe> keyframes, const MapPrior& prior, double ground_m,
                                double pixel_m) {
  if (!(pixel_m > 0) || !std::isfinite(pixel_m)) return out_of_range(Argument::map_window, pixel_m);
  if (keyframes.empty()) return out_of_range(Argument::map_keyframe);
  Vec3 middle;
  if (!ground_on_level(prior.camera_from_map, Vec3(0, 0, 1), ground_m, middle)) return StatusCode::not_found;

  MapPlan plan;
  plan.pixel_m = pixel_m;
  const double image_m = image_pixel_m(keyframes[0].camera, prior.camera_from_map, ground_m);
  plan.patch_px = map_patch_px(pixel_m / image_m);
  const double sigma_m = largest_sigma(ground_covariance(prior.camera_from_map, middle, prior.covariance));
  const double needed = std::ceil(3 * sigma_m / pixel_m);
  if (!(needed <= most_map_search_px)) {
    return Status(StatusCode::capacity_exceeded, static_cast<std::int64_t>(std::min(needed, 1e9)), most_map_search_px);
  }
  plan.search_px = std::max(static_cast<std::int32_t>(needed), least_map_search_px) + map_edge_px;

  Bounds bounds;
  for (const MapKeyframe& keyframe : keyframes) {
    ILP_TRY(validate(keyframe.camera));
    if (!add_ground(keyframe, ground_m, bounds)) return StatusCode::not_found;
  }
  const double sides[] = {bounds.west, bounds.east, bounds.south, bounds.north};
  for (const double side : sides) {
    if (!(std::fabs(side / pixel_m) < farthest_cell)) return out_of_range(Argument::map_window, side);
  }
  const auto cell = [&](double metres) { return static_cast<std::int64_t>(std::floor(metres / pixel_m)); };
  std::int64_t left = cell(bounds.west) - margin_px, right = cell(bounds.east) + margin_px;
  std::int64_t top = cell(-bounds.north) - margin_px, bottom = cell(-bounds.south) + margin_px;
  const std::int32_t most = std::min(max_map_sheet_side, max_map_window_side - 2 * plan.search_px);
  cut((left + right) / 2, most, left, right);
  cut((top + bottom) / 2, most, top, bottom);
  plan.first_column = left - plan.search_px;
  plan.first_row = top - plan.search_px;
  plan.sheet_width = static_cast<std::int32_t>(right - left + 1);
  plan.sheet_height = static_cast<std::int32_t>(bottom - top + 1);
  plan.sheet_column = plan.sheet_row = plan.search_px;
  plan.width = plan.sheet_width + 2 * plan.search_px;
  plan.height = plan.sheet_height + 2 * plan.search_px;
  return plan;
}

}  // namespace ilp
