#include "sim/ground/model/normal_equations.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp::model {
namespace {

using Mat23 = Eigen::Matrix<double, 2, 3>;
using Mat26 = Eigen::Matrix<double, 2, 6>;
using Mat63 = Eigen::Matrix<double, 6, 3>;

/// A residual, and its derivatives by rotation vector and centre of the camera, and by the point.
struct LinearResidual {
  Vec2 value;
  Mat26 by_camera;
  Mat23 by_point;
};

Vec3 in_camera(const AdjustedCamera& camera, const Vec3& point) {
  return camera.cam_from_world * (point - camera.centre);
}

Vec2 residual_of(const AdjustedCamera& camera, const Vec3& p, const AdjustedObservation& seen) {
  return {camera.fx * p.x() / p.z() + camera.cx - seen.x, camera.fy * p.y() / p.z() + camera.cy - seen.y};
}

double residual_of(const Vec3& p, const AdjustedDepth& depth) {
  return (depth.inverse_depth * p.z() - 1) / depth.sigma;
}

/// `by_place`: the derivative by the place of the point in the camera's axes.
void chain(const AdjustedCamera& camera, const Vec3& p, const Mat23& by_place, LinearResidual& residual) {
  residual.by_point.noalias() = by_place * camera.cam_from_world;
  residual.by_camera.leftCols<3>().noalias() = -by_place * cross_matrix(p);
  residual.by_camera.rightCols<3>() = -residual.by_point;
}

LinearResidual linear(const AdjustedCamera& camera, const Vec3& point, const AdjustedObservation& seen) {
  const Vec3 p = in_camera(camera, point);
  LinearResidual residual;
  residual.value = residual_of(camera, p, seen);
  Mat23 by_place;
  by_place << camera.fx / p.z(), 0, -camera.fx * p.x() / (p.z() * p.z()), 0, camera.fy / p.z(),
      -camera.fy * p.y() / (p.z() * p.z());
  chain(camera, p, by_place, residual);
  return residual;
}

/// In the first row; the second one is zero.
LinearResidual linear(const AdjustedCamera& camera, const Vec3& point, const AdjustedDepth& depth) {
  const Vec3 p = in_camera(camera, point);
  LinearResidual residual;
  residual.value = Vec2(residual_of(p, depth), 0);
  Mat23 by_place = Mat23::Zero();
  by_place(0, 2) = depth.inverse_depth / depth.sigma;
  chain(camera, p, by_place, residual);
  return residual;
}

/// Of Cauchy's loss, as that of repeated least squares.
template <typename Residual>
double weight_of(const Residual& residual, double robust_px) {
  return robust_px > 0 ? 1 / (1 + residual.squaredNorm() / (robust_px * robust_px)) : 1;
}

template <typename Residual>
double loss_of(const Residual& residual, double robust_px) {
  const double squares = residual.squaredNorm(), scale = robust_px * robust_px;
  return robust_px > 0 ? scale * std::log1p(squares / scale) : squares;
}

/// The residuals of a prior, and their derivatives by rotation vector and centre of the camera.
struct PriorResidual {
  Vec6 value;
  Mat6 by_camera;
};

PriorResidual linear(const AdjustedCamera& camera, const AdjustedPrior& prior) {
  const Vec3 turn = vector_from_rotation(camera.cam_from_world * prior.cam_from_world.transpose());
  Vec6 error;
  error << turn, camera.centre - prior.centre;
  // To the second order of the turn (the inverse of SO(3)'s left Jacobian).
  Mat6 by_camera = Mat6::Identity();
  const Mat3 cross = cross_matrix(turn);
  by_camera.topLeftCorner<3, 3>() += cross * cross / 12 - cross / 2;
  return {prior.px_from_error * error, prior.px_from_error * by_camera};
}

template <typename Element>
std::vector<std::size_t> first_by_point(const std::vector<Element>& elements, std::size_t points) {
  std::vector<std::size_t> first(points + 1, 0);
  for (const Element& element : elements) ++first[element.point + 1];
  for (std::size_t p = 0; p < points; ++p) first[p + 1] += first[p];
  return first;
}

RelatedCameras related_by_points(const AdjustmentProblem& problem) {
  RelatedCameras related(problem.cameras.size());
  const std::vector<AdjustedObservation>& seen = problem.observations;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    for (std::size_t j = i + 1; j < seen.size() && seen[j].point == seen[i].point; ++j) {
      std::vector<std::uint32_t>& others = related[seen[i].camera];
      if (others.empty() || others.back() != seen[j].camera) others.push_back(seen[j].camera);
    }
  }
  return related;
}

void clear_unknown(int unknown, Mat6& covariance) {
  covariance.row(unknown).setZero();
  covariance.col(unknown).setZero();
}

}  // namespace

