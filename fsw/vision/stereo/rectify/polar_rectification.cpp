#include "fsw/vision/stereo/rectify/polar_rectification.hpp"

#include <algorithm>
#include <cmath>

#include "cfg/limits.hpp"
#include "fsw/base/argument.hpp"
#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/stereo/rectify/polar_coordinates.hpp"
#include "fsw/vision/stereo/rectify/rectification_axes.hpp"

namespace ilp {
namespace {

constexpr int cells = 128;  ///< of the common view, in azimuth and in advance
// Windows and paths reach beyond a panel's sector, so that they do not end at its edge.
constexpr double padding_px = 16;
// Advance across a ring: its inner edge is sampled at most exp(0.8) = 2.2 times as densely as its outer edge.
constexpr double max_ring = 0.8;

struct TwoViews {
  CameraModel camera;
  FieldOfView view;
  Mat3 rect_from_left, rect_from_right;
  double baseline = 0;
  DepthRange depth;
};

/// Whether the image shows a direction in camera axes.
bool shows(const TwoViews& views, const Vec3& direction) {
  if (!(direction.z() > 1e-9 * direction.norm())) return false;
  const Vec2 n(direction.x() / direction.z(), direction.y() / direction.z());
  if (n.x() < views.view.min_x || n.x() > views.view.max_x || n.y() < views.view.min_y || n.y() > views.view.max_y) {
    return false;
  }
  const Vec2 p = pixel_from_normalised(views.camera, n);
  return p.x() >= 0 && p.y() >= 0 && p.x() <= views.camera.width - 1 && p.y() <= views.camera.height - 1;
}

/// Direction with distance one from the baseline, in the axes of the pair.
Vec3 direction_at(double advance, double azimuth) {
  return {det_sinh(advance), det_sin(azimuth), det_cos(azimuth)};
}

bool seen_by_right(const TwoViews& views, const Vec3& direction, double per_depth, double depth) {
  const Vec3 point = direction * (depth / per_depth) - Vec3(views.baseline, 0, 0);
  return shows(views, views.rect_from_right.transpose() * point);
}

/// Cells of the left image whose ground, anywhere in the range of depths, the right image also shows.
struct CommonView {
  Interval advance, azimuth;
  std::array<std::uint64_t, cells * cells / 64> seen{};

