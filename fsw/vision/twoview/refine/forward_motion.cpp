#include "fsw/vision/twoview/refine/forward_motion.hpp"

#include <array>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/twoview/refine/epipolar_refinement.hpp"

namespace ilp {
namespace {

constexpr double degree = pi / 180;
constexpr double ring_tangents[] = {2.5 * degree, 5 * degree, 8 * degree, 12 * degree};
constexpr std::size_t starts_per_ring = 6;
constexpr std::size_t max_minima = 1 + std::size(ring_tangents) * starts_per_ring;
/// Minima closer than this count as one.
constexpr double same_minimum_rad = 0.15 * degree;
/// Every motion has its own depths fitted to the noise, so that the likelihoods of motions differ by more than the
/// matches justify (J. Neyman, E. Scott 1948). With this factor on the variance two of three errors are within one
/// estimated sigma (test_forward_motion.cpp).
constexpr double likelihood_factor = 8;
/// Least likelihood of the mean relative to the best minimum. A lower one shows a ridge between the minima instead of a
/// valley, as between the two motions that a plane allows: their mean is neither.
constexpr double min_mean_likelihood = 0.1;

struct Minimum {
  RigidTransform pose;
  double cost = 0;
};

bool sees(const CameraModel& camera, const Vec3& direction) {
  if (std::fabs(direction.z()) < 1e-9) return false;
  const double x = camera.fx * direction.x() / direction.z() + camera.cx;
  const double y = camera.fy * direction.y() / direction.z() + camera.cy;
  return x >= 0 && y >= 0 && x <= camera.width - 1 && y <= camera.height - 1;
}

double angle_between(const Vec3& a, const Vec3& b) {
  return det_atan2(a.cross(b).norm(), a.dot(b));
}

/// A small turn as a rotation vector.
Vec3 turn_between(const Mat3& from, const Mat3& to) {
  const Mat3 turn = from.transpose() * to;
  return 0.5 * Vec3(turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0), turn(1, 0) - turn(0, 1));
}

class Minima {
 public:
  Minima(const NormalisedPairs& pairs, const PairSelection& selection, double bound_px)
      : pairs_(pairs), selection_(selection), params_{RobustLoss::tukey, bound_px, 8, 1e-4} {}

  void add(const RigidTransform& pose) {
    for (std::size_t i = 0; i < count_; ++i) {
      if (angle_between(minima_[i].pose.translation, pose.translation) < same_minimum_rad) return;
    }
    minima_[count_++] = {pose, epipolar_cost(pairs_, selection_, params_, pose)};
  }

  void search_around(const RigidTransform& pose) {
    const Vec3& t = pose.translation;
    const Vec3 u = t.cross(std::fabs(t.x()) < 0.5 ? Vec3::UnitX() : Vec3::UnitY()).normalized();
    const Vec3 v = t.cross(u);
    for (std::size_t ring = 0; ring < std::size(ring_tangents); ++ring) {
      for (std::size_t k = 0; k < starts_per_ring; ++k) {
        // Every second ring is turned by half a step.
        const double azimuth = (static_cast<double>(2 * k + ring % 2)) * pi / starts_per_ring;
        const Vec3 offset = det_cos(azimuth) * u + det_sin(azimuth) * v;
        RigidTransform start{pose.rotation, (t + ring_tangents[ring] * offset).normalized()};
        if (refine_relative_pose(pairs_, selection_, params_, start)) add(start);
      }
    }
  }

  MotionSpread average(double sigma_px, RigidTransform& pose) const {
    const double unit = 2 * likelihood_factor * sigma_px * sigma_px;
    const Minimum* best = &minima_[0];
    for (std::size_t i = 1; i < count_; ++i) best = minima_[i].cost < best->cost ? &minima_[i] : best;
    std::array<double, max_minima> weights;
    double sum = 0;
    Vec3 direction = Vec3::Zero();
    Vec3 turn = Vec3::Zero();
    for (std::size_t i = 0; i < count_; ++i) {
      weights[i] = det_exp(-(minima_[i].cost - best->cost) / unit);
      sum += weights[i];
      direction += weights[i] * minima_[i].pose.translation;
      turn += weights[i] * turn_between(best->pose.rotation, minima_[i].pose.rotation);
    }
    const RigidTransform mean{best->pose.rotation * rotation_from_vector(turn / sum), direction.normalized()};
    const double mean_cost = epipolar_cost(pairs_, selection_, params_, mean);
    if (!(det_exp(-(mean_cost - best->cost) / unit) >= min_mean_likelihood)) return {};
    pose = mean;
    MotionSpread spread;
    for (std::size_t i = 0; i < count_; ++i) {
      const double angle = angle_between(pose.translation, minima_[i].pose.translation);
      spread.direction_rad += weights[i] * angle * angle;
      spread.rotation_rad += weights[i] * turn_between(pose.rotation, minima_[i].pose.rotation).squaredNorm();
    }
    return {std::sqrt(spread.rotation_rad / sum), std::sqrt(spread.direction_rad / sum)};
  }

 private:
  const NormalisedPairs& pairs_;
  PairSelection selection_;
  RefinementParams params_;
  std::array<Minimum, max_minima> minima_;
  std::size_t count_ = 0;
};

}  // namespace

bool epipole_in_view(const RigidTransform& b_from_a, const CameraModel& camera_a, const CameraModel& camera_b) {
  return sees(camera_b, b_from_a.translation) || sees(camera_a, b_from_a.rotation.transpose() * b_from_a.translation);
}

MotionSpread average_over_minima(const NormalisedPairs& pairs, double bound_px, double sigma_px, PairIndices& scratch,
                                 RigidTransform& b_from_a) {
  if (!(sigma_px > 0)) return {};
  scratch.clear();
  for (std::size_t i = 0; i < pairs.size(); ++i) static_cast<void>(scratch.push_back(static_cast<std::uint16_t>(i)));
  Minima minima(pairs, {scratch.data(), scratch.size()}, bound_px);
  minima.add(b_from_a);
  minima.search_around(b_from_a);
  return minima.average(sigma_px, b_from_a);
}

}  // namespace ilp
