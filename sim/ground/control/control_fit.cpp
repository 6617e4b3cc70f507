#include "sim/ground/control/control_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "fsw/vision/geometry/camera.hpp"

namespace ilp::control {
namespace {

constexpr int rounds = 10;
constexpr double least_angle_rad = 0.01;  ///< between two lines of sight
constexpr double agreement = 4;           ///< sigmas
constexpr std::size_t most_tried = 40;
constexpr double least_height_of_triangle = 0.05;  ///< over its longest side

Vec3 line_of(const Sight& sight) {
  const Vec2 n = normalised_from_pixel(sight.camera, sight.pixel);
  return (sight.cam_from_world.transpose() * Vec3(n.x(), n.y(), 1)).normalized();
}

/// Weights of lines are those of pixels: the focal length over the distance.
Mat3 weight_of(const Sight& sight, const Vec3& direction, const Vec3& point) {
  const double w = sight.camera.fx / std::max((point - sight.centre).norm(), 1e-12);
  return w * w * (Mat3::Identity() - direction * direction.transpose());
}

double largest_angle(const std::vector<Sight>& sights) {
  double angle = 0;
  for (const Sight& a : sights) {
    for (const Sight& b : sights) angle = std::max(angle, line_of(a).cross(line_of(b)).norm());
  }
  return angle;
}

double rms_of(const std::vector<Sight>& sights, const Vec3& point) {
  double sum = 0;
  for (const Sight& sight : sights) {
    const Vec3 c = sight.cam_from_world * (point - sight.centre);
    const Vec2 seen = pixel_from_normalised(sight.camera, {c.x() / c.z(), c.y() / c.z()});
    sum += (seen - sight.pixel).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(sights.size()));
}

bool in_front_of_all(const std::vector<Sight>& sights, const Vec3& point) {
  return std::all_of(sights.begin(), sights.end(),
                     [&](const Sight& sight) { return (sight.cam_from_world * (point - sight.centre)).z() > 0; });
}

/// Of the residual: what survey and marks explain.
Mat3 covariance_of(const Surveyed& point, const host::Similarity3& fit) {
  return point.place_sigma * point.place_sigma * Mat3::Identity() +
         fit.scale * fit.scale * fit.rotation * point.world_covariance * fit.rotation.transpose();
}

double squared_sigmas(const Surveyed& point, const host::Similarity3& fit) {
  const Vec3 error = fit * point.world - point.place;
  return error.dot(covariance_of(point, fit).inverse() * error);
}

/// Gauss-Newton about `centre`, with the inverse covariances as weights.
host::Similarity3 refined(const std::vector<Surveyed>& points, const std::vector<std::size_t>& members,
                          const Vec3& centre, host::Similarity3 fit) {
  for (int round = 0; round < rounds; ++round) {
    SimilarityCovariance normal = SimilarityCovariance::Zero();
    SimilarityStep right = SimilarityStep::Zero();
    for (const std::size_t i : members) {
      const Vec3 at = fit * points[i].world - centre;
      const Eigen::Matrix<double, 3, 7> change = change_by_step(at);
      const Mat3 weight = covariance_of(points[i], fit).inverse();
      normal += change.transpose() * weight * change;
      right -= change.transpose() * (weight * (at + centre - points[i].place));
    }
    const SimilarityStep step = normal.ldlt().solve(right);
    if (!step.allFinite()) return fit;
    const Similarity next = stepped(step, {fit.rotation, fit.translation - centre, fit.scale});
    fit = {next.scale, next.rotation, next.translation + centre};
  }
  return fit;
}

std::optional<host::Similarity3> fit_of(const std::vector<Surveyed>& points, const std::vector<std::size_t>& members) {
  std::vector<Vec3> from, to;
  Vec3 centre = Vec3::Zero();
  for (const std::size_t i : members) {
    from.push_back(points[i].world);
    to.push_back(points[i].place);
    centre += points[i].place / static_cast<double>(members.size());
  }
  const auto fit = host::align_positions(from, to);
  if (!fit || !(fit->scale > 0)) return std::nullopt;
  return refined(points, members, centre, *fit);
}

std::vector<std::size_t> agreeing(const std::vector<Surveyed>& points, const std::vector<std::size_t>& candidates,
                                  const host::Similarity3& fit) {
  std::vector<std::size_t> members;
  for (const std::size_t i : candidates) {
    if (squared_sigmas(points[i], fit) <= agreement * agreement) members.push_back(i);
  }
  return members;
}

double error_sum(const std::vector<Surveyed>& points, const std::vector<std::size_t>& members,
                 const host::Similarity3& fit) {
  double sum = 0;
  for (const std::size_t i : members) sum += squared_sigmas(points[i], fit);
  return sum;
}

bool spans_a_plane(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  return (b - a).cross(c - a).norm() > least_height_of_triangle * longest * longest;
}

struct Best {
  std::vector<std::size_t> members;
  double error = 0;
};

void consider(const std::vector<Surveyed>& points, const std::vector<std::size_t>& candidates,
              const std::vector<std::size_t>& triple, Best& best) {
  if (!spans_a_plane(points[triple[0]].place, points[triple[1]].place, points[triple[2]].place)) return;
  auto fit = fit_of(points, triple);
  if (!fit || !(fit->scale > 0)) return;
  std::vector<std::size_t> members = agreeing(points, candidates, *fit);
  if (members.size() >= 3) fit = fit_of(points, members);
  if (!fit) return;
  members = agreeing(points, candidates, *fit);
  const double error = error_sum(points, members, *fit);
  const bool better =
      members.size() > best.members.size() || (members.size() == best.members.size() && error < best.error);
  if (members.size() >= 3 && better) best = {std::move(members), error};
}

}  // namespace

std::optional<Triangulated> triangulate(const std::vector<Sight>& sights) {
  if (sights.size() < 2 || largest_angle(sights) < least_angle_rad) return std::nullopt;
  Triangulated result;
  Mat3 normal = Mat3::Identity();
  for (const Sight& sight : sights)
    result.point += (sight.centre + line_of(sight)) / static_cast<double>(sights.size());
  for (int round = 0; round < rounds; ++round) {
    normal.setZero();
    Vec3 right = Vec3::Zero();
    for (const Sight& sight : sights) {
      const Mat3 weight = weight_of(sight, line_of(sight), result.point);
      normal += weight;
      right += weight * sight.centre;
    }
    result.point = normal.inverse() * right;
  }
  if (!result.point.allFinite() || !in_front_of_all(sights, result.point)) return std::nullopt;
  result.covariance = normal.inverse();
  result.rms_px = rms_of(sights, result.point);
  return result;
}

std::optional<ControlFit> fit_control(const std::vector<Surveyed>& points) {
  std::vector<std::size_t> candidates;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].usable) candidates.push_back(i);
  }
  Best best;
  const std::size_t tried = std::min(candidates.size(), most_tried);
  for (std::size_t i = 0; i < tried; ++i) {
    for (std::size_t j = i + 1; j < tried; ++j) {
      for (std::size_t k = j + 1; k < tried; ++k) {
        consider(points, candidates, {candidates[i], candidates[j], candidates[k]}, best);
      }
    }
  }
  if (best.members.empty()) return std::nullopt;
  const auto fit = fit_of(points, best.members);
  if (!fit) return std::nullopt;
  ControlFit result;
  result.place_from_world = *fit;
  result.used.assign(points.size(), false);
  for (const std::size_t i : best.members) result.used[i] = true;
  for (const Surveyed& point : points) {
    result.residual.emplace_back(*fit * point.world - point.place);
    result.expected.push_back(std::sqrt(covariance_of(point, *fit).trace()));
  }
  return result;
}

}  // namespace ilp::control
