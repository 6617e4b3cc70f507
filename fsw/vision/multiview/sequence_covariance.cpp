#include "fsw/vision/multiview/sequence_covariance.hpp"

#include <cmath>

#include "cfg/limits.hpp"
#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "fsw/vision/multiview/bundle/bundle_observation.hpp"
#include "fsw/vision/multiview/window_problem.hpp"

namespace ilp {
namespace {

constexpr std::size_t camera_size = StripCovariance::camera_size;
constexpr std::size_t strip_size = StripCovariance::size;

bool in_front(const bundle::Camera& camera, const double point[3]) {
  double z = 0;
  for (int k = 0; k < 3; ++k) z += camera.rotation[6 + k] * (point[k] - camera.centre[k]);
  return z > 0;
}

/// Gradient of one track by the free cameras, of which it sees a few.
struct TrackGradient {
  std::array<double, strip_size> values{};
  std::array<std::size_t, limits::max_bundle_cameras> block{};  ///< first parameters of the cameras seen
  std::size_t blocks = 0;

  void add(std::size_t first, double weight, const bundle::Linearised& at) {
    block[blocks++] = first;
    for (std::size_t k = 0; k < 3; ++k) {
      values[first + k] = weight * (at.wu[k] * at.eu + at.wv[k] * at.ev);
      values[first + 3 + k] = -weight * (at.pu[k] * at.eu + at.pv[k] * at.ev);
    }
  }

  /// Adds g g^T to the n x n matrix.
  void scatter_into(double* matrix, std::size_t n) const {
    for (std::size_t i = 0; i < blocks; ++i) {
      for (std::size_t j = 0; j < blocks; ++j) {
        for (std::size_t r = block[i]; r < block[i] + camera_size; ++r) {
          for (std::size_t c = block[j]; c < block[j] + camera_size; ++c) matrix[n * r + c] += values[r] * values[c];
        }
      }
    }
  }
};

/// The factor by which weighted normal equations overrate their observations.
class Overrated {
 public:
  void add(double weight, double slope) {
    weights_ += weight;
    slopes_ += slope;
    squared_slopes_ += slope * slope;
    coordinates_ += 2;
  }

  /// Mean robust weight over mean derivative of a weighted residual by the residual, with the correction for residuals
  /// that `unknowns` have made smaller than the errors (P. J. Huber, Robust Statistics, 1981, sections 7.6, 7.9).
  [[nodiscard]] double factor(double unknowns) const {
    if (!(slopes_ > 0)) return 1;
    const double mean_slope = 2 * slopes_ / coordinates_;
    const double spread = 2 * squared_slopes_ / (coordinates_ * mean_slope * mean_slope) - 1;
    return weights_ / slopes_ * (1 + unknowns / coordinates_ * spread);
  }

 private:
  double weights_ = 0;
  double slopes_ = 0;
  double squared_slopes_ = 0;
  double coordinates_ = 0;
};

/// Sum of g g^T over the tracks. Returns the factor by which the normal equations of the n unknowns overrate them.
double scatter_of_tracks(const BundleProblem& problem, const bundle::Loss& loss, const bundle::Camera* cameras,
                         std::size_t n, double* scatter) {
  for (std::size_t i = 0; i < n * n; ++i) scatter[i] = 0;
  Overrated overrated;
  TrackGradient gradient;
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    const BundleObservation& o = problem.observations[i];
    const bundle::Camera& camera = cameras[o.camera];
    const double* point = problem.points[o.point].position;
    if (in_front(camera, point)) {
      const bundle::Linearised at = bundle::linearise(camera, {o.x, o.y, o.camera}, point, 0);
      const double weight = loss.weight(at.eu * at.eu + at.ev * at.ev);
      overrated.add(weight, loss.slope(weight));
      if (camera.free) gradient.add(camera_size * camera.block, weight, at);
    }
    if (i + 1 < problem.observations.size() && problem.observations[i + 1].point == o.point) continue;
    gradient.scatter_into(scatter, n);
    gradient.blocks = 0;
  }
  return overrated.factor(3.0 * static_cast<double>(problem.points.size()) + static_cast<double>(n));
}

/// to (rows x columns) = a (rows x inner) times b (inner x columns), row-major.
void multiply(const double* a, const double* b, std::size_t rows, std::size_t inner, std::size_t columns, double* to) {
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c) to[columns * r + c] = 0;
    for (std::size_t k = 0; k < inner; ++k) {
      const double factor = a[inner * r + k];
      if (factor == 0) continue;
      for (std::size_t c = 0; c < columns; ++c) to[columns * r + c] += factor * b[columns * k + c];
    }
  }
}

