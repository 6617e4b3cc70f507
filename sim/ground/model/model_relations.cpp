#include "sim/ground/model/model_relations.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/place/plane_map.hpp"

namespace ilp::model {
namespace {

constexpr double least_share = 1.0 / 7;
constexpr std::size_t least_points = 12, most_partners = 8;
constexpr std::uint32_t near_in_strip = 4;

struct RelatedPoint {
  Vec3 position;
  Vec2 real_px;
};

/// The placed points that each view sees.
std::vector<std::vector<RelatedPoint>> points_by_view(const Scene& scene, const Model& model) {
  std::vector<std::vector<RelatedPoint>> points(scene.views.size());
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    if (!model.points[t].placed) continue;
    for (std::size_t s = 0; s < scene.tracks[t].seen.size(); ++s) {
      if (!model.sees(scene, t, s)) continue;
      const Sighting& seen = scene.tracks[t].seen[s];
      points[seen.view].push_back(
          {model.points[t].position, pixel_from_ideal(scene.views[seen.view].camera, Vec2(seen.x, seen.y))});
    }
  }
  return points;
}

struct Candidate {
  double share = 0;
  PairRelation relation;
};

bool inside(const CameraModel& camera, const Vec2& px) {
  return px.x() >= 0 && px.y() >= 0 && px.x() <= camera.width - 1 && px.y() <= camera.height - 1;
}

/// Share 0: too little in common.
Candidate candidate(const Scene& scene, const Model& model, const std::vector<RelatedPoint>& points, std::uint32_t a,
                    std::uint32_t b) {
  const CameraModel& camera = scene.views[b].camera;
  PlaneFit fit(0.5 * camera.width, 0.5 * camera.height, 0.5 * camera.width);
  std::vector<std::pair<Vec2, Vec2>> pairs;
  for (const RelatedPoint& point : points) {
    const Vec3 p = model.views[b].camera_from_model * point.position;
    if (!(p.z() > 0)) continue;
    const Vec2 px = pixel_from_ideal(camera, ideal_from_normalised(camera, Vec2(p.x() / p.z(), p.y() / p.z())));
    if (!inside(camera, px)) continue;
    pairs.emplace_back(point.real_px, px);
    fit.add(point.real_px.x(), point.real_px.y(), px.x(), px.y());
  }
  Candidate out;
  const double share = static_cast<double>(pairs.size()) / static_cast<double>(std::max<std::size_t>(points.size(), 1));
  PlaneMap plane;
  if (pairs.size() < least_points || share < least_share || !fit.homography(plane)) return out;
  double squares = 0;
  for (const auto& [from, to] : pairs) squares += plane.squared_distance(from.x(), from.y(), to.x(), to.y());
  const double rms = std::sqrt(squares / static_cast<double>(pairs.size()));
  out.share = share;
  out.relation.a = a;
  out.relation.b = b;
  std::copy_n(plane.h, 9, out.relation.plane_b_from_a);
  out.relation.radius_px = static_cast<float>(std::clamp(3 * rms + 8, 12.0, 40.0));
  return out;
}

/// A sphere about all points of a view.
struct Surroundings {
  Vec3 middle = Vec3::Zero();
  double radius = 0;

  explicit Surroundings(const std::vector<RelatedPoint>& points) {
    for (const RelatedPoint& point : points) middle += point.position / static_cast<double>(points.size());
    for (const RelatedPoint& point : points) radius = std::max(radius, (point.position - middle).norm());
  }
};

/// Whether a point of the sphere may lie in the cone about the camera's axis that holds its image.
bool may_see(const View& view, const RigidTransform& pose, const Surroundings& sphere) {
  constexpr double with_distortion = 1.5;
  const CameraModel& camera = view.camera;
  const double across = std::max(camera.cx, camera.width - camera.cx) / camera.fx,
               down = std::max(camera.cy, camera.height - camera.cy) / camera.fy;
  const double half_angle = std::atan(camera.lens == Lens::fisheye ? undistort(camera, Vec2(across, down)).norm()
                                                                   : with_distortion * std::hypot(across, down));
  const Vec3 p = pose * sphere.middle;
  return std::hypot(p.x(), p.y()) * std::cos(half_angle) - p.z() * std::sin(half_angle) <= sphere.radius;
}

std::vector<std::uint32_t> order_in_strip(const Scene& scene) {
  std::vector<std::uint32_t> order(scene.views.size(), 0);
  std::map<std::int64_t, std::uint32_t> next;  // by strip
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    std::uint32_t& number = next[scene.views[v].strip_id];
    order[v] = number;
    if (scene.views[v].posed) ++number;
  }
  return order;
}

}  // namespace

std::vector<PairRelation> relations_by_model(const Scene& scene, const Model& model) {
  const auto points = points_by_view(scene, model);
  const std::vector<Surroundings> surroundings(points.begin(), points.end());
  const std::vector<std::uint32_t> order = order_in_strip(scene);
  const std::vector<std::uint8_t> weak = weakly_connected_views(scene);
  std::vector<PairRelation> relations;
  for (std::uint32_t b = 0; b < scene.views.size(); ++b) {
    const View& newer = scene.views[b];
    if (!model.views[b].in || !newer.has_image) continue;
    std::vector<Candidate> candidates;
    for (std::uint32_t a = 0; a < b; ++a) {
      const View& older = scene.views[a];
      if (!model.views[a].in || !older.has_image || (weak[a] == 0 && weak[b] == 0)) continue;
      const bool chained = newer.posed && older.posed && newer.strip_id == older.strip_id;
      if (chained && order[b] - order[a] <= near_in_strip) continue;
      if (!may_see(newer, model.views[b].camera_from_model, surroundings[a])) continue;
      Candidate one = candidate(scene, model, points[a], a, b);
      if (one.share > 0) candidates.push_back(one);
    }
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& x, const Candidate& y) { return x.share > y.share; });
    if (candidates.size() > most_partners) candidates.resize(most_partners);
    for (const Candidate& one : candidates) relations.push_back(one.relation);
  }
  return relations;
}

}  // namespace ilp::model
