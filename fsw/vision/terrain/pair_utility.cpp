#include "fsw/vision/terrain/pair_utility.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

constexpr std::int32_t samples_across = 16, samples_down = 12;
// Of a match on textured ground, as the stereo matcher states it.
constexpr double disparity_sigma_px = 0.1;
// What ground that nobody has is worth, in halvings of its sigma.
constexpr double new_ground_octaves = 4;
constexpr double min_common = 0.3;
constexpr auto samples = static_cast<std::size_t>(samples_across) * static_cast<std::size_t>(samples_down);

/// The relative sigma of the distance of the point in direction `ray` of the first camera; 0 if the second one does not
/// see it.
double sigma_of_sample(const CameraModel& camera, const RigidTransform& second_from_first, double distance,
                       const Vec2& ray) {
  const Vec3 q = second_from_first * Vec3(distance * ray.x(), distance * ray.y(), distance);
  if (!(q.z() > 1e-6 * distance)) return 0;
  const Vec2 n(q.x() / q.z(), q.y() / q.z());
  const Vec2 pixel = pixel_from_normalised(camera, n);
  if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= camera.width - 1 && pixel.y() <= camera.height - 1)) return 0;
  const Vec3& t = second_from_first.translation;
  const Vec2 moved(t.x() - n.x() * t.z(), t.y() - n.y() * t.z());
  const double parallax_px = camera.fx * moved.norm() / q.z();
  return disparity_sigma_px / std::max(parallax_px, 1e-9);
}

}  // namespace

PairUtility pair_utility(const CameraModel& camera, const RigidTransform& second_from_first, double distance,
                         const Coverage& coverage, const PairUtilityParams& params) {
  PairUtility result;
  if (!(distance > 0) || !same_size(camera, coverage)) return result;
  std::array<double, samples> sigmas;
  std::size_t common = 0;
  double utility = 0;
  for (std::int32_t row = 0; row < samples_down; ++row) {
    for (std::int32_t column = 0; column < samples_across; ++column) {
      const std::int32_t x = (2 * column + 1) * camera.width / (2 * samples_across);
      const std::int32_t y = (2 * row + 1) * camera.height / (2 * samples_down);
      const Vec2 ray = normalised_from_pixel(camera, Vec2(x, y));
      const double sigma = sigma_of_sample(camera, second_from_first, distance, ray);
      if (!(sigma > 0)) continue;
      sigmas[common++] = sigma;
      if (sigma > params.largest_sigma) continue;
      const bool known = coverage.at(x, y);
      const std::uint8_t now = seen_quality(distance / camera.fx, sigma);
      if (known && at_least_as_well(coverage.seen.at(x, y), now, params.finer_steps)) continue;
      utility += det_log(params.largest_sigma / sigma) / det_log(2) + (known ? 0 : new_ground_octaves);
    }
  }
  if (common == 0) return result;
  const auto middle = sigmas.begin() + static_cast<std::ptrdiff_t>(common / 2);
  std::nth_element(sigmas.begin(), middle, sigmas.begin() + static_cast<std::ptrdiff_t>(common));
  result.median_sigma = *middle;
  result.common = static_cast<double>(common) / static_cast<double>(samples);
  result.utility = result.common < min_common ? 0 : utility / static_cast<double>(samples);
  return result;
}

}  // namespace ilp
