#include "sim/tools/score/fix_score.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "fsw/vision/geometry/camera.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::score {
namespace {

/// Where a view of the true camera meets level ground at the height of the fix's ground point.
Vec2 true_ground(const report::ReferencePose& pose, const Vec2& normalised, double height) {
  const Vec3 ray = pose.cam_from_world.transpose() * Vec3(normalised.x(), normalised.y(), 1);
  return (pose.centre + (height - pose.centre.z()) / ray.z() * ray).head<2>();
}

/// The view of the true camera at the pixel that the flight takes for its principal point.
Vec2 flight_axis(const intake::Flight& flight, const std::optional<CameraModel>& camera) {
  if (!camera || !flight.camera) return Vec2::Zero();
  return normalised_from_pixel(*camera, {flight.camera->cx, flight.camera->cy});
}

Mat3 centre_covariance(const FixRecord& fix) {
  Mat3 out;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k <= i; ++k) out(i, k) = out(k, i) = fix.covariance[(i + 3) * (i + 4) / 2 + k + 3];
  }
  return out;
}

void add_fix(const FixRecord& fix, const report::ReferencePose& pose, const Vec2& axis, FixScore& score) {
  const bool accepted = fix.state == FixState::accepted;
  ++score.fixed;
  score.accepted += accepted ? 1U : 0U;
  const Vec2 error = Vec2(fix.ground_m[0], fix.ground_m[1]) - true_ground(pose, axis, fix.ground_m[2]);
  const double(&c)[3] = fix.ground_covariance;
  const double squares =
      (c[2] * error.x() * error.x() - 2 * c[1] * error.x() * error.y() + c[0] * error.y() * error.y()) /
      (c[0] * c[2] - c[1] * c[1]);
  score.ground_m.push_back(error.norm());
  score.ground_px.push_back(error.norm() / fix.pixel_m);
  score.ground_nes.push_back(squares / 2);
  const Vec3 off = Vec3(fix.centre_m[0], fix.centre_m[1], fix.centre_m[2]) - pose.centre;
  const double of_centre = off.dot(centre_covariance(fix).ldlt().solve(off)) / 3;
  if (std::isfinite(of_centre)) score.centre_nes.push_back(of_centre);
  const bool is_false =
      error.norm() > FixScore::false_px * fix.pixel_m && squares > FixScore::false_sigmas * FixScore::false_sigmas;
  score.false_fixes += is_false ? 1U : 0U;
  score.false_accepted += is_false && accepted ? 1U : 0U;
}

double mean(const std::vector<double>& values) {
  return values.empty() ? unknown : host::summarise(values).mean;
}

double at(const std::vector<double>& values, double share) {
  return values.empty() ? unknown : host::percentile(values, share);
}

}  // namespace

FixScore score_fixes(const intake::Flight& flight, const report::Reference& reference,
                     const std::optional<CameraModel>& camera) {
  FixScore score;
  const Vec2 axis = flight_axis(flight, camera);
  for (const auto& [id, keyframe] : flight.keyframes) {
    const auto& fix = keyframe.fix;
    const report::ReferencePose* const pose = reference.pose(keyframe.name);
    if (!fix || fix->map_id == 0 || !keyframe.posed() || pose == nullptr) continue;
    ++score.keyframes;
    if (fix->verdict == MapVerdict::fixed) add_fix(*fix, *pose, axis, score);
    if (!(fix->place_sigma_m > 0)) continue;
    const double off = std::hypot(fix->place_m[0] - pose->centre.x(), fix->place_m[1] - pose->centre.y());
    score.place_m.push_back(off);
    score.place_nes.push_back(0.5 * off * off / (fix->place_sigma_m * fix->place_sigma_m));
  }
  return score;
}

std::map<std::string, double> fix_summary(const FixScore& score) {
  if (score.keyframes == 0) return {};
  const auto share = [&](std::size_t part) { return static_cast<double>(part) / static_cast<double>(score.keyframes); };
  return {{"fixed_share", share(score.fixed)},
          {"fix_accepted_share", share(score.accepted)},
          {"false_fixes", static_cast<double>(score.false_fixes)},
          {"fix_ground_median_px", at(score.ground_px, 0.5)},
          {"fix_ground_p95_px", at(score.ground_px, 0.95)},
          {"fix_ground_median_m", at(score.ground_m, 0.5)},
          {"fix_ground_nes", mean(score.ground_nes)},
          {"fix_pose_nes", mean(score.centre_nes)},
          {"fix_place_median_m", at(score.place_m, 0.5)},
          {"fix_place_p95_m", at(score.place_m, 0.95)},
          {"fix_place_nes", mean(score.place_nes)}};
}

}  // namespace ilp::score
