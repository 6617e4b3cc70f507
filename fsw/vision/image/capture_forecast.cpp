#include "fsw/vision/image/capture_forecast.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "fsw/base/math.hpp"
#include "fsw/vision/image/centred_similarity.hpp"
#include "fsw/vision/image/overlap.hpp"

namespace ilp {
namespace {

constexpr double seconds_per_ns = 1e-9;
// Far enough apart that the overlap has no time to fall and rise again between two of them.
constexpr int scan_steps = 16;
constexpr int bisections = 40;
constexpr int reweightings = 4;

struct Complex {
  double re = 0, im = 0;
};
Complex operator+(Complex a, Complex b) {
  return {a.re + b.re, a.im + b.im};
}
Complex operator-(Complex a, Complex b) {
  return {a.re - b.re, a.im - b.im};
}
Complex operator*(Complex a, Complex b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
Complex operator*(double s, Complex a) {
  return {s * a.re, s * a.im};
}
double squared(Complex a) {
  return a.re * a.re + a.im * a.im;
}
double length(Complex a) {
  return std::sqrt(squared(a));
}
Complex operator/(Complex a, Complex b) {
  const double n = 1 / squared(b);
  return {(a.re * b.re + a.im * b.im) * n, (a.im * b.re - a.re * b.im) * n};
}

Complex place(const PathPoint& point) {
  return {point.p_x, point.p_y};
}
Complex lie(const PathPoint& point) {
  return {point.m_re, point.m_im};
}

/// Between two places, in the first image's pixels.
struct Interval {
  Complex velocity;     // px/s
  double middle_s = 0;  // before the latest place, negative
  double weight = 0;
  double turn_rad_s = 0;
  double growth_per_s = 0;
};
using Intervals = FixedVector<Interval, decltype(ApparentPath::points)::capacity()>;

/// Motion from the latest place on: place + velocity t + acceleration t^2 / 2.
struct Motion {
  Complex velocity, acceleration;
  double turn_rad_s = 0, growth_per_s = 0;
  double velocity_error = 0;  // px/s
};

const PathPoint& latest_trusted(const ApparentPath& path) {
  for (std::size_t i = path.points.size(); i-- > 0;) {
    if (path.points[i].time_trusted) return path.points[i];
  }
  return path.keyframe;
}

std::size_t trusted_places(const ApparentPath& path) {
  std::size_t count = 0;
  for (const PathPoint& point : path.points) count += point.time_trusted ? 1 : 0;
  return count;
}

Intervals intervals_of(const ApparentPath& path, double memory) {
  Intervals intervals;
  const PathPoint& latest = latest_trusted(path);
  const PathPoint* younger = nullptr;
  double weight = 1;
  for (std::size_t i = path.points.size(); i-- > 0;) {
    if (!path.points[i].time_trusted) continue;
    if (younger == nullptr) {
      younger = &path.points[i];
      continue;
    }
    const PathPoint& a = path.points[i];
    const PathPoint& b = *younger;
    younger = &a;
    const double seconds = static_cast<double>(b.time_ns - a.time_ns) * seconds_per_ns;
    const Complex turned = lie(b) / lie(a);
    Interval interval;
    interval.velocity = (1 / seconds) * (place(b) - place(a));
    interval.middle_s = static_cast<double>(a.time_ns - latest.time_ns) * seconds_per_ns + 0.5 * seconds;
    interval.weight = weight;
    interval.turn_rad_s = det_atan2(turned.im, turned.re) / seconds;
    interval.growth_per_s = 0.5 * det_log(squared(turned)) / seconds;
    weight *= memory;
    if (!intervals.push_back(interval)) break;
  }
  return intervals;
}

struct Line {
  Complex at_zero, slope;
};

Line fit_line(const Intervals& intervals, const std::array<double, Intervals::capacity()>& weights, double trend) {
  double w = 0, wt = 0, wtt = 0;
  Complex wv, wtv;
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const double t = intervals[i].middle_s;
    w += weights[i];
    wt += weights[i] * t;
    wtt += weights[i] * t * t;
    wv = wv + weights[i] * intervals[i].velocity;
    wtv = wtv + (weights[i] * t) * intervals[i].velocity;
  }
  const double mean_t = wt / w;
  const Complex mean_v = (1 / w) * wv;
  const double spread = wtt - mean_t * wt;
  Line line{mean_v, {}};
  if (intervals.size() > 2 && spread > 0) {
    line.slope = (trend / spread) * (wtv - mean_t * wv);
    line.at_zero = mean_v - mean_t * line.slope;
  }
  return line;
}

double median_of(std::array<double, Intervals::capacity()> values, std::size_t count) {
  for (std::size_t i = 1; i < count; ++i) {
    for (std::size_t k = i; k > 0 && values[k] < values[k - 1]; --k) std::swap(values[k], values[k - 1]);
  }
  return count % 2 == 1 ? values[count / 2] : 0.5 * (values[count / 2 - 1] + values[count / 2]);
}

Motion estimate_motion(const ApparentPath& path, const ForecastParams& params) {
  const Intervals intervals = intervals_of(path, params.memory);
  const std::size_t n = intervals.size();
  std::array<double, Intervals::capacity()> weights{}, residuals{};
  for (std::size_t i = 0; i < n; ++i) weights[i] = intervals[i].weight;
  Line line = fit_line(intervals, weights, params.trend);
  for (int k = 0; k < reweightings && n > 3; ++k) {
    for (std::size_t i = 0; i < n; ++i) {
      residuals[i] = length(intervals[i].velocity - line.at_zero - intervals[i].middle_s * line.slope);
    }
    // Two standard deviations of what most intervals scatter.
    const double bound = std::max(3 * median_of(residuals, n), params.least_speed_error * length(line.at_zero));
    for (std::size_t i = 0; i < n; ++i) {
      weights[i] = intervals[i].weight * (residuals[i] > bound ? bound / residuals[i] : 1);
    }
    line = fit_line(intervals, weights, params.trend);
  }
  Motion motion;
  motion.velocity = line.at_zero;
  motion.acceleration = line.slope;
  double w = 0, ww = 0, scatter = 0;
  for (std::size_t i = 0; i < n; ++i) {
    w += weights[i];
    ww += weights[i] * weights[i];
    motion.turn_rad_s += weights[i] * intervals[i].turn_rad_s;
    motion.growth_per_s += weights[i] * intervals[i].growth_per_s;
    scatter += intervals[i].weight * squared(intervals[i].velocity - line.at_zero - intervals[i].middle_s * line.slope);
  }
  motion.turn_rad_s /= w;
  motion.growth_per_s /= w;
  const double speed = length(motion.velocity);
  // The next interval scatters about the line as the others do, and the line is known from few of them.
  const double known = w * w / ww;  // effective number of intervals
  motion.velocity_error =
      n < 3 ? params.unknown_speed_error * speed : std::sqrt(scatter / w * (known + 1) / (known - 1));
  motion.velocity_error = std::max(motion.velocity_error, params.least_speed_error * speed);
  return motion;
}

/// Of the keyframe with a frame whose centre is at `p` and which lies as `m` says, both against the first image.
double overlap_at(std::int32_t width, std::int32_t height, const PathPoint& keyframe, Complex p, Complex m) {
  const Complex m_key = lie(keyframe);
  const Complex turn = m / m_key;
  const Complex d = Complex{0, 0} - m * (p - place(keyframe));
  return footprint_overlap(width, height, about_origin({turn.re, turn.im, d.re, d.im}, width, height));
}

void evaluate(std::int32_t width, std::int32_t height, const ApparentPath& path, const Motion& motion, TimeNs time_ns,
              Forecast& forecast) {
  const PathPoint& latest = latest_trusted(path);
  const double t = static_cast<double>(time_ns - latest.time_ns) * seconds_per_ns;
  const Complex way = t * motion.velocity + (0.5 * t * t) * motion.acceleration;
  const Complex p = place(latest) + way;
  const double grown = det_exp(motion.growth_per_s * t);
  const double turned = motion.turn_rad_s * t;
  const Complex m = lie(latest) * Complex{grown * det_cos(turned), grown * det_sin(turned)};
  forecast.time_ns = time_ns;
  forecast.overlap = overlap_at(width, height, path.keyframe, p, m);
  const double all = length(p - place(path.keyframe));
  const double error = motion.velocity_error * std::fabs(t);
  const Complex along = all > 0 ? (error / all) * (p - place(path.keyframe)) : Complex{error, 0};
  const double less = overlap_at(width, height, path.keyframe, p - along, m);
  const double more = overlap_at(width, height, path.keyframe, p + along, m);
  forecast.sigma = 0.5 * std::fabs(less - more);
}

}  // namespace

void begin_path(TimeNs keyframe_ns, ApparentPath& path) {
  path = {};
  path.keyframe.time_ns = keyframe_ns;
  static_cast<void>(path.points.push_back(path.keyframe));
}

bool extend_path(std::int32_t width, std::int32_t height, TimeNs frame_ns, const Similarity2& frame_from_keyframe,
                 bool time_trusted, ApparentPath& path) {
  if (path.points.empty() || frame_ns <= path.points.back().time_ns || !(frame_from_keyframe.scale > 0)) return false;
  const double cx = 0.5 * (width - 1), cy = 0.5 * (height - 1);
  const Complex m{frame_from_keyframe.scale * det_cos(frame_from_keyframe.rotation_rad),
                  frame_from_keyframe.scale * det_sin(frame_from_keyframe.rotation_rad)};
  const Complex centre{cx, cy};
  const Complex d = m * centre + Complex{frame_from_keyframe.shift_x_px, frame_from_keyframe.shift_y_px} - centre;
  const Complex m_key = lie(path.keyframe);
  // The frame's centre in the keyframe, then in the first image.
  const Complex p = place(path.keyframe) - (d / m) / m_key;
  const Complex m_first = m * m_key;
  if (path.points.full()) {
    for (std::size_t i = 1; i < path.points.size(); ++i) path.points[i - 1] = path.points[i];
    path.points.pop_back();
  }
  return path.points.push_back({frame_ns, p.re, p.im, m_first.re, m_first.im, time_trusted});
}

bool select_place(TimeNs keyframe_ns, ApparentPath& path) {
  for (const PathPoint& point : path.points) {
    if (point.time_ns != keyframe_ns) continue;
    path.keyframe = point;
    return true;
  }
  return false;
}

Forecast forecast_overlap(std::int32_t width, std::int32_t height, const ApparentPath& path,
                          const ForecastParams& params, TimeNs time_ns) {
  Forecast forecast;
  forecast.time_ns = time_ns;
  if (trusted_places(path) < 2) return forecast;
  const Motion motion = estimate_motion(path, params);
  forecast.known = true;
  forecast.speed_px_s = length(motion.velocity) * length(lie(path.keyframe));
  evaluate(width, height, path, motion, time_ns, forecast);
  forecast.reached = forecast.overlap <= params.target_overlap;
  return forecast;
}

Forecast forecast_capture(std::int32_t width, std::int32_t height, const ApparentPath& path,
                          const ForecastParams& params, TimeNs earliest_ns, TimeNs latest_ns) {
  Forecast forecast = forecast_overlap(width, height, path, params, earliest_ns);
  if (!forecast.known || forecast.reached || latest_ns <= earliest_ns) return forecast;
  const Motion motion = estimate_motion(path, params);
  TimeNs above = earliest_ns, below = latest_ns;
  const TimeNs stride = std::max<TimeNs>((latest_ns - earliest_ns) / scan_steps, 1);
  for (int k = 1; k <= scan_steps && !forecast.reached; ++k) {
    below = k == scan_steps ? latest_ns : std::min(earliest_ns + k * stride, latest_ns);
    evaluate(width, height, path, motion, below, forecast);
    forecast.reached = forecast.overlap <= params.target_overlap;
    if (!forecast.reached) above = below;
  }
  if (!forecast.reached) return forecast;
  for (int k = 0; k < bisections && below - above > 1; ++k) {
    const TimeNs middle = above + (below - above) / 2;
    evaluate(width, height, path, motion, middle, forecast);
    (forecast.overlap <= params.target_overlap ? below : above) = middle;
  }
  evaluate(width, height, path, motion, below, forecast);
  return forecast;
}

}  // namespace ilp