  [[nodiscard]] double advance_step() const { return advance.length() / cells; }
  [[nodiscard]] double azimuth_step() const { return azimuth.length() / cells; }
  [[nodiscard]] double advance_of_cell(int i) const { return advance.low + (i + 0.5) * advance_step(); }
  [[nodiscard]] double azimuth_of_cell(int j) const { return azimuth.low + (j + 0.5) * azimuth_step(); }
  [[nodiscard]] static std::size_t index(int i, int j) {
    return static_cast<std::size_t>(j) * cells + static_cast<std::size_t>(i);
  }
  [[nodiscard]] bool at(int i, int j) const {
    const std::size_t k = index(i, j);
    return ((seen[k / 64] >> (k % 64)) & 1U) != 0;
  }
  void set(int i, int j) {
    const std::size_t k = index(i, j);
    seen[k / 64] |= std::uint64_t{1} << (k % 64);
  }
};

/// Whether the direction `sign` times the baseline is inside the left image or near its border.
bool epipole_near(const TwoViews& views, double sign) {
  const Vec3 e = views.rect_from_left.row(0).transpose() * sign;
  if (!(e.z() > 0)) return false;
  constexpr double enlarged = 0.1;
  const FieldOfView& v = views.view;
  const double more_x = enlarged * (v.max_x - v.min_x);
  const double more_y = enlarged * (v.max_y - v.min_y);
  const double x = e.x() / e.z();
  const double y = e.y() / e.z();
  return x > v.min_x - more_x && x < v.max_x + more_x && y > v.min_y - more_y && y < v.max_y + more_y;
}

/// A box around the left image, outside the blind disc.
void bound(const TwoViews& views, double max_advance, CommonView& common) {
  const double right = views.camera.width - 1;
  const double bottom = views.camera.height - 1;
  const auto include = [&](double x, double y) {
    const Vec2 n = normalised_from_pixel(views.camera, Vec2(x, y));
    const Vec3 q = views.rect_from_left * Vec3(n.x(), n.y(), 1);
    common.advance.include(advance_of(q));
    common.azimuth.include(azimuth_of(q));
  };
  constexpr int steps = 32;
  for (int i = 0; i <= steps; ++i) {
    const double t = i / static_cast<double>(steps);
    include(t * right, 0);
    include(t * right, bottom);
    include(0, t * bottom);
    include(right, t * bottom);
  }
  const double slack_advance = 0.02 * common.advance.length();
  const double slack_azimuth = 0.02 * common.azimuth.length();
  const bool ahead = epipole_near(views, 1);
  const bool behind = epipole_near(views, -1);
  common.advance.low = behind ? -max_advance : std::max(common.advance.low - slack_advance, -max_advance);
  common.advance.high = ahead ? max_advance : std::min(common.advance.high + slack_advance, max_advance);
  const bool around = ahead || behind;
  common.azimuth.low = around ? -pi : std::max(common.azimuth.low - slack_azimuth, -pi);
  common.azimuth.high = around ? pi : std::min(common.azimuth.high + slack_azimuth, pi);
}

void mark(const TwoViews& views, CommonView& common) {
  const double middle = 2 / (1 / views.depth.nearest + 1 / views.depth.farthest);
  for (int i = 0; i < cells; ++i) {
    const double along = det_sinh(common.advance_of_cell(i));
    for (int j = 0; j < cells; ++j) {
      const double azimuth = common.azimuth_of_cell(j);
      const Vec3 direction(along, det_sin(azimuth), det_cos(azimuth));
      const Vec3 in_left = views.rect_from_left.transpose() * direction;
      if (!shows(views, in_left)) continue;
      if (seen_by_right(views, direction, in_left.z(), middle) ||
          seen_by_right(views, direction, in_left.z(), views.depth.nearest) ||
          seen_by_right(views, direction, in_left.z(), views.depth.farthest)) {
        common.set(i, j);
      }
    }
  }
}

struct CellRange {
  int advance_begin = 0, advance_end = 0;
  int azimuth_begin = 0, azimuth_end = 0;
};

/// The requirements of a range's visible cells on a panel.
struct Needs {
  Interval advance, azimuth;
  Interval shift;             ///< advance in the left image less that in the right one
  double px_per_radian = 0;   ///< of the image, in advance or azimuth, where it is most
  double disparity_rate = 0;  ///< px of the image per unit of inverse depth, where it is most
};

/// The shift that follows from the inverse depth of a point: cot(right) = cot(left) - baseline / distance from
/// baseline.
double shift_of(const TwoViews& views, double advance, double per_depth, double depth) {
  return advance - det_asinh(det_sinh(advance) - views.baseline * per_depth / depth);
}

double image_scale(const TwoViews& views, double advance, double azimuth) {
  constexpr double step = 1e-4;
  const auto pixel = [&](double t, double phi) {
    const Vec3 c = views.rect_from_left.transpose() * direction_at(t, phi);
    return pixel_from_normalised(views.camera, Vec2(c.x() / c.z(), c.y() / c.z()));
  };
  const Vec2 here = pixel(advance, azimuth);
  return std::max((pixel(advance + step, azimuth) - here).norm(), (pixel(advance, azimuth + step) - here).norm()) /
         step;
}

Needs needs_of(const TwoViews& views, const CommonView& common, const CellRange& range) {
  Needs needs;
  const double half_advance = 0.5 * common.advance_step();
  const double half_azimuth = 0.5 * common.azimuth_step();
  for (int j = range.azimuth_begin; j < range.azimuth_end; ++j) {
    for (int i = range.advance_begin; i < range.advance_end; ++i) {
      if (!common.at(i, j)) continue;
      const double advance = common.advance_of_cell(i);
      const double azimuth = common.azimuth_of_cell(j);
      // A cell's neighbour may be visible in part.
      needs.advance.include(advance - 2 * half_advance);
      needs.advance.include(advance + 2 * half_advance);
      needs.azimuth.include(azimuth - 2 * half_azimuth);
      needs.azimuth.include(azimuth + 2 * half_azimuth);
      const double per_depth = (views.rect_from_left.transpose() * direction_at(advance, azimuth)).z();
      needs.shift.include(shift_of(views, advance, per_depth, views.depth.nearest));
      needs.shift.include(shift_of(views, advance, per_depth, views.depth.farthest));
      const double scale = image_scale(views, advance, azimuth);
      needs.px_per_radian = std::max(needs.px_per_radian, scale);
      const double along_right = det_sinh(advance) - views.baseline * per_depth / views.depth.farthest;
      needs.disparity_rate =
          std::max(needs.disparity_rate, scale * views.baseline * per_depth / std::sqrt(1 + along_right * along_right));
    }
  }
  return needs;
}

/// Places the images of a panel; false when they do not fit at min_scale of the full resolution.
bool place(const Needs& needs, const RectificationParams& params, RectifiedPanel& panel, bool& cut) {
  RectifiedPair& pair = panel.pair;
  const double rows = limits::max_rectified_height - 2 - 2 * padding_px;
  const double columns = limits::max_rectified_width - 2 - 2 * padding_px - 2 * params.margin_px;
  // Two more, because the range is rounded outwards.
  const double disparities = limits::max_disparities - 2 * params.margin_px - 3;
  const double shifts = std::max(needs.shift.length(), 1e-9);
  const double roomy = std::min({params.scale * params.polar_scale * needs.px_per_radian, rows / needs.azimuth.length(),
                                 columns / needs.advance.length()});
  pair.focal_px = std::min({roomy, disparities / shifts, columns / (needs.advance.length() + shifts)});
  pair.focal_px = std::max(pair.focal_px, params.scale * params.min_scale * needs.px_per_radian);
  if (pair.focal_px > roomy) return false;
  const double span = std::min(shifts * pair.focal_px, disparities);
  cut = cut || span < shifts * pair.focal_px - 1e-6;
  if (needs.advance.length() * pair.focal_px + span > columns) return false;

  pair.resolution = pair.focal_px / needs.px_per_radian;
  pair.width = static_cast<std::int32_t>(std::ceil(needs.advance.length() * pair.focal_px + span + 2 * padding_px)) + 1;
  pair.height = static_cast<std::int32_t>(std::ceil(needs.azimuth.length() * pair.focal_px + 2 * padding_px)) + 1;
  // The far end stays when the range is cut, because most ground is there.
  const double least = needs.shift.low * pair.focal_px;
  pair.cx_left = padding_px - needs.advance.low * pair.focal_px;
  pair.cx_right = padding_px - needs.advance.low * pair.focal_px + least + span;
  pair.cy = padding_px - needs.azimuth.low * pair.focal_px;
  const double offset = pair.disparity_offset_px();
  panel.range.min_px = static_cast<std::int32_t>(std::floor(least + offset - params.margin_px));
  panel.range.max_px = static_cast<std::int32_t>(std::ceil(least + span + offset + params.margin_px));
  return true;
}

/// Cells [begin, end) of part `k` of `parts` nearly equal ones.
int part_begin(int begin, int end, int k, int parts) {
  return begin + (end - begin) * k / parts;
}

/// The smallest range that contains the visible cells of the given one.
CellRange shrink(const CommonView& common, const CellRange& range) {
  CellRange seen{range.advance_end, range.advance_begin, range.azimuth_end, range.azimuth_begin};
  for (int j = range.azimuth_begin; j < range.azimuth_end; ++j) {
    for (int i = range.advance_begin; i < range.advance_end; ++i) {
      if (!common.at(i, j)) continue;
      seen.advance_begin = std::min(seen.advance_begin, i);
      seen.advance_end = std::max(seen.advance_end, i + 1);
      seen.azimuth_begin = std::min(seen.azimuth_begin, j);
      seen.azimuth_end = std::max(seen.azimuth_end, j + 1);
    }
  }
  return seen;
}

PolarSector sector_of(const CommonView& common, const CellRange& range) {
  const auto cotangent = [&](int i) {
    return det_sinh(i == cells ? common.advance.high : common.advance.low + i * common.advance_step());
  };
  const auto azimuth = [&](int j) {
    return j == cells ? common.azimuth.high : common.azimuth.low + j * common.azimuth_step();
  };
  // The last one includes pi itself.
  const double beyond = range.azimuth_end == cells ? 1 : 0;
  return {cotangent(range.advance_begin), cotangent(range.advance_end), azimuth(range.azimuth_begin),
          azimuth(range.azimuth_end) + beyond};
}

/// One ring, divided into as few sectors as fit; false when the plan is full or nothing fits.
bool add_ring(const TwoViews& views, const CommonView& common, const CellRange& ring, const RectificationParams& params,
              RectificationPlan& plan, bool& cut) {
  const CellRange seen = shrink(common, ring);
  if (seen.azimuth_end <= seen.azimuth_begin) return true;
  const Needs whole = needs_of(views, common, seen);
  const double rows = limits::max_rectified_height - 2 - 2 * padding_px;
  const double focal = params.scale * params.polar_scale * whole.px_per_radian;
  // A sector is widened by a cell.
  const double usable = std::max(rows - 2 * common.azimuth_step() * focal, 0.25 * rows);
  const int sectors = std::clamp(static_cast<int>(std::ceil(whole.azimuth.length() * focal / usable)), 1, cells);
  for (int k = 0; k < sectors; ++k) {
    CellRange part = ring;
    part.azimuth_begin = k == 0 ? 0 : part_begin(seen.azimuth_begin, seen.azimuth_end, k, sectors);
    part.azimuth_end = k + 1 == sectors ? cells : part_begin(seen.azimuth_begin, seen.azimuth_end, k + 1, sectors);
    const Needs needs = needs_of(views, common, part);
    if (needs.advance.empty()) continue;
    if (plan.count == plan.panels.size()) return false;
    RectifiedPanel& panel = plan.panels[plan.count];
    panel.pair = {};
    if (!place(needs, params, panel, cut)) return false;
    panel.pair.method = RectificationMethod::polar;
    panel.pair.baseline = views.baseline;
    panel.pair.rect_from_left = views.rect_from_left;
    panel.pair.rect_from_right = views.rect_from_right;
    panel.pair.field_of_view = views.view;
    panel.pair.sector = sector_of(common, part);
    plan.resolution = std::min(plan.resolution, panel.pair.resolution);
    plan.disparity_per_inverse_depth_px = std::max(plan.disparity_per_inverse_depth_px, needs.disparity_rate);
    ++plan.count;
  }
  return true;
}

bool divide(const TwoViews& views, const CommonView& common, const CellRange& seen, int rings,
            const RectificationParams& params, RectificationPlan& plan, bool& cut) {
  plan.count = 0;
  plan.resolution = 1;
  plan.disparity_per_inverse_depth_px = 0;
  cut = false;
  for (int k = 0; k < rings; ++k) {
    CellRange ring;
    ring.advance_begin = k == 0 ? 0 : part_begin(seen.advance_begin, seen.advance_end, k, rings);
    ring.advance_end = k + 1 == rings ? cells : part_begin(seen.advance_begin, seen.advance_end, k + 1, rings);
    ring.azimuth_end = cells;
    if (!add_ring(views, common, ring, params, plan, cut)) return false;
  }
  return true;
}

/// Sine of the angle from the baseline below which ground at the far end of the range moves by less than wanted.
double blind_sine(const TwoViews& views, double focal, double min_parallax_px) {
  const Vec3 epipole = views.rect_from_left.row(0).transpose();
  // The ray towards the epipole is longer than the depth. If the camera looks away from it the disc is not in view.
  constexpr double min_cosine = 0.2;
  const double cosine = std::max(std::fabs(epipole.z()), min_cosine);
  return min_parallax_px * views.depth.farthest / (cosine * focal * views.baseline);
}

}  // namespace

Status plan_polar_rectification(const CameraModel& camera, const RigidTransform& left_from_world,
                                const RigidTransform& right_from_world, const DepthRange& depth,
                                const RectificationParams& params, RectificationPlan& plan) {
  plan.count = 0;
  if (!(depth.nearest > 0) || !(depth.farthest >= depth.nearest) || !std::isfinite(depth.farthest)) {
    return out_of_range(Argument::depth_range, depth.nearest);
  }
  StereoAxes axes;
  ILP_TRY(stereo_axes(left_from_world, right_from_world, depth.nearest, params.max_axes_angle_rad, axes));
  const Vec3 mean = axes.optical_left + axes.optical_right;
  const bool sideways = (mean - mean.dot(axes.along) * axes.along).norm() > 1e-3;
  const Vec3 across = left_from_world.rotation.row(1).transpose();
  const Mat3 rect_from_world = frame_along_baseline(axes, sideways ? mean : across);
  const TwoViews views{camera,
                       field_of_view(camera),
                       rect_from_world * left_from_world.rotation.transpose(),
                       rect_from_world * right_from_world.rotation.transpose(),
                       axes.baseline,
                       depth};
  const double focal = 0.5 * (camera.fx + camera.fy);
  const double sine = blind_sine(views, focal, params.min_parallax_px);
  if (!(sine < 1)) return impossible(RectificationFault::no_parallax);
  const double max_advance = det_log((1 + std::sqrt(1 - sine * sine)) / sine);
  plan.method = RectificationMethod::polar;
  plan.baseline = axes.baseline;
  plan.blind_radius_px = focal * det_asin(sine);

  CommonView common;
  bound(views, max_advance, common);
  if (!(common.advance.length() > 0) || !(common.azimuth.length() > 0))
    return impossible(RectificationFault::no_parallax);
  mark(views, common);
  const CellRange seen = shrink(common, {0, cells, 0, cells});
  if (seen.azimuth_end <= seen.azimuth_begin) return impossible(RectificationFault::no_common_ground);
  const double span = (seen.advance_end - seen.advance_begin) * common.advance_step();
  const int fewest = std::max(1, static_cast<int>(std::ceil(span / max_ring)));
  bool cut = false;
  for (int rings = fewest; rings < fewest + 4; ++rings) {
    if (!divide(views, common, seen, rings, params, plan, cut)) continue;
    return cut ? Status{StatusCode::disparity_range_exceeded, limits::max_disparities, limits::max_disparities}
               : Status{};
  }
  plan.count = 0;
  return impossible(RectificationFault::too_large);
}

}  // namespace ilp
