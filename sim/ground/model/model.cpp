#include "sim/ground/model/model.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/vision/geometry/camera.hpp"
#include "sim/ground/model/common_errors.hpp"
#include "sim/ground/model/kept_adjustment.hpp"
#include "sim/ground/model/single_link_views.hpp"
#include "sim/ground/model/view_depths.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::model {
namespace {

constexpr double least_angle_rad = 0.0175;

struct SeenFrom {
  const RigidTransform* camera_from_model = nullptr;
  const CameraModel* camera = nullptr;
  const Sighting* seen = nullptr;

  [[nodiscard]] Vec3 centre() const { return centre_of(*camera_from_model); }
};

void find_sightings(const Scene& scene, const Model& model, std::size_t track, std::vector<SeenFrom>& from) {
  from.clear();
  for (std::size_t s = 0; s < scene.tracks[track].seen.size(); ++s) {
    const Sighting& seen = scene.tracks[track].seen[s];
    if (model.sees(scene, track, s))
      from.push_back({&model.views[seen.view].camera_from_model, &scene.views[seen.view].camera, &seen});
  }
}

/// The point nearest to all lines of sight by the algebraic error.
bool intersect(const std::vector<SeenFrom>& from, Vec3& point) {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  for (const SeenFrom& one : from) {
    const Vec2 n = normalised_from_ideal(*one.camera, Vec2(one.seen->x, one.seen->y));
    Mat34 projection;
    projection << one.camera_from_model->rotation, one.camera_from_model->translation;
    for (int k = 0; k < 2; ++k) {
      const Vec4 row = n[k] * projection.row(2).transpose() - projection.row(k).transpose();
      normal += row * row.transpose();
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(normal);
  const Vec4 solution = solver.eigenvectors().col(0);
  if (!(std::fabs(solution[3]) > 1e-12)) return false;
  point = solution.head<3>() / solution[3];
  return point.allFinite();
}

double largest_angle(const std::vector<SeenFrom>& from, const Vec3& point) {
  double largest = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Vec3 a = (from[i].centre() - point).normalized();
    for (std::size_t j = 0; j < i; ++j) {
      const Vec3 b = (from[j].centre() - point).normalized();
      largest = std::max(largest, std::atan2(a.cross(b).norm(), a.dot(b)));
    }
  }
  return largest;
}

bool fits(const std::vector<SeenFrom>& from, const Vec3& point, double max_px) {
  return std::all_of(from.begin(), from.end(), [&](const SeenFrom& one) {
    return reprojection_error(*one.camera_from_model, *one.camera, point, *one.seen) < max_px;
  });
}

/// The points that views see under an angle of their own.
World measured_world(const Model& model) {
  return {[&model](std::size_t t) {
            const ModelPoint& point = model.points[t];
            return point.placed && !point.by_depth ? &point.position : nullptr;
          },
          [&model](std::uint32_t v) { return model.views[v].in ? &model.views[v].camera_from_model : nullptr; }};
}

bool placed_by_depth(const SeenFrom& from, const ViewDepths& depths, Vec3& point) {
  const auto inverse = depths.near(from.seen->view, from.seen->x, from.seen->y);
  if (!inverse) return false;
  const Vec2 n = normalised_from_ideal(*from.camera, Vec2(from.seen->x, from.seen->y));
  const RigidTransform& pose = *from.camera_from_model;
  point = pose.rotation.transpose() * (Vec3(n.x(), n.y(), 1) / *inverse - pose.translation);
  return point.allFinite();
}

}  // namespace

Vec3 centre_of(const RigidTransform& camera_from_world) {
  return -(camera_from_world.rotation.transpose() * camera_from_world.translation);
}

RigidTransform moved(const Similarity& a_from_b, const RigidTransform& camera_from_b) {
  RigidTransform camera_from_a;
  const Vec3 centre = a_from_b * centre_of(camera_from_b);
  camera_from_a.rotation = camera_from_b.rotation * a_from_b.rotation.transpose();
  camera_from_a.translation = -(camera_from_a.rotation * centre);
  return camera_from_a;
}

std::size_t Model::size() const {
  return static_cast<std::size_t>(std::count_if(views.begin(), views.end(), [](const ModelView& v) { return v.in; }));
}

Model model_of_strip(const Scene& scene, std::int64_t strip_id) {
  Model model;
  model.views.resize(scene.views.size());
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const View& view = scene.views[i];
    if (view.posed && view.strip_id == strip_id) model.views[i] = {true, view.camera_from_strip};
  }
  grow(scene, model);
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    const Track& track = scene.tracks[t];
    if (track.of_flight && track.strip_id == strip_id) {
      model.points[t].placed = true;
      model.points[t].position = track.strip_position;
    }
  }
  return model;
}

