#include "fsw/vision/multiview/resection.hpp"

#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/symmetric_solver.hpp"
#include "fsw/vision/multiview/p3p.hpp"

namespace ilp {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

constexpr int local_steps = 3;  // refinement of each new best sample
constexpr int final_steps = 10;
constexpr int final_rounds = 3;  // of selecting inliers and refining on them
constexpr std::uint32_t smallest_sample = 4;
constexpr double sample_confidence = 0.9999;  // probability that one sample was free of outliers
constexpr double smallest_spread = 4;         // of the inliers across a line, thresholds

Status check(const PointViews& views, const ResectionParams& params) {
  if (!(params.threshold_px > 0) || !(params.robust_px >= 0)) return out_of_range(Argument::resection_parameters);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const PointView& v = views[i];
    const double sum = v.position[0] + v.position[1] + v.position[2] + v.x + v.y;
    if (!std::isfinite(sum)) return out_of_range(Argument::views, i);
  }
  const std::uint32_t needed = params.min_inliers > smallest_sample ? params.min_inliers : smallest_sample;
  if (views.size() < needed) return {StatusCode::too_few_matches, static_cast<std::int64_t>(views.size()), needed};
  return {};
}

/// Squared reprojection error in px^2; beyond any threshold when the point is behind the camera.
double squared_error(const RigidTransform& pose, const CameraModel& camera, const PointView& view) {
  const Vec3 x = pose * Vec3(view.position[0], view.position[1], view.position[2]);
  if (!(x.z() > 0)) return 1e300;
  const double du = camera.fx * (x.x() / x.z()) + camera.cx - view.x;
  const double dv = camera.fy * (x.y() / x.z()) + camera.cy - view.y;
  return du * du + dv * dv;
}

/// MSAC: squared errors, limited to the threshold. Stops above `bound`.
double score(const RigidTransform& pose, const CameraModel& camera, const PointViews& views, double threshold2,
             double bound) {
  double sum = 0;
  for (const PointView& view : views) {
    const double error = squared_error(pose, camera, view);
    sum += error < threshold2 ? error : threshold2;
    if (sum >= bound) break;
  }
  return sum;
}

std::uint32_t select_inliers(const RigidTransform& pose, const CameraModel& camera, const PointViews& views,
                             double threshold2, ViewMask& inliers) {
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    inliers[i] = squared_error(pose, camera, views[i]) < threshold2 ? 1 : 0;
    count += inliers[i];
  }
  return count;
}

/// Gauss-Newton with Huber weights on the inliers; the rotation is updated from the left, in the camera's frame.
bool refine(const CameraModel& camera, const PointViews& views, const ViewMask& inliers, double robust, int steps,
            RigidTransform& pose) {
  for (int step = 0; step < steps; ++step) {
    Mat6 normal = Mat6::Zero();
    Vec6 gradient = Vec6::Zero();
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (inliers[i] == 0) continue;
      const PointView& view = views[i];
      const Vec3 p = pose * Vec3(view.position[0], view.position[1], view.position[2]);
      if (!(p.z() > 0)) return false;
      const double inverse_depth = 1 / p.z();
      const double x = p.x() * inverse_depth;
      const double y = p.y() * inverse_depth;
      const double eu = camera.fx * x + camera.cx - view.x;
      const double ev = camera.fy * y + camera.cy - view.y;
      const double norm = std::sqrt(eu * eu + ev * ev);
      const double weight = robust > 0 && norm > robust ? robust / norm : 1;
      Vec6 ju;
      Vec6 jv;
      ju << -x * y, 1 + x * x, -y, inverse_depth, 0, -x * inverse_depth;
      jv << -(1 + y * y), x * y, x, 0, inverse_depth, -y * inverse_depth;
      ju *= camera.fx;
      jv *= camera.fy;
      normal += weight * (ju * ju.transpose() + jv * jv.transpose());
      gradient += weight * (eu * ju + ev * jv);
    }
    const Vec6 change = -solve_symmetric<6>(normal, gradient);
    if (!change.allFinite()) return false;
    const Mat3 turn = rotation_from_vector(change.head<3>());
    pose.rotation = turn * pose.rotation;
    pose.translation = turn * pose.translation + change.tail<3>();
    if (change.head<3>().squaredNorm() < 1e-20 &&
        change.tail<3>().squaredNorm() < 1e-20 * pose.translation.squaredNorm()) {
      break;
    }
  }
  // Products of rotations drift from orthonormality by rounding only; the quaternion removes it.
  double q[4];
  quaternion_from_rotation(pose.rotation, q);
  pose.rotation = rotation_from_quaternion(q);
  return pose.rotation.allFinite() && pose.translation.allFinite();
}

/// Standard deviation of the inliers' image points across the line that they are nearest to, px.
double spread_across_line(const PointViews& views, const ViewMask& inliers, double count) {
  Vec2 mean = Vec2::Zero();
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (inliers[i] != 0) mean += Vec2(views[i].x, views[i].y) / count;
  }
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (inliers[i] == 0) continue;
    const Vec2 d = Vec2(views[i].x, views[i].y) - mean;
    xx += d.x() * d.x();
    xy += d.x() * d.y();
    yy += d.y() * d.y();
  }
  const double half_difference = 0.5 * (xx - yy);
  const double smaller = 0.5 * (xx + yy) - std::sqrt(half_difference * half_difference + xy * xy);
  return std::sqrt(std::fmax(0.0, smaller) / count);
}

