#include "fsw/vision/navigation/sample_filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/navigation/robust_mean.hpp"

namespace ilp::navigation {
namespace {

constexpr std::size_t max_pairs = max_window_samples * (max_window_samples - 1) / 2;

struct TimedValue {
  double time_s = 0;  ///< from the moment that is asked for
  double value = 0;
  double sigma = 0;
};
using TimedValues = FixedVector<TimedValue, max_window_samples>;

TimeNs distance(const NavigationSample& sample, TimeNs time) {
  return sample.time_ns > time ? sample.time_ns - time : time - sample.time_ns;
}

bool covers(const TimedValues& values) {
  double first = 1e9, last = -1e9;
  for (const TimedValue& v : values) {
    first = std::min(first, v.time_s);
    last = std::max(last, v.time_s);
  }
  constexpr double near_s = 0.2 * static_cast<double>(window_ns) / 1e9;
  return first <= near_s && last >= -near_s;
}

/// Median of the slopes of all pairs (P. K. Sen, 1968).
double slope_of(const TimedValues& values) {
  std::array<double, max_pairs> slopes;
  std::size_t count = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const double dt = values[i].time_s - values[k].time_s;
      if (std::fabs(dt) > 1e-3) slopes[count++] = (values[i].value - values[k].value) / dt;
    }
  }
  return values.size() < 4 ? 0 : median_of(std::span(slopes).first(count));
}

/// The line's value at time 0. `mean.used` is 0 if the values do not cover it.
RobustMean at_zero(const TimedValues& values) {
  if (values.empty() || !covers(values)) return {};
  const double slope = slope_of(values);
  Measurements level;
  for (const TimedValue& v : values) static_cast<void>(level.push_back({v.value - slope * v.time_s, v.sigma}));
  return robust_mean(level);
}

template <typename Known, typename Value, typename Sigma>
TimedValues collect(const WindowSamples& samples, TimeNs time, Known known, Value value, Sigma sigma) {
  TimedValues values;
  for (const NavigationSample& s : samples) {
    if (!known(s)) continue;
    static_cast<void>(values.push_back({static_cast<double>(s.time_ns - time) / 1e9, value(s), sigma(s)}));
  }
  return values;
}

void count(const RobustMean& mean, SampleCounts& counts) {
  counts.refused += mean.refused;
}

/// Errors of positions and velocities change slowly, so that a mean over a window is not better than one of them.
double own_sigma(const TimedValues& values) {
  double sum = 0;
  for (const TimedValue& v : values) sum += v.sigma;
  return sum / static_cast<double>(values.size());
}

void measure_height(const WindowSamples& samples, TimeNs time, NavigationSample& out, SampleCounts& counts) {
  const auto sigma = [](const NavigationSample& s) { return s.height_sigma_m; };
  const RobustMean mean = at_zero(collect(
      samples, time, [&](const NavigationSample& s) { return sigma(s) > 0; },
      [](const NavigationSample& s) { return s.height_m; }, sigma));
  count(mean, counts);
  if (mean.used == 0) return;
  out.height_m = mean.value;
  out.height_sigma_m = mean.sigma;
}

/// The turns from one of the attitudes to the others, as vectors, lie on a line like any other quantity.
void measure_attitude(const WindowSamples& samples, TimeNs time, NavigationSample& out, SampleCounts& counts) {
  const NavigationSample* nearest = nullptr;
  bool heading = true;
  for (const NavigationSample& s : samples) {
    if (!(s.tilt_sigma_rad > 0)) continue;
    if (nearest == nullptr || distance(s, time) < distance(*nearest, time)) nearest = &s;
    heading = heading && s.heading_sigma_rad > 0;
  }
  if (nearest == nullptr) return;
  const Mat3 reference = rotation_from_quaternion(nearest->q_cam_from_level);
  Vec3 turn;
  double sigma = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const RobustMean mean = at_zero(collect(
        samples, time, [](const NavigationSample& s) { return s.tilt_sigma_rad > 0; },
        [&](const NavigationSample& s) {
          return vector_from_rotation(rotation_from_quaternion(s.q_cam_from_level) * reference.transpose())[axis];
        },
        [](const NavigationSample& s) { return s.tilt_sigma_rad; }));
    if (axis == 0) count(mean, counts);
    if (mean.used == 0) return;
    turn[axis] = mean.value;
    sigma = std::max(sigma, mean.sigma);
  }
  RigidTransform attitude;
  attitude.rotation = rotation_from_vector(turn) * reference;
  const Pose pose = pose_from(attitude);
  std::copy_n(pose.q_cam_from_world, 4, out.q_cam_from_level);
  out.tilt_sigma_rad = sigma;
  out.heading_sigma_rad = heading ? std::max(nearest->heading_sigma_rad, sigma) : 0;
}

