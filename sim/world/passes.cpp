#include "sim/world/passes.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"

namespace ilp::world {
namespace {

/// From 0 at 0 to 1 at 1 with a continuous acceleration.
Course smooth_step(double u, double length_s) {
  const double v = u * (1 - u);
  return {u * u * u * (10 + u * (6 * u - 15)), 30 * v * v / length_s, 60 * v * (1 - 2 * u) / (length_s * length_s)};
}

/// From a to b as `step` goes from 0 to 1.
Course blend(const Course& a, const Course& b, const Course& step) {
  const double rest = 1 - step.value;
  return {rest * a.value + step.value * b.value, rest * a.rate + step.value * b.rate + step.rate * (b.value - a.value),
          rest * a.acceleration + step.value * b.acceleration};
}

/// Of the smallest rectangle around the first pass.
Vec2 middle_of(const GroundTrack& track, double length_m) {
  constexpr int samples = 4096;
  Vec2 low = Vec2::Zero();
  Vec2 high = Vec2::Zero();
  for (int k = 1; k <= samples; ++k) {
    const Vec2 position = track.at(length_m * k / samples).position;
    low = low.cwiseMin(position);
    high = high.cwiseMax(position);
  }
  return 0.5 * (low + high);
}

}  // namespace

int frames_of_a_pass(const FlightParams& p) {
  return (p.frames + p.passes - 1) / p.passes;
}

double time_of_frame_s(const FlightParams& p, int frame) {
  return frame * p.interval_s + frame / frames_of_a_pass(p) * p.pass_pause_s;
}

Passes::Passes(const FlightParams& params)
    : params_(params), track_(ground_track(params)), flown_s_(frames_of_a_pass(params) * params.interval_s) {
  if (params_.passes > 1) middle_ = middle_of(track_, params_.drift_m_s * flown_s_);
}

Passes::Clock Passes::clock_at(double time_s) const {
  const double period_s = flown_s_ + params_.pass_pause_s;
  const double pass = params_.passes > 1 ? std::clamp(std::floor(time_s / period_s), 0.0, params_.passes - 1.0) : 0.0;
  return {static_cast<int>(pass), time_s - pass * period_s};
}

int Passes::pass_at(double time_s) const {
  const auto [pass, passed_s] = clock_at(time_s);
  return pass + 1 < params_.passes && passed_s > flown_s_ + 0.5 * params_.pass_pause_s ? pass + 1 : pass;
}

Passes::Motion Passes::in_pass(int pass, double time_s) const {
  const double speed = params_.drift_m_s;
  const GroundTrack::Place place = track_.at(speed * time_s);
  double heading = place.heading_rad;
  Vec2 position = place.position;
  if (pass > 0) {
    const double turn = pass * params_.pass_heading_rad;
    const double c = det_cos(turn);
    const double s = det_sin(turn);
    const Vec2 offset = position - middle_;
    position = middle_ + Vec2(c * offset.x() - s * offset.y(), s * offset.x() + c * offset.y());
    heading += turn;
  }
  const double c = det_cos(heading);
  const double s = det_sin(heading);
  const double turn_rate = speed * place.curvature;
  Motion motion;
  motion.along = {position.x(), speed * c, -speed * turn_rate * s};
  motion.across = {position.y(), speed * s, speed * turn_rate * c};
  if (params_.turn_with_track) motion.yaw = {heading, turn_rate, 0};
  motion.yaw.value += pass * params_.pass_yaw_rad;
  motion.height.value = 1;
  for (int k = 0; k < pass; ++k) motion.height.value *= params_.pass_altitude;
  return motion;
}

Passes::Motion Passes::at(double time_s) const {
  const auto [pass, passed_s] = clock_at(time_s);
  const Motion now = in_pass(pass, passed_s);
  if (pass + 1 >= params_.passes || passed_s <= flown_s_) return now;
  const double pause_s = params_.pass_pause_s;
  const Motion next = in_pass(pass + 1, passed_s - flown_s_ - pause_s);
  const Course step = smooth_step((passed_s - flown_s_) / pause_s, pause_s);
  return {blend(now.along, next.along, step), blend(now.across, next.across, step), blend(now.yaw, next.yaw, step),
          blend(now.height, next.height, step)};
}

}  // namespace ilp::world
