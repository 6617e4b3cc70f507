#include "fsw/vision/multiview/bundle/bundle_covariance.hpp"

#include <cmath>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/multiview/bundle/bundle_equations.hpp"
#include "fsw/vision/multiview/bundle/dense_cholesky.hpp"

namespace ilp::bundle {
namespace {

// Just enough that a point on parallel rays does not stop the elimination.
constexpr double damping = 1e-10;

/// T = W L^-T, the coupling of a camera with a point whose V is L L^T (`l` as the elimination leaves it): three columns
/// of six.
void couple(const Linearised& at, const double l[6], double t[18]) {
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

double covariance_factor(const Equations& eq) {
  double influence = 0;  // squares of weighted residuals
  double weights = 0;
  double slopes = 0;  // mean derivative of a weighted residual by the residual
  double squared_slopes = 0;
  for (std::size_t s = 0; s < eq.span_count; ++s) {
    const PointSpan& span = eq.spans[s];
    for (std::uint32_t i = span.first; i < span.last; ++i) {
      const Observation& o = eq.observations[i];
      const Linearised at = linearise(eq.cameras[o.camera], o, eq.problem->points[span.point].position, {});
      const double squared = at.eu * at.eu + at.ev * at.ev;
      const double weight = eq.loss().weight(squared);
      influence += weight * weight * squared;
      weights += weight;
      const double slope = Loss::slope(weight);
      slopes += slope;
      squared_slopes += slope * slope;
    }
  }
  const auto observations = static_cast<double>(eq.active_observations);
  const double unknowns = 3.0 * static_cast<double>(eq.span_count) + 6.0 * static_cast<double>(eq.free_count) -
                          (eq.problem->hold.held ? 1 : 0);
  const double redundancy = 2 * observations - unknowns;
  if (!(redundancy > 0) || !(slopes > 0)) return 0;
  // P. J. Huber, Robust Statistics, 1981, section 7.6: variance of the weighted residuals over the square of their mean
  // slope, on the inverse of unweighted normal equations; those here carry the weights, so their mean comes back in.
  const double mean_slope = slopes / observations;
  const double spread = squared_slopes / observations / (mean_slope * mean_slope) - 1;
  const double correction = 1 + unknowns / (2 * observations) * spread;
  return correction * correction * influence / redundancy * (weights / observations) / (mean_slope * mean_slope);
}

bool frame_is_fixed(const Equations& eq) {
  const std::size_t fixed = eq.problem->cameras.size() - eq.free_count;
  return fixed > 1 || (fixed == 1 && eq.problem->hold.held);
}

/// Column of the covariance into eq.camera_step.
void covariance_column(Equations& eq, double factor, std::size_t column) {
  const std::size_t n = camera_size * eq.free_count;
  for (std::size_t k = 0; k < n; ++k) eq.camera_step[k] = 0;
  eq.camera_step[column] = 1;
  cholesky_solve(eq.system.data(), n, eq.camera_step.data());
  for (std::size_t k = 0; k < n; ++k) eq.camera_step[k] *= factor;
}

void position_covariances(Equations& eq, double factor, BundleResult& result) {
  for (std::size_t a = 0; a < eq.free_count; ++a) {
    BundleResult::PositionCovariance& out = result.cameras[eq.camera_of_free[a]];
    for (std::size_t c = 0; c < 3; ++c) {
      covariance_column(eq, factor, camera_size * a + 3 + c);
      for (std::size_t r = 0; r < 3; ++r) out.matrix[3 * r + c] = eq.camera_step[camera_size * a + 3 + r];
      const double variance = out.matrix[4 * c];
      out.sigma[c] = variance > 0 ? std::sqrt(variance) : 0;
    }
  }
  result.covariance_valid = true;
}

/// The origin of a held distance is the only fixed camera.
void add_held_distance(Equations& eq, BundleCovariance& joint) {
  const HeldDistance held = held_distance(eq);
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) {
      joint.transfer[camera_size * (camera_size * held.block + 3 + r) + 3 + c] +=
          held.stiffness * held.direction[r] * held.direction[c];
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    joint.scale[camera_size * held.block + 3 + k] = held.stiffness * held.length * held.direction[k];
  }
  cholesky_solve(eq.system.data(), camera_size * eq.free_count, joint.scale.data());
}

/// Writes -S_fm into the transfer. A free and a fixed camera are coupled only by the points and by the held distance.
void free_fixed_blocks(Equations& eq, BundleCovariance& joint) {
  const std::size_t m = camera_size * joint.fixed_count;
  std::array<std::size_t, max_cameras> column;
  for (std::size_t f = 0; f < joint.fixed_count; ++f) column[joint.fixed_camera[f]] = camera_size * f;
  with_widest_vectors([&] {
    for (std::size_t p = 0; p < eq.packet_count; ++p) {
      const Packet& packet = eq.packets[p];
      for (int lane = 0; lane < (packet.a == packet.b ? 1 : 2); ++lane) {
        const PointSpan& span = eq.spans[lane == 0 ? packet.a : packet.b];
        double l[6];
        for (int k = 0; k < 6; ++k) l[k] = eq.eliminated[p].l[k][lane];
        double t[max_cameras][18];
        for (std::uint32_t i = span.first; i < span.last; ++i) {
          const Observation& o = eq.observations[i];
          couple(linearise(eq.cameras[o.camera], o, eq.problem->points[span.point].position, eq.loss()), l,
                 t[i - span.first]);
        }
        for (std::uint32_t i = span.first; i < span.last; ++i) {
          const Camera& a = eq.cameras[eq.observations[i].camera];
          for (std::uint32_t j = span.first; a.free && j < span.last; ++j) {
            const std::uint16_t fixed = eq.observations[j].camera;
            if (eq.cameras[fixed].free) continue;
            const std::size_t row = camera_size * a.block;
            add_product(t[i - span.first], t[j - span.first], m, &joint.transfer[row * m + column[fixed]]);
          }
        }
      }
    }
  });
  if (eq.problem->hold.held) add_held_distance(eq, joint);
}

void joint_covariance(Equations& eq, double factor, BundleCovariance& joint) {
  for (std::size_t i = 0; i < eq.problem->cameras.size(); ++i) {
    const auto index = static_cast<std::uint16_t>(i);
    if (eq.cameras[i].free) {
      joint.free_camera[joint.free_count++] = index;
    } else {
      joint.fixed_camera[joint.fixed_count++] = index;
    }
  }
  joint.variance = factor;
  const std::size_t n = camera_size * joint.free_count;
  const std::size_t m = camera_size * joint.fixed_count;
  for (std::size_t c = 0; c < n; ++c) {
    covariance_column(eq, factor, c);
    // Both triangles from one, so that the matrix is symmetric to the last bit.
    for (std::size_t r = c; r < n; ++r) joint.conditional[n * r + c] = joint.conditional[n * c + r] = eq.camera_step[r];
  }
  free_fixed_blocks(eq, joint);
  for (std::size_t c = 0; c < m; ++c) {
    for (std::size_t r = 0; r < n; ++r) eq.camera_step[r] = joint.transfer[m * r + c];
    cholesky_solve(eq.system.data(), n, eq.camera_step.data());
    for (std::size_t r = 0; r < n; ++r) joint.transfer[m * r + c] = eq.camera_step[r];
  }
  joint.valid = true;
}

}  // namespace

void covariances(Equations& eq, BundleResult& result, BundleCovariance* joint) {
  if (joint != nullptr) *joint = {};
  if (eq.free_count == 0 || !frame_is_fixed(eq)) return;
  const double factor = covariance_factor(eq);
  if (!(factor > 0) || !linearise(eq, damping)) return;
  assemble(eq, damping);
  if (!cholesky_factor(eq.system.data(), camera_size * eq.free_count)) return;
  position_covariances(eq, factor, result);
  if (joint != nullptr) joint_covariance(eq, factor, *joint);
}

}  // namespace ilp::bundle
