#include "sim/ground/model/view_similarity.hpp"

#include <algorithm>
#include <iterator>
#include <memory>

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/multiview/resection.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::model {
namespace {

constexpr std::size_t least_ratios = 8;
/// Of the distance of what is seen, where the image is as wide as the focal length. The place of a narrower camera is
/// less certain.
constexpr double turn_share = 0.005;

/// Units of the points' world for one unit of the world in which the view stands.
std::optional<double> scale_by_depths(const Scene& scene, std::uint32_t v, const std::vector<SeenPoint>& seen,
                                      const Resected& resected, const ViewDepths& depths) {
  std::vector<double> near_ratios, any_ratios;
  for (const SeenPoint& one : seen) {
    if (reprojection_error(resected.camera_from_world, scene.views[v].camera, one.position, one.seen) > fits_px)
      continue;
    const double z = (resected.camera_from_world * one.position).z();
    if (const auto inverse = depths.near(v, one.seen.x, one.seen.y)) near_ratios.push_back(z * *inverse);
    if (const auto inverse = depths.any(v, one.seen.x, one.seen.y)) any_ratios.push_back(z * *inverse);
  }
  std::vector<double>& ratios = near_ratios.size() >= least_ratios ? near_ratios : any_ratios;
  if (ratios.size() < least_ratios) return std::nullopt;
  return host::median(std::move(ratios));
}

std::optional<Resected> resect_on(const Scene& scene, std::uint32_t view, const std::vector<SeenPoint>& seen) {
  thread_local const auto views = std::make_unique<PointViews>();
  thread_local const auto inliers = std::make_unique<ViewMask>();
  views->clear();
  for (const SeenPoint& one : seen) {
    const Vec3& p = one.position;
    if (!views->push_back({{p.x(), p.y(), p.z()}, one.seen.x, one.seen.y})) break;
  }
  ResectionParams params;
  params.threshold_px = fits_px;
  params.min_inliers = 10;
  params.seed = static_cast<std::uint64_t>(scene.views[view].keyframe_id);
  ResectionResult result;
  if (!resect(*views, scene.views[view].camera, params, *inliers, result).ok()) return std::nullopt;
  return Resected{result.cam_from_world, result.inliers};
}

/// Whether the pose is where another keyframe of the world stands.
bool only_turned(const Scene& scene, std::uint32_t view, const std::vector<SeenPoint>& seen, const World& world,
                 const RigidTransform& pose) {
  std::vector<double> depths;
  for (const SeenPoint& one : seen) depths.push_back((pose * one.position).z());
  const CameraModel& camera = scene.views[view].camera;
  const double near = turn_share * host::median(std::move(depths)) * std::max(1.0, camera.fx / camera.width);
  for (std::uint32_t other = 0; other < scene.views.size(); ++other) {
    const RigidTransform* const there = other == view ? nullptr : world.pose(other);
    if (there != nullptr && (centre_of(*there) - centre_of(pose)).norm() < near) return true;
  }
  return false;
}

}  // namespace

std::optional<Vec3> position_in(const Scene& scene, const World& world, const ViewDepths& depths, std::size_t track) {
  if (const Vec3* point = world.point(track)) return *point;
  for (const Sighting& seen : scene.tracks[track].seen) {
    const RigidTransform* pose = world.pose(seen.view);
    const auto inverse = pose == nullptr ? std::nullopt : depths.any(seen.view, seen.x, seen.y);
    if (!inverse) continue;
    const Vec2 n = normalised_from_ideal(scene.views[seen.view].camera, Vec2(seen.x, seen.y));
    const Vec3 in_camera = Vec3(n.x(), n.y(), 1) / *inverse;
    return Vec3(pose->rotation.transpose() * (in_camera - pose->translation));
  }
  return std::nullopt;
}

std::optional<Resected> resect_view(const Scene& scene, std::uint32_t view, const std::vector<SeenPoint>& seen,
                                    const World& world) {
  const auto first = resect_on(scene, view, seen);
  if (!first || !only_turned(scene, view, seen, world, first->camera_from_world)) return first;
  std::vector<SeenPoint> others;
  std::copy_if(seen.begin(), seen.end(), std::back_inserter(others), [&](const SeenPoint& one) {
    return reprojection_error(first->camera_from_world, scene.views[view].camera, one.position, one.seen) > fits_px;
  });
  if (10 * others.size() <= seen.size()) return first;
  const auto second = resect_on(scene, view, others);
  const bool moves = second && enough(second->inliers, seen.size()) && 2 * second->inliers >= others.size() &&
                     !only_turned(scene, view, seen, world, second->camera_from_world);
  return moves ? second : std::nullopt;
}

std::optional<Similarity> similarity_by_view(const Scene& scene, std::uint32_t v, const std::vector<SeenPoint>& seen,
                                             const World& world, const RigidTransform& pose, const ViewDepths& depths) {
  if (seen.empty()) return std::nullopt;
  const auto resected = resect_view(scene, v, seen, world);
  if (!resected) return std::nullopt;
  const auto scale = scale_by_depths(scene, v, seen, *resected, depths);
  if (!scale) return std::nullopt;
  // The camera's axes are those of both worlds: scale (R x + t) of its own world = R y + t of the points' world.
  const RigidTransform& to = resected->camera_from_world;
  Similarity similarity;
  similarity.scale = *scale;
  similarity.rotation = to.rotation.transpose() * pose.rotation;
  similarity.translation = to.rotation.transpose() * (*scale * pose.translation - to.translation);
  return similarity;
}

}  // namespace ilp::model