void grow(const Scene& scene, Model& model) {
  model.points.resize(scene.tracks.size());
  std::vector<std::uint8_t> refused;
  std::vector<std::size_t> first = {0};
  first.reserve(scene.tracks.size() + 1);
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    if (t + 1 < model.first.size())
      refused.insert(refused.end(), model.refused.begin() + static_cast<std::ptrdiff_t>(model.first[t]),
                     model.refused.begin() + static_cast<std::ptrdiff_t>(model.first[t + 1]));
    first.push_back(first.back() + scene.tracks[t].seen.size());
    refused.resize(first.back(), 0);
  }
  model.refused = std::move(refused);
  model.first = std::move(first);
}

double reprojection_error(const RigidTransform& camera_from_model, const CameraModel& camera, const Vec3& point,
                          const Sighting& seen) {
  const Vec3 p = camera_from_model * point;
  if (!(p.z() > 0)) return std::numeric_limits<double>::infinity();
  return (ideal_from_normalised(camera, Vec2(p.x() / p.z(), p.y() / p.z())) - Vec2(seen.x, seen.y)).norm();
}

namespace {

/// A point that is not placed yet, where its lines of sight meet.
struct NewPoint {
  std::size_t track = 0;
  std::vector<SeenFrom> from;
  bool crossing = false;  ///< at a wide enough angle
  Vec3 position = Vec3::Zero();
};

std::vector<NewPoint> new_points(const Scene& scene, const Model& model) {
  std::vector<NewPoint> points;
  std::vector<SeenFrom> from;
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    if (model.points[t].placed) continue;
    find_sightings(scene, model, t, from);
    if (from.size() < 2) continue;
    NewPoint point{t, from};
    point.crossing =
        intersect(point.from, point.position) && largest_angle(point.from, point.position) >= least_angle_rad;
    points.push_back(std::move(point));
  }
  return points;
}

}  // namespace

void triangulate(const Scene& scene, double max_px, Model& model) {
  std::vector<NewPoint> points = new_points(scene, model);
  // Depths of all points take long, and mostly nobody asks for one.
  std::optional<ViewDepths> depths;
  if (std::any_of(points.begin(), points.end(), [](const NewPoint& point) { return !point.crossing; }))
    depths.emplace(scene, measured_world(model));
  for (NewPoint& point : points) {
    if (!point.crossing && !placed_by_depth(point.from.front(), *depths, point.position)) continue;
    if (!fits(point.from, point.position, max_px)) continue;
    ModelPoint& placed = model.points[point.track];
    placed.placed = true;
    placed.by_depth = !point.crossing;
    placed.position = point.position;
  }
}

void refuse_outliers(const Scene& scene, double max_px, Model& model) {
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    ModelPoint& point = model.points[t];
    if (!point.placed) continue;
    std::size_t left = 0;
    for (std::size_t s = 0; s < scene.tracks[t].seen.size(); ++s) {
      const Sighting& seen = scene.tracks[t].seen[s];
      if (!model.views[seen.view].in) continue;
      const double error = reprojection_error(model.views[seen.view].camera_from_model, scene.views[seen.view].camera,
                                              point.position, seen);
      model.refuse(t, s, error > max_px);
      left += error > max_px ? 0 : 1;
    }
    if (left < 2) point.placed = false;
  }
}

ModelExtent extent_of(const Scene& scene, const Model& model) {
  ModelExtent extent;
  extent.views = model.size();
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    const ModelPoint& point = model.points[t];
    extent.points += point.placed ? 1 : 0;
    for (std::size_t s = 0; s < scene.tracks[t].seen.size(); ++s) {
      const Sighting& seen = scene.tracks[t].seen[s];
      if (!model.views[seen.view].in) continue;
      ++extent.sightings;
      extent.refused += model.refuses(t, s) || !point.placed ? 1 : 0;
      if (model.refuses(t, s) || !point.placed) continue;
      const double error = reprojection_error(model.views[seen.view].camera_from_model, scene.views[seen.view].camera,
                                              point.position, seen);
      extent.largest_error_px = std::max(extent.largest_error_px, error);
    }
  }
  return extent;
}

double median_error_px(const Scene& scene, const Model& model) {
  std::vector<double> errors;
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    if (!model.points[t].placed) continue;
    for (std::size_t s = 0; s < scene.tracks[t].seen.size(); ++s) {
      const Sighting& seen = scene.tracks[t].seen[s];
      if (!model.sees(scene, t, s)) continue;
      errors.push_back(reprojection_error(model.views[seen.view].camera_from_model, scene.views[seen.view].camera,
                                          model.points[t].position, seen));
    }
  }
  return errors.empty() ? 0 : host::median(std::move(errors));
}

namespace {

AdjustedCamera adjusted_camera(const RigidTransform& pose, const CameraModel& model) {
  return {pose.rotation, centre_of(pose), model.fx, model.fy, model.cx, model.cy};
}

}  // namespace

