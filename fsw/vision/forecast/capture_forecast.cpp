#include "fsw/vision/forecast/capture_forecast.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fsw/base/math.hpp"

namespace ilp {
namespace {

constexpr double seconds_per_ns = 1e-9;
// Close enough that the overlap cannot fall and rise again between two of them.
constexpr int scan_steps = 16;
constexpr TimeNs resolution_ns = 100'000;
// Gusts as shares of the mean speed, swings as shares of the image's width.
constexpr double gust_shares[] = {0.03, 0.1, 0.3};
constexpr double swing_shares[] = {0.005, 0.015, 0.04};
// A hovering balloon also moves: shares of the image's width per second.
constexpr double least_speed_share = 0.002;
// Before any measurement a swing is as likely as none.
constexpr double prior_of_swing = 0.5;
constexpr double negligible = 1e-3;
// The mean speed is not known in advance; times that of the whole path.
constexpr double unlikely_speed = 10;
constexpr double gust_time_s = 40;      // how long a gust lasts
constexpr double swing_time_s = 250;    // how long a swing remembers its phase
constexpr double shortest_swing_s = 5;  // a gondola on a few metres of rope
constexpr double longest_swing_s = 40;
// Of a measured place: mostly relief and tilt, as the registration itself is better.
constexpr double noise_px = 1;
// Of a swing taken from the camera's attitude: not all tilt is swing.
constexpr double tilt_noise_px = 1.5;
// True errors over those that the models expect, because real winds follow no model.
constexpr double misfit = 1.4;
// Recent intervals are more representative of how fast the image turns and grows.
constexpr double attitude_memory = 0.6;

double seconds_between(TimeNs from, TimeNs to) {
  return static_cast<double>(to - from) * seconds_per_ns;
}

}  // namespace

void MotionForecast::make_hypotheses(std::int32_t width, double speed_px_s) {
  hypotheses_.clear();
  for (const double gust : gust_shares) {
    Hypothesis still;
    still.model.gust_px_s = gust * speed_px_s;
    still.model.gust_time_s = gust_time_s;
    still.model.swing_time_s = swing_time_s;
    still.model.noise_px = noise_px;
    still.model.tilt_noise_px = tilt_noise_px;
    still.weight = 1 - prior_of_swing;
    static_cast<void>(hypotheses_.push_back(still));
    for (std::size_t k = 0; k < swing_periods; ++k) {
      // Equal steps of frequency, because the error of a phase is the frequency's error times the time.
      const double share = static_cast<double>(k) / (swing_periods - 1);
      const double hertz = (1 - share) / longest_swing_s + share / shortest_swing_s;
      for (const double swing : swing_shares) {
        Hypothesis swinging = still;
        swinging.model.swing_px = swing * width;
        swinging.model.swing_rad_s = 2 * pi * hertz;
        swinging.weight = prior_of_swing / static_cast<double>(swing_periods * swing_sizes);
        static_cast<void>(hypotheses_.push_back(swinging));
      }
    }
  }
}

void MotionForecast::follow(const ApparentPath& path, Hypothesis& hypothesis, double speed_px_s) const {
  TimeNs time = 0;
  for (const PathPoint& point : path.points) {
    if (!point.time_trusted) continue;
    if (hypothesis.filter.places == 0) {
      begin_drift(hypothesis.model, point.p_x, point.p_y, unlikely_speed * speed_px_s, hypothesis.filter);
    } else {
      predict_drift(hypothesis.model, seconds_between(time, point.time_ns), hypothesis.filter);
      measure_drift(hypothesis.model, point.p_x, point.p_y, hypothesis.filter);
    }
    if (point.tilt_known) measure_tilt(hypothesis.model, point.tilt_x, point.tilt_y, hypothesis.filter);
    time = point.time_ns;
  }
}

void MotionForecast::keep_best() {
  double best = hypotheses_[0].filter.log_likelihood;
  for (const Hypothesis& hypothesis : hypotheses_) best = std::max(best, hypothesis.filter.log_likelihood);
  for (Hypothesis& hypothesis : hypotheses_) hypothesis.weight *= det_exp(hypothesis.filter.log_likelihood - best);
  const std::size_t count = std::min(kept, hypotheses_.size());
  for (std::size_t i = 0; i < count; ++i) {
    std::size_t heaviest = i;
    for (std::size_t k = i + 1; k < hypotheses_.size(); ++k) {
      if (hypotheses_[k].weight > hypotheses_[heaviest].weight) heaviest = k;
    }
    std::swap(hypotheses_[i], hypotheses_[heaviest]);
  }
  // bound: the hypotheses; the first one stays
  while (hypotheses_.size() > count || hypotheses_.back().weight < negligible * hypotheses_[0].weight) {
    hypotheses_.pop_back();
  }
  double sum = 0;
  for (const Hypothesis& hypothesis : hypotheses_) sum += hypothesis.weight;
  for (Hypothesis& hypothesis : hypotheses_) hypothesis.weight /= sum;
}

void MotionForecast::fit_attitude(const ApparentPath& path) {
  double weight = 1, weights = 0, turn = 0, growth = 0;
  const PathPoint* younger = nullptr;
  for (std::size_t i = path.points.size(); i-- > 0;) {
    const PathPoint& older = path.points[i];
    if (!older.time_trusted) continue;
    if (younger != nullptr) {
      const double seconds = seconds_between(older.time_ns, younger->time_ns);
      const double n = older.m_re * older.m_re + older.m_im * older.m_im;
      const double re = (younger->m_re * older.m_re + younger->m_im * older.m_im) / n;
      const double im = (younger->m_im * older.m_re - younger->m_re * older.m_im) / n;
      turn += weight * det_atan2(im, re) / seconds;
      growth += weight * 0.5 * det_log(re * re + im * im) / seconds;
      weights += weight;
      weight *= attitude_memory;
    }
    younger = &older;
  }
  turn_rad_s_ = turn / weights;
  growth_per_s_ = growth / weights;
}

void MotionForecast::fit(std::int32_t width, std::int32_t height, const ApparentPath& path, double target_overlap) {
  target_overlap_ = target_overlap;
  width_ = width;
  height_ = height;
  keyframe_ = path.keyframe;
  const PathPoint* first = nullptr;
  std::size_t trusted = 0;
  for (const PathPoint& point : path.points) {
    if (!point.time_trusted) continue;
    if (first == nullptr) first = &point;
    latest_ = point;
    ++trusted;
  }
  known_ = trusted >= 2;
  if (!known_) return;
  const double x = latest_.p_x - first->p_x, y = latest_.p_y - first->p_y;
  const double seconds = seconds_between(first->time_ns, latest_.time_ns);
  const double scale = std::sqrt(latest_.m_re * latest_.m_re + latest_.m_im * latest_.m_im);
  const double speed = std::max(std::sqrt(x * x + y * y) / seconds, least_speed_share * width / scale);
  make_hypotheses(width, speed);
  for (Hypothesis& hypothesis : hypotheses_) follow(path, hypothesis, speed);
  keep_best();
  fit_attitude(path);
}

double MotionForecast::speed_px_s() const {
  double x = 0, y = 0;
  for (const Hypothesis& hypothesis : hypotheses_) {
    x += hypothesis.weight * (hypothesis.filter.mean[0][1] + hypothesis.filter.mean[0][2]);
    y += hypothesis.weight * (hypothesis.filter.mean[1][1] + hypothesis.filter.mean[1][2]);
  }
  return std::sqrt((x * x + y * y) * (keyframe_.m_re * keyframe_.m_re + keyframe_.m_im * keyframe_.m_im));
}

MotionForecast::Overlap MotionForecast::overlap_at(TimeNs time_ns) const {
  const double seconds = std::max(seconds_between(latest_.time_ns, time_ns), 0.0);
  double x = 0, y = 0, squares = 0, variance = 0;
  for (const Hypothesis& hypothesis : hypotheses_) {
    DriftFilter filter = hypothesis.filter;
    predict_drift(hypothesis.model, seconds, filter);
    const Place place = place_of(filter);
    x += hypothesis.weight * place.x;
    y += hypothesis.weight * place.y;
    squares += hypothesis.weight * (place.x * place.x + place.y * place.y);
    variance += hypothesis.weight * place.variance;
  }
  // The hypotheses' own error, and their disagreement (over both axes).
  const double error = misfit * std::sqrt(variance + 0.5 * std::max(squares - x * x - y * y, 0.0));
  const double grown = det_exp(growth_per_s_ * seconds);
  const double c = grown * det_cos(turn_rad_s_ * seconds), s = grown * det_sin(turn_rad_s_ * seconds);
  const double m_re = latest_.m_re * c - latest_.m_im * s, m_im = latest_.m_re * s + latest_.m_im * c;
  const double way_x = x - keyframe_.p_x, way_y = y - keyframe_.p_y;
  const double way = std::sqrt(way_x * way_x + way_y * way_y);
  const double along_x = way > 0 ? error * way_x / way : error, along_y = way > 0 ? error * way_y / way : 0;
  Overlap result;
  result.overlap = overlap_of_places(width_, height_, keyframe_, x, y, m_re, m_im);
  const double less = overlap_of_places(width_, height_, keyframe_, x - along_x, y - along_y, m_re, m_im);
  const double more = overlap_of_places(width_, height_, keyframe_, x + along_x, y + along_y, m_re, m_im);
  result.sigma = 0.5 * std::fabs(less - more);
  return result;
}

TimeNs MotionForecast::time_of_target(TimeNs earliest_ns, TimeNs latest_ns) const {
  if (overlap_at(earliest_ns).overlap <= target_overlap_ || latest_ns <= earliest_ns) return earliest_ns;
  TimeNs above = earliest_ns, below = latest_ns;
  bool reached = false;
  // The steps grow, because the target is rarely far, and a hover makes the search long.
  for (int k = 1; k <= scan_steps && !reached; ++k) {
    const double share = static_cast<double>(k * k) / (scan_steps * scan_steps);
    below = earliest_ns + static_cast<TimeNs>(share * static_cast<double>(latest_ns - earliest_ns));
    reached = overlap_at(below).overlap <= target_overlap_;
    if (!reached) above = below;
  }
  if (!reached) return latest_ns;
  while (below - above > resolution_ns) {  // bound: 63 halves of the interval
    const TimeNs middle = above + (below - above) / 2;
    (overlap_at(middle).overlap <= target_overlap_ ? below : above) = middle;
  }
  return below;
}

}  // namespace ilp
