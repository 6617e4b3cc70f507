#include "fsw/vision/stereo/rectify/rectification.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "cfg/limits.hpp"
#include "fsw/base/argument.hpp"
#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/stereo/rectify/polar_coordinates.hpp"
#include "fsw/vision/stereo/rectify/rectification_axes.hpp"

namespace ilp {
namespace {

// A direction further than this from the rectified axis would stretch the image too much: cosine of 78 degrees.
constexpr double min_axis_cosine = 0.2;
constexpr double min_common_rows = 16;
constexpr int border_steps = 16;

/// Calls `use(pixel)` for points all around the border of the image's pixel area.
template <typename Use>
void for_each_border_point(const CameraModel& camera, Use use) {
  const double right = camera.width - 1;
  const double bottom = camera.height - 1;
  for (int i = 0; i <= border_steps; ++i) {
    const double t = i / static_cast<double>(border_steps);
    use(Vec2(t * right, 0));
    use(Vec2(t * right, bottom));
    use(Vec2(0, t * bottom));
    use(Vec2(right, t * bottom));
  }
}

Interval common(const Interval& a, const Interval& b) {
  return {std::max(a.low, b.low), std::min(a.high, b.high)};
}

/// The outline of an image on the rectified plane at unit distance.
struct Footprint {
  Interval u, v;
  Interval depth_ratio;  ///< depth along the rectified axis / depth along the camera's axis
  bool in_front = true;
};

Footprint footprint(const CameraModel& camera, const Mat3& rect_from_cam) {
  Footprint f;
  for_each_border_point(camera, [&](const Vec2& pixel) {
    const Vec2 n = normalised_from_pixel(camera, pixel);
    const Vec3 q = rect_from_cam * Vec3(n.x(), n.y(), 1);
    if (q.z() < min_axis_cosine * q.norm()) {
      f.in_front = false;
      return;
    }
    f.u.include(q.x() / q.z());
    f.v.include(q.y() / q.z());
    f.depth_ratio.include(q.z());
  });
  return f;
}

/// World to rectified: x along the baseline, z as near as possible to both optical axes.
Status common_orientation(const StereoAxes& axes, const RectificationParams& params, Mat3& rect_from_world) {
  const Vec3 mean = axes.optical_left + axes.optical_right;
  if (!((mean - mean.dot(axes.along) * axes.along).norm() > 1e-6)) return impossible(RectificationFault::epipole_near);
  rect_from_world = frame_along_baseline(axes, mean);
  const Vec3 z = rect_from_world.row(2).transpose();
  const double min_cosine = det_cos(params.max_turn_rad);
  if (z.dot(axes.optical_left) < min_cosine || z.dot(axes.optical_right) < min_cosine)
    return impossible(RectificationFault::epipole_near);
  return {};
}

std::int32_t pixels(double length, double focal) {
  return static_cast<std::int32_t>(std::floor(length * focal)) + 1;
}

Vec2 rectified(const RectifiedPair& pair, const Mat3& rect_from_cam, double cx, const Vec2& normalised) {
  const Vec3 q = rect_from_cam * Vec3(normalised.x(), normalised.y(), 1);
  if (pair.method == RectificationMethod::polar) {
    return {pair.focal_px * advance_of(q) + cx, polar_row(pair, azimuth_of(q))};
  }
  return {pair.focal_px * q.x() / q.z() + cx, pair.focal_px * q.y() / q.z() + pair.cy};
}

/// Largest focal length that fits the limits, at most the wanted one.
double fitting_focal(double wanted, const Interval& left_u, const Interval& right_u, const Interval& v,
                     const Interval& parallax, double margin_px) {
  const double width = std::max(left_u.length(), right_u.length());
  double focal = std::min(wanted, (limits::max_rectified_width - 1) / width);
  focal = std::min(focal, (limits::max_rectified_height - 1) / v.length());
  // Two more, because the range is rounded outwards.
  const double usable = limits::max_disparities - 2 * margin_px - 3;
  if (parallax.length() > 0) focal = std::min(focal, usable / parallax.length());
  return focal;
}

}  // namespace

Status depth_range_of(const RigidTransform& cam_from_world, const Vec3* points_world, std::size_t count,
                      double outlier_share, double margin, DepthRange& range) {
  const auto depth_of = [&](std::size_t i) { return (cam_from_world * points_world[i]).z(); };
  Interval all;
  std::size_t in_front = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double depth = depth_of(i);
    if (!(depth > 0)) continue;
    all.include(1 / depth);
    ++in_front;
  }
  constexpr std::size_t min_points = 8;
  if (in_front < min_points) return {StatusCode::too_few_matches, static_cast<std::int64_t>(in_front), min_points};
  // A histogram gives the quantiles without sorting. Outliers stretch it, so a second one covers only the bins that the
  // first one kept.
  constexpr std::size_t bins = 1024;
  const auto allowed = static_cast<std::size_t>(outlier_share * static_cast<double>(in_front));
  Interval kept = all;
  for (int round = 0; round < 2; ++round) {
    std::array<std::uint32_t, bins> histogram{};
    const double per_unit = bins / std::max(kept.length(), 1e-12 * kept.high);
    std::size_t below = 0;
    std::size_t above = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double depth = depth_of(i);
      if (!(depth > 0)) continue;
      const double inverse = 1 / depth;
      if (inverse < kept.low) {
        ++below;
      } else if (inverse > kept.high) {
        ++above;
      } else {
        ++histogram[std::min(bins - 1, static_cast<std::size_t>((inverse - kept.low) * per_unit))];
      }
    }
    std::size_t first = 0;
    while (first + 1 < bins && below + histogram[first] <= allowed) below += histogram[first++];
    std::size_t last = bins - 1;
    while (last > first && above + histogram[last] <= allowed) above += histogram[last--];
    const double low = kept.low;
    kept.low = low + static_cast<double>(first) / per_unit;
    kept.high = std::min(kept.high, low + static_cast<double>(last + 1) / per_unit);
  }
  const double nearest = 1 / kept.high;
  const double farthest = 1 / kept.low;
  const double widening = margin * (farthest - nearest);
  range.nearest = std::max(nearest - widening, 0.5 * nearest);
  range.farthest = farthest + widening;
  return {};
}

