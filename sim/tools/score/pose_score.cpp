#include "sim/tools/score/pose_score.hpp"

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp::score {
namespace {

struct Columns {
  std::vector<Vec3> centres, true_centres;
  std::vector<Mat3> attitudes, true_attitudes;
};

Columns columns_of(const StripTrack& track) {
  Columns c;
  for (const PoseSample& s : track.samples) {
    c.centres.push_back(s.centre);
    c.true_centres.push_back(s.true_centre);
    c.attitudes.push_back(s.cam_from_world);
    c.true_attitudes.push_back(s.true_cam_from_world);
  }
  return c;
}

ground::ErrorSummary residuals(const ground::Similarity3& alignment, const Columns& c) {
  std::vector<double> lengths;
  for (std::size_t i = 0; i < c.centres.size(); ++i) {
    lengths.push_back((alignment * c.centres[i] - c.true_centres[i]).norm());
  }
  return ground::summarise(lengths);
}

}  // namespace

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
  const Columns c = columns_of(track);
  if (c.centres.size() < fewest_poses) return std::nullopt;
  const auto alignment = ground::align_positions(c.centres, c.true_centres);
  PoseScore score;
  score.distance = distance_flown(track);
  if (!alignment || !(score.length() > 0)) return std::nullopt;
  score.true_from_strip = *alignment;
  score.position = residuals(*alignment, c);
  if (track.metric) {
    if (const auto rigid = ground::align_rigid(c.centres, c.true_centres)) score.position_rigid = residuals(*rigid, c);
  }
  const Mat3 true_from_strip = ground::align_attitudes(c.attitudes, c.true_attitudes);
  for (std::size_t i = 0; i < c.centres.size(); ++i) {
    score.error.push_back(*alignment * c.centres[i] - c.true_centres[i]);
    score.rotation_rad.push_back(rotation_angle(c.true_attitudes[i] * true_from_strip * c.attitudes[i].transpose()));
  }
  return score;
}

}  // namespace ilp::score
