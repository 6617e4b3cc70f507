#include "fsw/vision/navigation/position_level.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp::navigation {
namespace {

constexpr std::size_t least_positions = 4;
constexpr double farthest_from_fit = 4;  // sigmas
/// The track must be this many times as wide, and as long, as the error of its mean.
constexpr double least_extent_sigmas = 10;

using Places = FixedVector<const MeasuredKeyframe*, max_values>;

struct Fit {
  Mat3 rotation = Mat3::Identity();
  double scale = 0;  ///< metres per unit
  Vec3 middle_seen = Vec3::Zero(), middle_known = Vec3::Zero();
  Vec3 long_axis = Vec3::Zero(), long_axis_known = Vec3::Zero();  ///< from the first place on; metres for the second
  double length_units = 0, width_units = 0;  ///< root of the sum of squares along the long axis, and across it
};

double position_sigma(const MeasuredKeyframe& k) {
  return std::max(k.horizontal_sigma_m, k.vertical_sigma_m);
}

/// Axis along which a spread is widest, by power iteration. Of two that are nearly as wide any mixture serves.
Vec3 widest_axis(const Mat3& spread) {
  Vec3 axis = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    if (spread.col(i).norm() > axis.norm()) axis = spread.col(i);
  }
  constexpr int rounds = 50;
  for (int round = 0; round < rounds; ++round) {
    if (!(axis.norm() > 0)) return Vec3::Zero();
    axis = spread * axis.normalized();
  }
  return axis.norm() > 0 ? Vec3(axis.normalized()) : Vec3(Vec3::Zero());
}

/// The frame with `first` as its x axis and `second` in its plane of x and y; none for vectors of one direction.
bool frame_of(const Vec3& first, const Vec3& second, Mat3& frame) {
  if (!(first.norm() > 0)) return false;
  frame.col(0) = first.normalized();
  const Vec3 across = second - second.dot(frame.col(0)) * frame.col(0);
  if (!(across.norm() > 0)) return false;
  frame.col(1) = across.normalized();
  frame.col(2) = frame.col(0).cross(frame.col(1));
  return true;
}

Fit fit_of(const Places& places) {
  Fit fit;
  const auto count = static_cast<double>(places.size());
  for (const MeasuredKeyframe* k : places) {
    fit.middle_seen += vector_of(k->centre) / count;
    fit.middle_known += vector_of(k->place_m) / count;
  }
  Mat3 spread = Mat3::Zero();
  double told2 = 0;
  for (const MeasuredKeyframe* k : places) {
    const Vec3 seen = vector_of(k->centre) - fit.middle_seen;
    spread += seen * seen.transpose();
    told2 += (vector_of(k->place_m) - fit.middle_known).squaredNorm();
  }
  if (!(spread.trace() > 0)) return fit;
  fit.scale = std::sqrt(told2 / spread.trace());
  fit.long_axis = widest_axis(spread);
  const Mat3 across = Mat3::Identity() - fit.long_axis * fit.long_axis.transpose();
  const Mat3 rest = across * spread * across;
  const Vec3 wide_axis = widest_axis(rest);
  fit.length_units = std::sqrt(std::max(0.0, fit.long_axis.dot(spread * fit.long_axis)));
  fit.width_units = std::sqrt(std::max(0.0, wide_axis.dot(rest * wide_axis)));
  // Where the positions have these axes: the sums of positions, each by its distance along the axis.
  Vec3 wide_axis_known = Vec3::Zero();
  for (const MeasuredKeyframe* k : places) {
    const Vec3 seen = vector_of(k->centre) - fit.middle_seen, reported = vector_of(k->place_m) - fit.middle_known;
    fit.long_axis_known += reported * fit.long_axis.dot(seen);
    wide_axis_known += reported * wide_axis.dot(seen);
  }
  Mat3 from, to;
  if (frame_of(fit.long_axis, wide_axis, from) && frame_of(fit.long_axis_known, wide_axis_known, to))
    fit.rotation = to * from.transpose();
  return fit;
}

/// From where a keyframe was measured to where the fit puts it, metres.
Vec3 residual_of(const Fit& fit, const MeasuredKeyframe& k) {
  return fit.scale * (fit.rotation * (vector_of(k.centre) - fit.middle_seen)) -
         (vector_of(k.place_m) - fit.middle_known);
}

double distance_from_fit(const Fit& fit, const MeasuredKeyframe& k) {
  return residual_of(fit, k).norm();
}

Places without_outliers(const Places& places, const Fit& fit) {
  std::array<double, max_values> distances{};
  std::size_t count = 0;
  for (const MeasuredKeyframe* k : places) distances[count++] = distance_from_fit(fit, *k);
  const double scatter = sigma_per_mad * median_of(std::span(distances).first(count));
  Places kept;
  for (const MeasuredKeyframe* k : places) {
    if (distance_from_fit(fit, *k) <= farthest_from_fit * std::max(scatter, position_sigma(*k)))
      static_cast<void>(kept.push_back(k));
  }
  return kept;
}