double cost_of_points(const AdjustmentProblem& problem, const ResidualWeights& weights) {
  double twice = 0;
  for (const AdjustedObservation& seen : problem.observations) {
    const AdjustedCamera& camera = problem.cameras[seen.camera];
    const Vec3 p = in_camera(camera, problem.points[seen.point]);
    if (!(p.z() > 0)) return std::numeric_limits<double>::infinity();
    twice += loss_of(residual_of(camera, p, seen), weights.robust_px);
  }
  for (const AdjustedDepth& depth : problem.depths) {
    const double residual = residual_of(in_camera(problem.cameras[depth.camera], problem.points[depth.point]), depth);
    twice += weights.depth * residual * residual;
  }
  return twice / 2;
}

double cost_of(const AdjustmentProblem& problem, const ResidualWeights& weights) {
  double twice = 0;
  for (const AdjustedPrior& prior : problem.priors)
    twice += loss_of(linear(problem.cameras[prior.camera], prior).value, prior.robust_px);
  return cost_of_points(problem, weights) + twice / 2;
}

double error_of(const AdjustmentProblem& problem, const AdjustedPrior& prior) {
  return linear(problem.cameras[prior.camera], prior).value.norm();
}

/// What one point contributes. Kept from point to point, because it needs memory.
struct NormalEquations::PointPart {
  struct Mixed {
    std::uint32_t camera = 0;
    Mat63 block;
  };
  std::vector<Mixed> mixed;
  Mat3 normal;
  Vec3 right;

  void clear() {
    mixed.clear();
    normal.setZero();
    right.setZero();
  }
  void add(const LinearResidual& residual, double weight) {
    normal.noalias() += weight * residual.by_point.transpose() * residual.by_point;
    right.noalias() -= weight * residual.by_point.transpose() * residual.value;
  }
  void add_mixed(std::uint32_t camera, const LinearResidual& residual, double weight) {
    auto of = std::find_if(mixed.begin(), mixed.end(), [&](const Mixed& one) { return one.camera == camera; });
    if (of == mixed.end()) of = mixed.insert(of, {camera, Mat63::Zero()});
    of->block.noalias() += weight * residual.by_camera.transpose() * residual.by_point;
  }
};

NormalEquations::NormalEquations(const AdjustmentProblem& problem)
    : first_observation_(first_by_point(problem.observations, problem.points.size())),
      first_depth_(first_by_point(problem.depths, problem.points.size())),
      observing_(problem.cameras.size(), 0),
      gauge_(problem.priors.empty() ? std::optional(gauge_of(problem)) : std::nullopt),
      system_(related_by_points(problem)) {
  for (const AdjustedObservation& seen : problem.observations) observing_[seen.camera] = 1;
}

template <typename Take>
void NormalEquations::for_each(const AdjustmentProblem& problem, std::size_t point, const ResidualWeights& weights,
                               Take take) const {
  for (std::size_t i = first_observation_[point]; i < first_observation_[point + 1]; ++i) {
    const AdjustedObservation& seen = problem.observations[i];
    const LinearResidual residual = linear(problem.cameras[seen.camera], problem.points[point], seen);
    take(seen.camera, residual, weight_of(residual.value, weights.robust_px));
  }
  for (std::size_t i = first_depth_[point]; i < first_depth_[point + 1]; ++i) {
    const AdjustedDepth& depth = problem.depths[i];
    take(depth.camera, linear(problem.cameras[depth.camera], problem.points[point], depth), weights.depth);
  }
}

void NormalEquations::eliminate(const PointPart& part, const Mat3& inverse) {
  for (std::size_t i = 0; i < part.mixed.size(); ++i) {
    const auto& [a, mixed] = part.mixed[i];
    Mat63 weighted;
    weighted.noalias() = -mixed * inverse;
    right_[a].noalias() += weighted * part.right;
    for (std::size_t j = 0; j <= i; ++j) {
      Mat6 block;
      block.noalias() = weighted * part.mixed[j].block.transpose();
      system_.add(a, part.mixed[j].camera, block);
    }
  }
}

void NormalEquations::damp_and_hold(double damping) {
  const auto hold = [&](std::uint32_t camera, int unknown) {
    system_.hold(camera, unknown);
    right_[camera][unknown] = 0;
  };
  for (std::uint32_t c = 0; c < normal_.size(); ++c) {
    normal_[c].diagonal() *= 1 + damping;
    system_.add(c, c, normal_[c]);
  }
  if (!gauge_) return;
  for (int k = 0; k < 6; ++k) hold(gauge_->first, k);
  if (gauge_->anchor != gauge_->first) hold(gauge_->anchor, 3 + gauge_->component);
}

