#include "sim/tools/score/pose_score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ilp::score {
namespace {

host::ErrorSummary summary_of(const std::vector<Vec3>& errors) {
  std::vector<double> lengths;
  for (const Vec3& error : errors) lengths.push_back(error.norm());
  return host::summarise(lengths);
}

double share(std::size_t part, std::size_t all) {
  return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

host::CameraTrack StripTrack::estimate(std::size_t count) const {
  host::CameraTrack track;
  for (std::size_t i = 0; i < count; ++i) track.add(samples[i].centre, samples[i].cam_from_world);
  return track;
}

host::CameraTrack StripTrack::truth(std::size_t count) const {
  host::CameraTrack track;
  for (std::size_t i = 0; i < count; ++i) track.add(samples[i].true_centre, samples[i].true_cam_from_world);
  return track;
}

std::vector<double> distance_flown(const StripTrack& track) {
  std::vector<double> distance;
  for (std::size_t i = 0; i < track.samples.size(); ++i) {
    const double before = i == 0 ? 0 : distance.back();
    const double step = i == 0 ? 0 : (track.samples[i].true_centre - track.samples[i - 1].true_centre).norm();
    distance.push_back(before + step);
  }
  return distance;
}

std::optional<PoseScore> score_poses(const StripTrack& track) {
  if (track.samples.size() < fewest_poses) return std::nullopt;
  const host::CameraTrack estimate = track.estimate(track.samples.size()), truth = track.truth(track.samples.size());
  const auto errors = host::track_errors(estimate, truth);
  PoseScore score;
  score.distance = distance_flown(track);
  if (!errors || !(score.length() > 0)) return std::nullopt;
  score.true_from_strip = errors->reference_from_track;
  score.error = errors->position;
  score.position = summary_of(errors->position);
  score.rotation_rad = errors->rotation_rad;
  if (track.metric) {
    const auto rigid = host::align_rigid(estimate.centres, truth.centres);
    if (rigid) score.position_rigid = summary_of(host::position_errors(*rigid, estimate, truth));
  }
  return score;
}

void SigmaScore::add(const SigmaScore& other) {
  components += other.components;
  within_one += other.within_one;
  within_two += other.within_two;
  squared_sum += other.squared_sum;
  error.insert(other.error.begin(), other.error.end());
}

void SigmaScore::count(double normalised) {
  ++components;
  within_one += std::fabs(normalised) <= 1 ? 1U : 0U;
  within_two += std::fabs(normalised) <= 2 ? 1U : 0U;
}

double SigmaScore::share_within_one() const {
  return share(within_one, components);
}
double SigmaScore::share_within_two() const {
  return share(within_two, components);
}
double SigmaScore::normalised_error_squared() const {
  return components > 0 ? squared_sum / static_cast<double>(components) : std::numeric_limits<double>::quiet_NaN();
}

std::optional<host::Similarity3> strip_from_true(const StripTrack& track) {
  if (!track.from_the_start || track.samples.size() < 2) return std::nullopt;
  const PoseSample& first = track.samples[0];
  const PoseSample& second = track.samples[1];
  const double length = (second.true_centre - first.true_centre).norm();
  if (!(length > 0)) return std::nullopt;
  host::Similarity3 alignment;
  alignment.scale = (second.centre - first.centre).norm() / length;
  alignment.rotation = first.cam_from_world.transpose() * first.true_cam_from_world;
  alignment.translation = first.centre - alignment.scale * (alignment.rotation * first.true_centre);
  return alignment;
}

SigmaScore score_sigmas(const StripTrack& track) {
  SigmaScore score;
  const auto gauge = strip_from_true(track);
  if (!gauge) return score;
  for (std::size_t i = 2; i < track.samples.size(); ++i) {
    const PoseSample& s = track.samples[i];
    if (!(s.sigma.minCoeff() > 0)) continue;
    const Vec3 error = s.centre - *gauge * s.true_centre;
    score.error[s.keyframe_id] = error;
    for (int k = 0; k < 3; ++k) {
      const double normalised = error[k] / s.sigma[k];
      score.count(normalised);
      score.squared_sum += normalised * normalised;
    }
  }
  return score;
}

}  // namespace ilp::score