void draw_sample(Rng& rng, std::uint32_t count, std::uint32_t sample[3]) {
  sample[0] = rng.below(count);
  sample[1] = rng.below(count - 1);
  if (sample[1] >= sample[0]) ++sample[1];
  const std::uint32_t low = sample[0] < sample[1] ? sample[0] : sample[1];
  const std::uint32_t high = sample[0] < sample[1] ? sample[1] : sample[0];
  sample[2] = rng.below(count - 2);
  if (sample[2] >= low) ++sample[2];
  if (sample[2] >= high) ++sample[2];
}

/// Trials until one sample of three is free of outliers with the given confidence.
std::uint32_t trials_needed(double inlier_share, double confidence, std::uint32_t max_trials) {
  const double all_inliers = inlier_share * inlier_share * inlier_share;
  if (all_inliers >= 1) return 1;
  if (!(1 - all_inliers < 1)) return max_trials;
  const double trials = det_log(1 - confidence) / det_log(1 - all_inliers);
  return trials < max_trials ? static_cast<std::uint32_t>(std::ceil(trials)) : max_trials;
}

struct Best {
  RigidTransform pose;
  double score = 1e300;
  bool found = false;
};

/// Takes a sample's pose if it is better than the best so far, after an improvement on its own inliers (O. Chum, J.
/// Matas, J. Kittler, "Locally optimized RANSAC", 2003).
bool consider(const RigidTransform& candidate, const CameraModel& camera, const PointViews& views,
              const ResectionParams& params, ViewMask& inliers, Best& best) {
  const double threshold2 = params.threshold_px * params.threshold_px;
  const double candidate_score = score(candidate, camera, views, threshold2, best.score);
  if (!(candidate_score < best.score)) return false;
  best = {candidate, candidate_score, true};
  RigidTransform improved = candidate;
  if (select_inliers(candidate, camera, views, threshold2, inliers) < smallest_sample) return true;
  if (!refine(camera, views, inliers, params.robust_px, local_steps, improved)) return true;
  const double improved_score = score(improved, camera, views, threshold2, best.score);
  if (improved_score < best.score) best = {improved, improved_score, true};
  return true;
}

Best search(const PointViews& views, const CameraModel& camera, const ResectionParams& params, ViewMask& inliers,
            std::uint32_t& trials) {
  const auto count = static_cast<std::uint32_t>(views.size());
  const double threshold2 = params.threshold_px * params.threshold_px;
  Rng rng(params.seed, 3);
  Best best;
  std::uint32_t needed = params.max_trials;
  for (trials = 0; trials < needed; ++trials) {
    std::uint32_t sample[3];
    draw_sample(rng, count, sample);
    Vec3 bearing[3];
    Vec3 point[3];
    for (int k = 0; k < 3; ++k) {
      const PointView& view = views[sample[k]];
      const Vec2 normalised = normalised_from_ideal(camera, Vec2(view.x, view.y));
      bearing[k] = Vec3(normalised.x(), normalised.y(), 1).normalized();
      point[k] = Vec3(view.position[0], view.position[1], view.position[2]);
    }
    RigidTransform solutions[max_p3p_solutions];
    const int solution_count = solve_p3p(bearing, point, solutions);
    bool better = false;
    for (int s = 0; s < solution_count; ++s) {
      better = consider(solutions[s], camera, views, params, inliers, best) || better;
    }
    if (!better) continue;
    const std::uint32_t agreeing = select_inliers(best.pose, camera, views, threshold2, inliers);
    needed = trials_needed(static_cast<double>(agreeing) / count, sample_confidence, params.max_trials);
  }
  return best;
}

}  // namespace

Status resect(const PointViews& views, const CameraModel& camera, const ResectionParams& params, ViewMask& inliers,
              ResectionResult& result) {
  result = {};
  inliers.clear();
  ILP_TRY(check(views, params));
  ILP_ASSERT(inliers.resize(views.size()), views.size());

  const Best best = search(views, camera, params, inliers, result.trials);
  const double threshold2 = params.threshold_px * params.threshold_px;
  RigidTransform pose = best.pose;
  std::uint32_t count = best.found ? select_inliers(pose, camera, views, threshold2, inliers) : 0;
  for (int round = 0; round < final_rounds && count >= params.min_inliers; ++round) {
    RigidTransform refined = pose;
    if (!refine(camera, views, inliers, params.robust_px, final_steps, refined)) break;
    pose = refined;
    const std::uint32_t before = count;
    count = select_inliers(pose, camera, views, threshold2, inliers);
    if (count == before) break;
  }
  if (count < params.min_inliers || count < smallest_sample) {
    return {StatusCode::no_model, count, static_cast<std::int64_t>(views.size())};
  }
  if (spread_across_line(views, inliers, count) < smallest_spread * params.threshold_px) {
    return {StatusCode::no_model, count, static_cast<std::int64_t>(views.size())};
  }
  double sum = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (inliers[i] != 0) sum += squared_error(pose, camera, views[i]);
  }
  result.cam_from_world = pose;
  result.inliers = count;
  result.rms_px = std::sqrt(sum / (2.0 * count));
  return {};
}

}  // namespace ilp