void set_both(StripCovariance& strip, std::size_t r, std::size_t c, double value) {
  strip.matrix[strip_size * r + c] = strip.matrix[strip_size * c + r] = value;
}

std::size_t first_row(const WindowMap& map, std::size_t camera) {
  return camera_size * map.camera[camera];
}

/// Row of the strip's covariance for every free parameter of the window; returns their number.
std::size_t rows_of_free(const BundleCovariance& window, const WindowMap& map,
                         std::array<std::size_t, strip_size>& row) {
  const std::size_t n = camera_size * window.free_count;
  for (std::size_t r = 0; r < n; ++r) row[r] = first_row(map, window.free_camera[r / camera_size]) + r % camera_size;
  return n;
}

/// G: the transfer in the columns of the fixed cameras, and the held distance by the two centres that it lies between.
void fill_derivative(const BundleProblem& problem, const WindowMap& map, const BundleCovariance& window, std::size_t n,
                     double* derivative) {
  for (std::size_t i = 0; i < n * strip_size; ++i) derivative[i] = 0;
  const std::size_t m = camera_size * window.fixed_count;
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t c = 0; c < m; ++c) {
      const std::size_t column = first_row(map, window.fixed_camera[c / camera_size]) + c % camera_size;
      derivative[strip_size * r + column] = window.transfer[m * r + c];
    }
  }
  if (!problem.hold.held) return;
  const auto origin = std::size_t{problem.hold.origin};
  const auto anchor = std::size_t{problem.hold.anchor};
  double along[3];
  double squared = 0;
  for (int k = 0; k < 3; ++k) {
    along[k] = problem.cameras[anchor].pose.centre[k] - problem.cameras[origin].pose.centre[k];
    squared += along[k] * along[k];
  }
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double by_centre = window.scale[r] * along[k] / squared;
      derivative[strip_size * r + first_row(map, anchor) + 3 + k] += by_centre;
      derivative[strip_size * r + first_row(map, origin) + 3 + k] -= by_centre;
    }
  }
}

bool knows_all(const StripCovariance& strip, const WindowMap& map, const BundleCovariance& window) {
  bool all = window.valid;
  for (std::size_t f = 0; f < window.fixed_count; ++f)
    all = all && ((strip.known >> map.camera[window.fixed_camera[f]]) & 1U);
  return all;
}

}  // namespace

void covariance_of_camera(const StripCovariance& strip, std::size_t index, double (&lower)[21]) {
  const bool known = ((strip.known >> index) & 1U) != 0;
  const std::size_t first = camera_size * index;
  for (std::size_t row = 0, k = 0; row < camera_size; ++row) {
    for (std::size_t column = 0; column <= row; ++column, ++k) {
      lower[k] = known ? strip.matrix[(first + row) * strip_size + first + column] : 0;
    }
  }
}

