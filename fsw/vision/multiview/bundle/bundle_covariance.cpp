#include "fsw/vision/multiview/bundle/bundle_covariance.hpp"

#include <cmath>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "fsw/vision/multiview/bundle/dense_cholesky.hpp"

namespace ilp {
namespace {

// Just enough that a point on parallel rays does not stop the elimination.
constexpr double damping = 1e-10;

/// T = W L^-T, the coupling of a camera with a point whose V is L L^T (`l` as the elimination leaves it): three columns
/// of six.
void couple(const bundle::Linearised& at, const double l[6], double t[18]) {
  for (std::size_t a = 0; a < 3; ++a) {
    double w[3];
    double c[3];
    for (int k = 0; k < 3; ++k) {
      w[k] = at.wu[a] * at.pu[k] + at.wv[a] * at.pv[k];
      c[k] = -(at.pu[a] * at.pu[k] + at.pv[a] * at.pv[k]);
    }
    for (double* row : {w, c}) {
      row[0] *= l[3];
      row[1] = (row[1] - row[0] * l[0]) * l[4];
      row[2] = (row[2] - row[0] * l[1] - row[1] * l[2]) * l[5];
    }
    for (std::size_t k = 0; k < 3; ++k) {
      t[6 * k + a] = w[k];
      t[6 * k + 3 + a] = c[k];
    }
  }
}

/// block += T_a T_b^T in a matrix with rows of m.
void add_product(const double a[18], const double b[18], std::size_t m, double* block) {
  for (std::size_t r = 0; r < 6; ++r) {
    for (std::size_t c = 0; c < 6; ++c) block[m * r + c] += a[r] * b[c] + a[6 + r] * b[6 + c] + a[12 + r] * b[12 + c];
  }
}

}  // namespace

double BundleAdjuster::covariance_factor() const {
  double influence = 0;  // squares of weighted residuals
  double weights = 0;
  double slopes = 0;  // mean derivative of a weighted residual by the residual
  double squared_slopes = 0;
  for (std::size_t s = 0; s < span_count_; ++s) {
    const PointSpan& span = spans_[s];
    for (std::uint32_t i = span.first; i < span.last; ++i) {
      const Observation& o = observations_[i];
      const bundle::Linearised at =
          bundle::linearise(cameras_[o.camera], o, problem_->points[span.point].position, {0, false});
      const double squared = at.eu * at.eu + at.ev * at.ev;
      double weight = 1;
      (void)loss()(squared, weight);
      influence += weight * weight * squared;
      weights += weight;
      const double slope = loss().slope(weight);
      slopes += slope;
      squared_slopes += slope * slope;
    }
  }
  const auto observations = static_cast<double>(active_observations_);
  const double unknowns = 3.0 * static_cast<double>(span_count_) + 6.0 * static_cast<double>(free_count_) -
                          (problem_->hold.origin >= 0 ? 1 : 0);
  const double redundancy = 2 * observations - unknowns;
  if (!(redundancy > 0) || !(slopes > 0)) return 0;
  // P. J. Huber, Robust Statistics, 1981, section 7.6: variance of the weighted residuals over the square of their mean
  // slope, on the inverse of unweighted normal equations; those here carry the weights, so their mean comes back in.
  const double mean_slope = slopes / observations;
  const double spread = squared_slopes / observations / (mean_slope * mean_slope) - 1;
  const double correction = 1 + unknowns / (2 * observations) * spread;
  return correction * correction * influence / redundancy * (weights / observations) / (mean_slope * mean_slope);
}

void BundleAdjuster::covariances(BundleResult& result, BundleCovariance* joint) {
  if (joint != nullptr) *joint = {};
  if (free_count_ == 0 || !frame_is_fixed()) return;
  const double factor = covariance_factor();
  if (!(factor > 0) || !linearise(damping)) return;
  assemble(damping);
  if (!cholesky_factor(system_.data(), camera_size * free_count_)) return;
  position_covariances(factor, result);
  if (joint != nullptr) joint_covariance(factor, *joint);
}

bool BundleAdjuster::frame_is_fixed() const {
  const std::size_t fixed = problem_->cameras.size() - free_count_;
  if (fixed != 1 || problem_->hold.origin >= 0) return fixed > 0;
  for (const BundleHeightPrior& prior : problem_->heights) {
    if (cameras_[prior.camera].free_index >= 0) return true;
  }
  return false;
}

/// Column of the covariance into camera_step_. The normal equations M carry priors P with the weight w that the
/// adjustment gave them; observations of another variance v than that make the covariance
/// M^-1 (v (M - w P) + w^2 P) M^-1 = v M^-1 + w (w - v) M^-1 P M^-1.
void BundleAdjuster::covariance_column(double factor, std::size_t column) {
  const std::size_t n = camera_size * free_count_;
  for (std::size_t k = 0; k < n; ++k) camera_step_[k] = 0;
  camera_step_[column] = 1;
  cholesky_solve(system_.data(), n, camera_step_.data());
  if (problem_->heights.empty() && problem_->attitudes.empty()) {
    for (std::size_t k = 0; k < n; ++k) camera_step_[k] *= factor;
    return;
  }
  multiply_priors(camera_step_.data(), column_.data());
  cholesky_solve(system_.data(), n, column_.data());
  const double weight = params_.observation_sigma_px * params_.observation_sigma_px;
  for (std::size_t k = 0; k < n; ++k) {
    camera_step_[k] = factor * camera_step_[k] + weight * (weight - factor) * column_[k];
  }
}

void BundleAdjuster::position_covariances(double factor, BundleResult& result) {
  for (std::size_t a = 0; a < free_count_; ++a) {
    BundleResult::PositionCovariance& out = result.cameras[camera_of_free_[a]];
    for (std::size_t c = 0; c < 3; ++c) {
      covariance_column(factor, camera_size * a + 3 + c);
      for (std::size_t r = 0; r < 3; ++r) out.matrix[3 * r + c] = camera_step_[camera_size * a + 3 + r];
      const double variance = out.matrix[4 * c];
      out.sigma[c] = variance > 0 ? std::sqrt(variance) : 0;
    }
  }
  result.covariance_valid = true;
}

void BundleAdjuster::joint_covariance(double factor, BundleCovariance& joint) {
  for (std::size_t i = 0; i < problem_->cameras.size(); ++i) {
    const auto index = static_cast<std::uint16_t>(i);
    if (cameras_[i].free_index >= 0) {
      joint.free_camera[joint.free_count++] = index;
    } else {
      joint.fixed_camera[joint.fixed_count++] = index;
    }
  }
  joint.variance = factor;
  const std::size_t n = camera_size * joint.free_count;
  const std::size_t m = camera_size * joint.fixed_count;
  for (std::size_t c = 0; c < n; ++c) {
    covariance_column(factor, c);
    // Both triangles from one, so that the matrix is symmetric to the last bit.
    for (std::size_t r = c; r < n; ++r) joint.conditional[n * r + c] = joint.conditional[n * c + r] = camera_step_[r];
  }
  free_fixed_blocks(joint);
  for (std::size_t c = 0; c < m; ++c) {
    for (std::size_t r = 0; r < n; ++r) camera_step_[r] = joint.transfer[m * r + c];
    cholesky_solve(system_.data(), n, camera_step_.data());
    for (std::size_t r = 0; r < n; ++r) joint.transfer[m * r + c] = camera_step_[r];
  }
  joint.valid = true;
}

/// Writes -S_fm into the transfer. A free and a fixed camera are coupled only by the points and by the held distance.
void BundleAdjuster::free_fixed_blocks(BundleCovariance& joint) {
  const std::size_t m = camera_size * joint.fixed_count;
  std::array<std::size_t, limits::max_bundle_cameras> column;
  for (std::size_t f = 0; f < joint.fixed_count; ++f) column[joint.fixed_camera[f]] = camera_size * f;
  with_widest_vectors([&] {
    for (std::size_t p = 0; p < packet_count_; ++p) {
      const Packet& packet = packets_[p];
      for (int lane = 0; lane < (packet.a == packet.b ? 1 : 2); ++lane) {
        const PointSpan& span = spans_[lane == 0 ? packet.a : packet.b];
        double l[6];
        for (int k = 0; k < 6; ++k) l[k] = eliminated_[p].l[k][lane];
        double t[limits::max_bundle_cameras][18];
        for (std::uint32_t i = span.first; i < span.last; ++i) {
          const Observation& o = observations_[i];
          couple(bundle::linearise(cameras_[o.camera], o, problem_->points[span.point].position, loss()), l,
                 t[i - span.first]);
        }
        for (std::uint32_t i = span.first; i < span.last; ++i) {
          const std::int32_t a = cameras_[observations_[i].camera].free_index;
          for (std::uint32_t j = span.first; a >= 0 && j < span.last; ++j) {
            const std::uint16_t fixed = observations_[j].camera;
            if (cameras_[fixed].free_index >= 0) continue;
            const std::size_t row = camera_size * static_cast<std::size_t>(a);
            add_product(t[i - span.first], t[j - span.first], m, &joint.transfer[row * m + column[fixed]]);
          }
        }
      }
    }
  });
  if (problem_->hold.origin >= 0) add_held_distance(joint);
}

/// The origin of a held distance is the only fixed camera.
void BundleAdjuster::add_held_distance(BundleCovariance& joint) {
  const HeldDistance held = held_distance();
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) {
      joint.transfer[camera_size * (camera_size * held.block + 3 + r) + 3 + c] +=
          held.stiffness * held.direction[r] * held.direction[c];
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    joint.scale[camera_size * held.block + 3 + k] = held.stiffness * held.length * held.direction[k];
  }
  cholesky_solve(system_.data(), camera_size * free_count_, joint.scale.data());
}

}  // namespace ilp