double slope_of(const Vec3& way) {
  return det_atan2(way.z(), std::sqrt(way.x() * way.x() + way.y() * way.y()));
}

/// Turns by the slope of the track only, about a level axis across it.
Mat3 rotation_by_slope(const Fit& fit) {
  const Vec3 across(-fit.long_axis.y(), fit.long_axis.x(), 0);
  const double level = across.norm();
  if (!(level > 0)) return Mat3::Identity();
  // About this axis a positive angle lowers the track.
  return rotation_from_vector(across * ((slope_of(fit.long_axis) - slope_of(fit.long_axis_known)) / level));
}

/// One sigma that each height counts with for a slope over all of them. Errors that drift together count as fewer, and
/// those that scatter by far more than they state as one.
double height_error(std::span<const double> residuals, double sigma) {
  const auto count = static_cast<double>(residuals.size());
  double squares = 0;
  for (const double residual : residuals) squares += residual * residual;
  const double shown = std::sqrt(squares / count);
  const double common = shown > contradicting_scatter * sigma ? count : inflation(residuals);
  return std::sqrt(common) * std::max(sigma, shown);
}

}  // namespace

PositionLevel level_by_positions(const MeasuredKeyframes& keyframes) {
  PositionLevel level;
  Places places;
  double sigma = 0;
  for (const MeasuredKeyframe& k : keyframes) {
    if (!(k.horizontal_sigma_m > 0) || !(k.vertical_sigma_m > 0)) continue;
    sigma = std::max(sigma, position_sigma(k));
    static_cast<void>(places.push_back(&k));
  }
  if (places.size() < least_positions) return level;
  const Places kept = without_outliers(places, fit_of(places));
  if (kept.size() < least_positions) return level;
  const Fit fit = fit_of(kept);
  // The errors of the positions are those that they show, where these are larger. Across a straight track nothing is
  // known of the rotation, and its residuals say nothing.
  double squares = 0;
  std::array<double, max_values> heights{};
  std::size_t count = 0;
  for (const MeasuredKeyframe* k : kept) {
    const Vec3 residual = residual_of(fit, *k);
    squares += residual.squaredNorm();
    heights[count++] = residual.z();
  }
  const double shown = std::sqrt(squares / (3 * static_cast<double>(kept.size())));
  if (!(fit.scale * fit.length_units > least_extent_sigmas * std::max(sigma, shown))) return level;
  level.known = true;
  level.long_axis = fit.long_axis;
  level.slope_rad = slope_of(fit.long_axis_known);
  level.slope_sigma_rad =
      height_error(std::span<const double>(heights).first(count), sigma) / (fit.scale * fit.length_units);
  if (fit.scale * fit.width_units > least_extent_sigmas * std::max(sigma, shown)) {
    level.level_from_strip = fit.rotation;
    level.tilt_sigma_rad = std::max(sigma, shown) / (fit.scale * fit.width_units);
    return level;
  }
  level.level_from_strip = rotation_by_slope(fit);
  return level;
}

double sigmas_from_level(const PositionLevel& level, const Mat3& level_from_strip, double tilt_sigma_rad) {
  const auto sigmas = [tilt_sigma_rad](double difference, double sigma) {
    return difference / std::sqrt(sigma * sigma + tilt_sigma_rad * tilt_sigma_rad);
  };
  const double by_slope =
      sigmas(std::fabs(slope_of(level_from_strip * level.long_axis) - level.slope_rad), level.slope_sigma_rad);
  if (!(level.tilt_sigma_rad > 0)) return by_slope;
  const double apart = (level.level_from_strip.row(2) - level_from_strip.row(2)).norm();
  return std::max(by_slope, sigmas(apart, level.tilt_sigma_rad));
}

bool positions_stand_still(const MeasuredKeyframes& keyframes) {
  const MeasuredKeyframe* before = nullptr;
  std::size_t steps = 0, still = 0;
  double way = 0, ground_distance = 0;
  for (const MeasuredKeyframe& k : keyframes) {
    if (!(k.horizontal_sigma_m > 0)) continue;
    ground_distance = std::max(ground_distance, k.ground_distance);
    if (before != nullptr) {
      ++steps;
      if (k.place_m[0] == before->place_m[0] && k.place_m[1] == before->place_m[1]) {
        ++still;
        way += (vector_of(k.centre) - vector_of(before->centre)).norm();
      }
    }
    before = &k;
  }
  constexpr std::size_t least_still = 3;
  return still >= least_still && 2 * still > steps && way > 0 && way >= 0.5 * ground_distance;
}

}  // namespace ilp::navigation