ModelProblem problem_of(const Scene& scene, const Model& model) {
  const ViewDepths known(scene, measured_world(model));
  const SingleLinkDepths single_link(scene, model);
  ModelProblem problem;
  std::vector<std::uint32_t> camera_of(scene.views.size(), 0);
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    if (!model.views[v].in) continue;
    camera_of[v] = static_cast<std::uint32_t>(problem.cameras.size());
    problem.cameras.push_back(adjusted_camera(model.views[v].camera_from_model, scene.views[v].camera));
    problem.view_of.push_back(v);
  }
  for (const ViewFix& fix : model.fixes) {
    const FixWeights& weights = model.fix_weights;
    problem.priors.push_back({camera_of[fix.view], fix.cam_from_map, fix.centre,
                              weights.image_px / weights.error_factor * fix.sigmas_from_error,
                              weights.image_px * weights.loss});
  }
  std::vector<SeenFrom> from;
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    const ModelPoint& point = model.points[t];
    if (!point.placed) continue;
    const auto number = static_cast<std::uint32_t>(problem.points.size());
    find_sightings(scene, model, t, from);
    std::erase_if(from, [&](const SeenFrom& one) { return !((*one.camera_from_model * point.position).z() > 0); });
    if (from.size() < 2) continue;
    for (const SeenFrom& one : from)
      problem.observations.push_back({camera_of[one.seen->view], number, one.seen->x, one.seen->y});
    const Sighting& first = *from.front().seen;
    const auto inverse = point.by_depth ? known.near(first.view, first.x, first.y) : std::nullopt;
    if (const auto depth = single_link.of(t)) {
      problem.depths.push_back({camera_of[depth->camera], number, depth->inverse_depth, depth->sigma});
    } else if (inverse) {
      problem.depths.push_back({camera_of[first.view], number, *inverse});
    }
    problem.points.push_back(point.position);
    problem.track_of.push_back(t);
  }
  return problem;
}

void adjust_model(const Scene& scene, double robust_px, Model& model, double tolerance) {
  ModelProblem problem = problem_of(scene, model);
  AdjustmentParams params;
  params.robust_px = robust_px;
  params.tolerance = tolerance;
  if (!adjust_once(problem, params, scene.results)) return;
  for (std::size_t p = 0; p < problem.points.size(); ++p)
    model.points[problem.track_of[p]].position = problem.points[p];
  for (std::size_t c = 0; c < problem.cameras.size(); ++c) {
    const AdjustedCamera& camera = problem.cameras[c];
    model.views[problem.view_of[c]].camera_from_model = {camera.cam_from_world,
                                                         -(camera.cam_from_world * camera.centre)};
  }
}

namespace {

/// Each camera knows how far away the point is that most others see, within a hundredth.
void add_distances(ModelProblem& problem) {
  std::vector<std::size_t> seeing(problem.points.size(), 0);
  for (const AdjustedObservation& seen : problem.observations) ++seeing[seen.point];
  std::vector<const AdjustedObservation*> best(problem.cameras.size(), nullptr);
  for (const AdjustedObservation& seen : problem.observations) {
    if (best[seen.camera] == nullptr || seeing[seen.point] > seeing[best[seen.camera]->point])
      best[seen.camera] = &seen;
  }
  for (const AdjustedObservation* seen : best) {
    if (seen == nullptr) continue;
    const AdjustedCamera& camera = problem.cameras[seen->camera];
    const double depth = (camera.cam_from_world * (problem.points[seen->point] - camera.centre)).z();
    problem.depths.push_back({seen->camera, seen->point, 1 / depth});
  }
  std::stable_sort(problem.depths.begin(), problem.depths.end(),
                   [](const AdjustedDepth& a, const AdjustedDepth& b) { return a.point < b.point; });
}

}  // namespace

void state_errors(const Scene& scene, Model& model) {
  ModelProblem problem = problem_of(scene, model);
  std::vector<PoseCovariance> errors = pose_covariances(problem);
  if (errors.empty()) {
    // Where no track leads from one part of the model to another, depths alone have told the scale between them.
    add_distances(problem);
    errors = pose_covariances(problem);
  }
  double factor = 1;
  if (!errors.empty() && model.fixes.empty()) factor = common_errors_of(problem, last_robust_px).factor();
  // With fixes, what sightings have in common has been weighed against them.
  if (!errors.empty() && !model.fixes.empty())
    factor = model.fix_weights.image_px * model.fix_weights.image_px / variance_of_sightings(problem).value();
  for (std::size_t c = 0; c < errors.size(); ++c) {
    for (double& of_pose : errors[c]) of_pose *= factor;
    model.views[problem.view_of[c]].covariance = errors[c];
  }
}

void move(const Similarity& by, Model& model) {
  for (ModelView& view : model.views) {
    if (view.in) view.camera_from_model = moved(by, view.camera_from_model);
  }
  for (ModelPoint& point : model.points) {
    if (point.placed) point.position = by * point.position;
  }
}

}  // namespace ilp::model
