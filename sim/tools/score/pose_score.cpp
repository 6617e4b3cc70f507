#include "sim/tools/score/pose_score.hpp"

namespace ilp::score {
namespace {

host::ErrorSummary summary_of(const std::vector<Vec3>& errors) {
  std::vector<double> lengths;
  for (const Vec3& error : errors) lengths.push_back(error.norm());
  return host::summarise(lengths);
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

}  // namespace ilp::score