void covariance_of_step(const StripCovariance& strip, std::size_t index, const RigidTransform& previous,
                        const RigidTransform& camera, double (&lower)[21]) {
  for (double& x : lower) x = 0;
  if (index == 0 || ((strip.known >> index) & 1U) == 0 || ((strip.known >> (index - 1)) & 1U) == 0) return;
  const RigidTransform step = compose(camera, inverse(previous));
  const Vec3 place = -(step.rotation.transpose() * step.translation);
  // Error of the step by the errors of both cameras: rotation w_c - R w_p, place R_p (c_c - c_p) + w_p x place.
  Eigen::Matrix<double, 6, 12> by_cameras = Eigen::Matrix<double, 6, 12>::Zero();
  by_cameras.block<3, 3>(0, 0) = -step.rotation;
  by_cameras.block<3, 3>(0, 6).setIdentity();
  by_cameras.block<3, 3>(3, 0) = -cross_matrix(place);
  by_cameras.block<3, 3>(3, 3) = -previous.rotation;
  by_cameras.block<3, 3>(3, 9) = previous.rotation;
  Eigen::Matrix<double, 12, 12> joint;
  const std::size_t first = camera_size * (index - 1);
  for (int row = 0; row < 12; ++row) {
    for (int column = 0; column < 12; ++column) {
      joint(row, column) =
          strip.matrix[(first + static_cast<std::size_t>(row)) * strip_size + first + static_cast<std::size_t>(column)];
    }
  }
  const Eigen::Matrix<double, 6, 12> half = by_cameras.lazyProduct(joint);
  for (int row = 0, k = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column, ++k) lower[k] = half.row(row).dot(by_cameras.row(column));
  }
}

void begin_covariance(StripCovariance& strip) {
  strip.matrix.fill(0);
  strip.known = 1;
}

void drop_oldest_camera(StripCovariance& strip) {
  for (std::size_t r = 0; r < strip_size; ++r) {
    for (std::size_t c = 0; c < strip_size; ++c) {
      const bool kept = r + camera_size < strip_size && c + camera_size < strip_size;
      strip.matrix[strip_size * r + c] = kept ? strip.matrix[strip_size * (r + camera_size) + c + camera_size] : 0;
    }
  }
  strip.known >>= 1U;
}

void allow_correlated_tracks(const BundleProblem& problem, const BundleParams& params,
                             StripCovarianceWorkspace& workspace) {
  BundleCovariance& window = workspace.window;
  const std::size_t n = camera_size * window.free_count;
  const std::size_t tracks = problem.points.size();
  if (!window.valid || tracks <= n) return;
  std::array<bundle::Camera, limits::max_bundle_cameras> cameras;
  for (std::size_t i = 0; i < problem.cameras.size(); ++i) cameras[i] = bundle::camera_from(problem.cameras[i]);
  for (std::size_t f = 0; f < window.free_count; ++f) {
    cameras[window.free_camera[f]].free = true;
    cameras[window.free_camera[f]].block = static_cast<std::uint32_t>(f);
  }
  double* scatter = workspace.scatter.data();
  const bundle::Loss loss{params.robust_px, params.loss == BundleLoss::cauchy};
  const double overrated = scatter_of_tracks(problem, loss, cameras.data(), n, scatter);
  double* conditional = window.conditional.data();
  double* product = workspace.product.data();
  multiply(conditional, scatter, n, n, n, product);
  multiply(product, conditional, n, n, n, scatter);
  const double few = static_cast<double>(tracks) / static_cast<double>(tracks - n);
  const double factor = few * overrated * overrated / (window.variance * window.variance);
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t c = 0; c <= r; ++c) conditional[n * r + c] = conditional[n * c + r] = factor * scatter[n * r + c];
  }
}

void propagate_covariance(const BundleProblem& problem, const WindowMap& map, StripCovarianceWorkspace& workspace,
                          StripCovariance& strip) {
  const BundleCovariance& window = workspace.window;
  if (!knows_all(strip, map, window)) return;
  std::array<std::size_t, strip_size> row;
  const std::size_t n = rows_of_free(window, map, row);
  double* derivative = workspace.derivative.data();
  double* product = workspace.product.data();
  fill_derivative(problem, map, window, n, derivative);
  multiply(derivative, strip.matrix.data(), n, strip_size, strip_size, product);
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t c = 0; c < strip_size; ++c) set_both(strip, row[r], c, product[strip_size * r + c]);
  }
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t c = 0; c <= r; ++c) {
      double sum = window.conditional[n * r + c];
      for (std::size_t k = 0; k < strip_size; ++k) sum += product[strip_size * r + k] * derivative[strip_size * c + k];
      set_both(strip, row[r], row[c], sum);
    }
  }
  for (std::size_t f = 0; f < window.free_count; ++f) strip.known |= 1U << map.camera[window.free_camera[f]];
}

}  // namespace ilp