void measure_position(const WindowSamples& samples, TimeNs time, NavigationSample& out, SampleCounts& counts) {
  // Only the relative size of these sigmas matters for the line; a degree is at least this long on every body flown.
  constexpr double shortest_degree_m = 3e4;
  const auto known = [](const NavigationSample& s) { return s.horizontal_sigma_m > 0; };
  const auto sigma = [](const NavigationSample& s) { return s.horizontal_sigma_m / shortest_degree_m; };
  double first = 0;
  for (const NavigationSample& s : samples) {
    if (known(s)) first = s.longitude_deg;
  }
  const TimedValues longitudes = collect(
      samples, time, known,
      [first](const NavigationSample& s) {
        const double turn = s.longitude_deg - first;
        return turn - 360 * std::floor(turn / 360 + 0.5);
      },
      sigma);
  const TimedValues latitudes = collect(
      samples, time, known, [](const NavigationSample& s) { return s.latitude_deg; }, sigma);
  const RobustMean longitude = at_zero(longitudes), latitude = at_zero(latitudes);
  count(latitude, counts);
  if (longitude.used == 0 || latitude.used == 0) return;
  out.longitude_deg = first + longitude.value;
  out.latitude_deg = latitude.value;
  out.horizontal_sigma_m = shortest_degree_m * own_sigma(latitudes);
  const TimedValues elevations = collect(
      samples, time, [](const NavigationSample& s) { return s.vertical_sigma_m > 0; },
      [](const NavigationSample& s) { return s.elevation_m; },
      [](const NavigationSample& s) { return s.vertical_sigma_m; });
  const RobustMean elevation = at_zero(elevations);
  if (elevation.used == 0) return;
  out.elevation_m = elevation.value;
  out.vertical_sigma_m = own_sigma(elevations);
}

void measure_velocity(const WindowSamples& samples, TimeNs time, NavigationSample& out, SampleCounts& counts) {
  double sigma = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const TimedValues values = collect(
        samples, time, [](const NavigationSample& s) { return s.velocity_sigma_m_s > 0; },
        [axis](const NavigationSample& s) { return s.velocity_m_s[axis]; },
        [](const NavigationSample& s) { return s.velocity_sigma_m_s; });
    const RobustMean mean = at_zero(values);
    if (axis == 0) count(mean, counts);
    if (mean.used == 0) return;
    out.velocity_m_s[axis] = mean.value;
    sigma = own_sigma(values);
  }
  out.velocity_sigma_m_s = sigma;
}

}  // namespace

void add_near(const NavigationSample& sample, TimeNs time, WindowSamples& samples) {
  if (distance(sample, time) > window_ns || samples.push_back(sample)) return;
  NavigationSample* const farthest = std::max_element(
      samples.begin(), samples.end(),
      [time](const NavigationSample& a, const NavigationSample& b) { return distance(a, time) < distance(b, time); });
  if (distance(sample, time) < distance(*farthest, time)) *farthest = sample;
}

NavigationSample measure_at(const WindowSamples& samples, TimeNs time, SampleCounts& counts) {
  NavigationSample out;
  out.time_ns = time;
  counts.offered = static_cast<std::uint32_t>(samples.size());
  measure_height(samples, time, out, counts);
  measure_attitude(samples, time, out, counts);
  measure_position(samples, time, out, counts);
  measure_velocity(samples, time, out, counts);
  return out;
}

}  // namespace ilp::navigation