/// Of the cameras' own blocks, only `normal_` is made.
bool NormalEquations::accumulate(const AdjustmentProblem& problem, const ResidualWeights& weights, double damping) {
  system_.clear();
  normal_.assign(problem.cameras.size(), Mat6::Zero());
  right_.assign(problem.cameras.size(), Vec6::Zero());
  down_.assign(problem.cameras.size(), Vec6::Zero());
  bool determined = true;
  with_widest_vectors([&] { determined = accumulate_points(problem, weights, damping); });
  if (!determined) return false;
  accumulate_priors(problem);
  for (std::size_t c = 0; c < right_.size(); ++c) right_[c] += down_[c];
  return true;
}

bool NormalEquations::accumulate_points(const AdjustmentProblem& problem, const ResidualWeights& weights,
                                        double damping) {
  PointPart part;
  for (std::size_t p = 0; p < problem.points.size(); ++p) {
    part.clear();
    for_each(problem, p, weights, [&](std::uint32_t camera, const LinearResidual& residual, double weight) {
      normal_[camera].noalias() += weight * residual.by_camera.transpose() * residual.by_camera;
      down_[camera].noalias() -= weight * residual.by_camera.transpose() * residual.value;
      part.add(residual, weight);
      part.add_mixed(camera, residual, weight);
    });
    if (part.mixed.empty()) continue;
    part.normal.diagonal() *= 1 + damping;
    const Mat3 inverse = part.normal.inverse();
    if (!inverse.allFinite()) return false;
    eliminate(part, inverse);
  }
  return true;
}

void NormalEquations::accumulate_priors(const AdjustmentProblem& problem) {
  for (const AdjustedPrior& prior : problem.priors) {
    const PriorResidual residual = linear(problem.cameras[prior.camera], prior);
    const double weight = weight_of(residual.value, prior.robust_px);
    normal_[prior.camera].noalias() += weight * residual.by_camera.transpose() * residual.by_camera;
    down_[prior.camera].noalias() -= weight * residual.by_camera.transpose() * residual.value;
  }
}

bool NormalEquations::reduce(const AdjustmentProblem& problem, const ResidualWeights& weights, double damping) {
  if (!accumulate(problem, weights, damping)) return false;
  damp_and_hold(damping);
  return true;
}

void NormalEquations::move_points(const AdjustmentProblem& problem, const ResidualWeights& weights, double damping,
                                  AdjustmentStep& step) const {
  step.points.assign(problem.points.size(), Vec3::Zero());
  PointPart part;
  for (std::size_t p = 0; p < problem.points.size(); ++p) {
    part.clear();
    Vec3 by_cameras = Vec3::Zero();
    for_each(problem, p, weights, [&](std::uint32_t camera, const LinearResidual& residual, double weight) {
      part.add(residual, weight);
      const Vec2 moved = weight * (residual.by_camera * step.cameras[camera]);
      by_cameras.noalias() += residual.by_point.transpose() * moved;
    });
    if (!(part.normal.trace() > 0)) continue;
    const Vec3 added = damping * part.normal.diagonal();
    part.normal.diagonal() += added;
    Vec3& move = step.points[p];
    move = part.normal.inverse() * (part.right - by_cameras);
    step.expected += 0.5 * move.dot(part.right + added.cwiseProduct(move));
  }
}

std::optional<AdjustmentStep> NormalEquations::step(const AdjustmentProblem& problem, const ResidualWeights& weights,
                                                    double damping) {
  if (!reduce(problem, weights, damping)) return std::nullopt;
  for (std::uint32_t c = 0; c < observing_.size(); ++c) {
    for (int k = 0; observing_[c] == 0 && k < 6; ++k) system_.hold(c, k);
  }
  if (!system_.factor()) return std::nullopt;
  AdjustmentStep step;
  step.cameras = right_;
  system_.solve(step.cameras);
  for (std::size_t c = 0; c < step.cameras.size(); ++c) {
    const Vec6 added = damping / (1 + damping) * normal_[c].diagonal();
    step.expected += 0.5 * step.cameras[c].dot(down_[c] + added.cwiseProduct(step.cameras[c]));
  }
  move_points(problem, weights, damping, step);
  return step;
}

std::vector<Mat6> NormalEquations::covariances(const AdjustmentProblem& problem, const ResidualWeights& weights) {
  if (!reduce(problem, weights, 0) || !system_.factor()) return {};
  std::vector<Mat6> covariances = system_.inverse_diagonal();
  if (!gauge_) return covariances;
  for (int k = 0; k < 6; ++k) clear_unknown(k, covariances[gauge_->first]);
  if (gauge_->anchor != gauge_->first) clear_unknown(3 + gauge_->component, covariances[gauge_->anchor]);
  return covariances;
}

std::optional<CameraEquations> NormalEquations::of_cameras(const AdjustmentProblem& problem,
                                                           const ResidualWeights& weights) {
  if (!accumulate(problem, weights, 0)) return std::nullopt;
  for (std::uint32_t c = 0; c < normal_.size(); ++c) system_.add(c, c, normal_[c]);
  return CameraEquations{system_.blocks(), right_};
}

}  // namespace ilp::model