FieldOfView field_of_view(const CameraModel& camera) {
  Interval x;
  Interval y;
  for_each_border_point(camera, [&](const Vec2& pixel) {
    const Vec2 n = normalised_from_pixel(camera, pixel);
    x.include(n.x());
    y.include(n.y());
  });
  // Between the sampled border points a barrel or cushion may reach a little further.
  const double slack_x = 0.01 * x.length();
  const double slack_y = 0.01 * y.length();
  return {x.low - slack_x, x.high + slack_x, y.low - slack_y, y.high + slack_y};
}

Status plan_rectification(const CameraModel& camera, const RigidTransform& left_from_world,
                          const RigidTransform& right_from_world, const DepthRange& depth,
                          const RectificationParams& params, RectifiedPair& pair, DisparityRange& range) {
  if (!(depth.nearest > 0) || !(depth.farthest >= depth.nearest) || !std::isfinite(depth.farthest)) {
    return out_of_range(Argument::depth_range, depth.nearest);
  }
  pair = {};
  StereoAxes axes;
  ILP_TRY(stereo_axes(left_from_world, right_from_world, depth.nearest, params.max_axes_angle_rad, axes));
  Mat3 rect_from_world;
  ILP_TRY(common_orientation(axes, params, rect_from_world));
  pair.baseline = axes.baseline;
  pair.rect_from_left = rect_from_world * left_from_world.rotation.transpose();
  pair.rect_from_right = rect_from_world * right_from_world.rotation.transpose();
  pair.field_of_view = field_of_view(camera);
  const Footprint left = footprint(camera, pair.rect_from_left);
  const Footprint right = footprint(camera, pair.rect_from_right);
  if (!left.in_front || !right.in_front) return impossible(RectificationFault::epipole_near);

  const Interval parallax{pair.baseline / (depth.farthest * left.depth_ratio.high),
                          pair.baseline / (depth.nearest * left.depth_ratio.low)};
  const Interval v = common(left.v, right.v);
  const Interval left_u = common(left.u, {right.u.low + parallax.low, right.u.high + parallax.high});
  const Interval right_u = common(right.u, {left_u.low - parallax.high, left_u.high - parallax.low});
  const double full = 0.5 * (camera.fx + camera.fy);
  const double wanted = params.scale * full;
  if (v.length() * full < min_common_rows || left_u.length() * full < min_common_rows ||
      right_u.length() * full < min_common_rows) {
    return impossible(RectificationFault::no_common_ground);
  }
  const double roomy = fitting_focal(wanted, left_u, right_u, v, {0, 0}, params.margin_px);
  if (roomy < params.min_scale * wanted) return impossible(RectificationFault::too_large);
  pair.focal_px =
      std::max(fitting_focal(wanted, left_u, right_u, v, parallax, params.margin_px), params.min_scale * wanted);
  // A direction is compressed most along the line through the rectified principal point.
  pair.resolution = pair.focal_px / (full * std::max(1.0, left.depth_ratio.high * left.depth_ratio.high));
  pair.width = pixels(std::max(left_u.length(), right_u.length()), pair.focal_px);
  pair.height = pixels(v.length(), pair.focal_px);
  pair.cx_left = -left_u.low * pair.focal_px;
  pair.cx_right = -right_u.low * pair.focal_px;
  pair.cy = -v.low * pair.focal_px;

  const double offset = pair.disparity_offset_px();
  range.min_px = static_cast<std::int32_t>(std::floor(parallax.low * pair.focal_px + offset - params.margin_px));
  range.max_px = static_cast<std::int32_t>(std::ceil(parallax.high * pair.focal_px + offset + params.margin_px));
  const std::int32_t wished = range.count();
  if (wished <= limits::max_disparities) return {};
  range.max_px = range.min_px + limits::max_disparities - 1;
  return {StatusCode::disparity_range_exceeded, wished, limits::max_disparities};
}

Vec2 rectified_left(const RectifiedPair& pair, const Vec2& normalised) {
  return rectified(pair, pair.rect_from_left, pair.cx_left, normalised);
}

Vec2 rectified_right(const RectifiedPair& pair, const Vec2& normalised) {
  return rectified(pair, pair.rect_from_right, pair.cx_right, normalised);
}

bool gives_depth(const RectifiedPair& pair, const Vec2& normalised) {
  if (pair.method == RectificationMethod::homography) return true;
  const Vec3 q = pair.rect_from_left * Vec3(normalised.x(), normalised.y(), 1);
  return contains(pair.sector, cotangent_of(q), azimuth_of(q));
}

}  // namespace ilp
