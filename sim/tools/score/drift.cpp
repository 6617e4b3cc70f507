#include "sim/tools/score/drift.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>

#include "fsw/base/math.hpp"

namespace ilp::score {
namespace {

std::optional<host::Similarity3> align_samples(const StripTrack& track, std::size_t count) {
  const host::CameraTrack estimate = track.estimate(count), truth = track.truth(count);
  return host::align_cameras(estimate.centres, estimate.cam_from_world, truth.centres, truth.cam_from_world,
                             track.flying_height);
}

struct Step {
  double middle = 0;    // distance flown
  double length = 0;    // true
  double estimate = 0;  // strip unit
};

std::vector<Step> steps_of(const StripTrack& track, const std::vector<double>& distance) {
  std::vector<Step> steps;
  for (std::size_t i = 1; i < track.samples.size(); ++i) {
    const double estimate = (track.samples[i].centre - track.samples[i - 1].centre).norm();
    steps.push_back({0.5 * (distance[i] + distance[i - 1]), distance[i] - distance[i - 1], estimate});
  }
  return steps;
}

bool usable(const Step& step) {
  return step.length > 0 && step.estimate > 0;
}

// Slope of the logarithm of the local scale, per unit of distance.
std::optional<double> scale_slope(const std::vector<Step>& steps) {
  double weight = 0, x = 0, y = 0, xx = 0, xy = 0;
  std::size_t count = 0;
  for (const Step& s : steps) {
    if (!usable(s)) continue;
    const double w = s.length * s.length;
    weight += w;
    x += w * s.middle;
    y += w * det_log(s.estimate / s.length);
    ++count;
  }
  if (count + 1 < fewest_poses_of_drift) return std::nullopt;
  for (const Step& s : steps) {
    if (!usable(s)) continue;
    const double w = s.length * s.length, dx = s.middle - x / weight;
    xx += w * dx * dx;
    xy += w * dx * (det_log(s.estimate / s.length) - y / weight);
  }
  return xx > 0 ? std::optional(xy / xx) : std::nullopt;
}

Vec3 main_direction(const StripTrack& track) {
  Vec3 mean = Vec3::Zero();
  for (const PoseSample& s : track.samples) mean += s.true_centre / static_cast<double>(track.samples.size());
  Mat3 scatter = Mat3::Zero();
  for (const PoseSample& s : track.samples) scatter += (s.true_centre - mean) * (s.true_centre - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(scatter);
  const Vec3 direction = solver.eigenvectors().col(2);
  return direction.dot(track.samples.back().true_centre - track.samples.front().true_centre) < 0 ? -direction
                                                                                                 : direction;
}

bool fit_parabola(const std::vector<double>& u, const std::vector<double>& h, double (&fit)[3]) {
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (std::size_t i = 0; i < u.size(); ++i) {
    const Vec3 row(1, u[i], u[i] * u[i]);
    normal += row * row.transpose();
    right += h[i] * row;
  }
  const Eigen::FullPivLU<Mat3> solver(normal);
  if (!solver.isInvertible()) return false;
  const Vec3 solution = solver.solve(right);
  for (int k = 0; k < 3; ++k) fit[k] = solution[k];
  return true;
}

/// `too_high` says by how much the camera of a sample is too high, truth's unit, for a scale of the strip.
template <typename TooHigh>
std::optional<Bow> measure_bow(const StripTrack& track, TooHigh too_high) {
  if (track.samples.size() < fewest_poses_of_drift || !(track.flying_height > 0)) return std::nullopt;
  const std::vector<double> distance = distance_flown(track);
  const auto alignment = align_samples(track, track.samples.size());
  if (!alignment || !(distance.back() > 0)) return std::nullopt;
  Bow bow;
  const Vec3 up = track_axes(track).up;
  std::vector<double> u;
  for (std::size_t i = 0; i < track.samples.size(); ++i) {
    const PoseSample& s = track.samples[i];
    bow.height_error.push_back(up.dot(*alignment * s.centre - s.true_centre) - too_high(s, alignment->scale));
    u.push_back(2 * distance[i] / distance.back() - 1);
  }
  if (!fit_parabola(u, bow.height_error, bow.fit)) return std::nullopt;
  bow.sagitta = -bow.fit[2];
  bow.percent = 100 * bow.sagitta / track.flying_height;
  return bow;
}

}  // namespace

TrackAxes track_axes(const StripTrack& track) {
  Vec3 back = Vec3::Zero();
  for (const PoseSample& s : track.samples) back -= s.true_cam_from_world.row(2).transpose();
  TrackAxes axes;
  axes.forward = main_direction(track);
  const Vec3 up = back - back.dot(axes.forward) * axes.forward;
  // A camera that looks along the track has no height to speak of; any perpendicular direction does.
  axes.up = up.norm() > 1e-6 * back.norm() ? up.normalized() : axes.forward.unitOrthogonal();
  return axes;
}

std::optional<Drift> measure_drift(const StripTrack& track) {
  const std::size_t n = track.samples.size();
  const double length = n < fewest_poses_of_drift ? 0 : distance_flown(track).back();
  if (!(length > 0)) return std::nullopt;
  Drift drift;
  drift.aligned_samples = std::max(fewest_poses, (n + 3) / 4);
  const auto alignment = align_samples(track, drift.aligned_samples);
  if (!alignment) return std::nullopt;
  for (const PoseSample& s : track.samples) drift.error.push_back(*alignment * s.centre - s.true_centre);
  drift.end_error = drift.error.back().norm();
  drift.percent = 100 * drift.end_error / length;
  return drift;
}

std::optional<ScaleDrift> measure_scale_drift(const StripTrack& track) {
  if (track.samples.size() < fewest_poses_of_drift) return std::nullopt;
  const std::vector<double> distance = distance_flown(track);
  const std::vector<Step> steps = steps_of(track, distance);
  const auto slope = scale_slope(steps);
  if (!slope) return std::nullopt;
  ScaleDrift drift;
  drift.percent = 100 * (det_exp(*slope * distance.back()) - 1);
  double path = 0;
  for (const Step& s : steps) path += s.estimate;
  for (std::size_t i = 0; i < track.samples.size(); ++i) {
    // Two steps to either side: one alone is mostly noise.
    double estimate = 0, length = 0;
    for (std::size_t k = i < 2 ? 0 : i - 2; k < std::min(i + 2, steps.size()); ++k) {
      estimate += steps[k].estimate;
      length += steps[k].length;
    }
    drift.local_scale.push_back(length > 0 ? estimate / length * distance.back() / path : 0);
  }
  return drift;
}

std::optional<Bow> measure_bow(const StripTrack& track) {
  return measure_bow(track, [](const PoseSample&, double) { return 0.0; });
}

std::optional<double> bow_after_heights_percent(const StripTrack& track) {
  StripTrack measured = track;
  std::erase_if(measured.samples,
                [](const PoseSample& s) { return !(s.ground_distance > 0 && s.measured_height_m > 0); });
  const auto bow = measure_bow(
      measured, [](const PoseSample& s, double scale) { return scale * s.ground_distance - s.measured_height_m; });
  return bow ? std::optional(bow->percent) : std::nullopt;
}

}  // namespace ilp::score
