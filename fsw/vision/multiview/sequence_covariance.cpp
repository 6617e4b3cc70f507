#include "fsw/vision/multiview/sequence_covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "cfg/limits.hpp"
#include "fsw/vision/geometry/camera.hpp"
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

/// The cameras of a problem, and which parameters of the window each free one has.
void free_cameras(const BundleProblem& problem, const BundleCovariance& window,
                  std::array<bundle::Camera, limits::max_bundle_cameras>& cameras) {
  for (std::size_t i = 0; i < problem.cameras.size(); ++i) cameras[i] = bundle::camera_from(problem.cameras[i]);
  for (std::size_t f = 0; f < window.free_count; ++f) {
    cameras[window.free_camera[f]].free = true;
    cameras[window.free_camera[f]].block = static_cast<std::uint32_t>(f);
  }
}

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
      const bundle::Linearised at = bundle::linearise(camera, {o.x, o.y, o.camera}, point, {});
      const double weight = loss.weight(at.eu * at.eu + at.ev * at.ev);
      overrated.add(weight, bundle::Loss::slope(weight));
      if (camera.free) gradient.add(camera_size * camera.block, weight, at);
    }
    if (i + 1 < problem.observations.size() && problem.observations[i + 1].point == o.point) continue;
    gradient.scatter_into(scatter, n);
    gradient.blocks = 0;
  }
  return overrated.factor(3.0 * static_cast<double>(problem.points.size()) + static_cast<double>(n));
}

using MatIntrinsics = Eigen::Matrix<double, 2, static_cast<int>(intrinsic_count)>;
using MatByPoint = Eigen::Matrix<double, 3, static_cast<int>(intrinsic_count)>;

/// Normal equations of one track: its point, what it has in common with the free cameras, and the intrinsics.
struct TrackEquations {
  struct Seen {
    std::size_t first;  ///< parameters of the camera; `none` for a fixed one
    Eigen::Matrix<double, 6, 3> with_point;
    Eigen::Matrix<double, 6, static_cast<int>(intrinsic_count)> with_intrinsics;
  };
  static constexpr std::size_t none = strip_size;
  Mat3 point = Mat3::Zero();
  MatByPoint point_with_intrinsics = MatByPoint::Zero();
  std::array<Seen, limits::max_bundle_cameras> seen;
  std::size_t count = 0;

  void add(std::size_t first, const bundle::Linearised& at, const MatIntrinsics& by_intrinsics) {
    Eigen::Matrix<double, 2, 3> by_point;
    Eigen::Matrix<double, 2, 6> by_camera;
    by_point << at.pu[0], at.pu[1], at.pu[2], at.pv[0], at.pv[1], at.pv[2];
    by_camera << at.wu[0], at.wu[1], at.wu[2], -by_point.row(0), at.wv[0], at.wv[1], at.wv[2], -by_point.row(1);
    point += by_point.transpose() * by_point;
    point_with_intrinsics += by_point.transpose() * by_intrinsics;
    if (first == none || count == seen.size()) return;
    seen[count++] = {first, by_camera.transpose() * by_point, by_camera.transpose() * by_intrinsics};
  }

  void clear() {
    point.setZero();
    point_with_intrinsics.setZero();
    count = 0;
  }

  /// Adds its part of the equations without the point to `sums` (parameters x intrinsics, row-major).
  void scatter_into(double* sums) const {
    Mat3 held = point;
    held.diagonal().array() += 1e-12 * point.trace() + 1e-300;
    const Eigen::LLT<Mat3> factor(held);
    if (factor.info() != Eigen::Success) return;
    const MatByPoint moved = factor.solve(point_with_intrinsics);
    for (std::size_t i = 0; i < count; ++i) {
      const auto reduced = (seen[i].with_intrinsics - seen[i].with_point * moved).eval();
      for (int r = 0; r < 6; ++r) {
        for (int c = 0; c < static_cast<int>(intrinsic_count); ++c) {
          sums[(seen[i].first + static_cast<std::size_t>(r)) * intrinsic_count + static_cast<std::size_t>(c)] +=
              reduced(r, c);
        }
      }
    }
  }
};

/// How an ideal pixel moves where the intrinsics change and the pixel of the image stays, with the opposite sign.
MatIntrinsics ideal_by_intrinsics(const CameraModel& camera, const Vec2& normalised) {
  const DistortionJacobian j = distortion_jacobian(camera, normalised.x(), normalised.y());
  Eigen::Matrix2d by_normalised;
  by_normalised << j.a, j.b * camera.fx / camera.fy, j.c * camera.fy / camera.fx, j.d;
  return by_normalised.inverse() * pixel_by_intrinsics(camera, normalised);
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

/// Derivative of a step by both cameras: rotation w_c - R w_p, place R_p (c_c - c_p) + w_p x place.
Eigen::Matrix<double, 6, 12> step_by_cameras(const RigidTransform& previous, const RigidTransform& camera) {
  const RigidTransform step = compose(camera, inverse(previous));
  const Vec3 place = -(step.rotation.transpose() * step.translation);
  Eigen::Matrix<double, 6, 12> by_cameras = Eigen::Matrix<double, 6, 12>::Zero();
  by_cameras.block<3, 3>(0, 0) = -step.rotation;
  by_cameras.block<3, 3>(0, 6).setIdentity();
  by_cameras.block<3, 3>(3, 0) = -cross_matrix(place);
  by_cameras.block<3, 3>(3, 3) = -previous.rotation;
  by_cameras.block<3, 3>(3, 9) = previous.rotation;
  return by_cameras;
}

using SixByIntrinsics = Eigen::Matrix<double, 6, static_cast<int>(intrinsic_count)>;

SixByIntrinsics derivative_of(const StripCovariance& strip, std::size_t index) {
  return Eigen::Map<const Eigen::Matrix<double, 6, static_cast<int>(intrinsic_count), Eigen::RowMajor>>(
      strip.by_intrinsics.data() + camera_size * index * intrinsic_count);
}

void add_transformed(const SixByIntrinsics& j, const IntrinsicsCovariance& lens, double (&lower)[21]) {
  const SixByIntrinsics half = j.lazyProduct(lens);
  for (int row = 0, k = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column, ++k) lower[k] += half.row(row).dot(j.row(column));
  }
}

/// How the direction (X/Z, Y/Z) of a pixel moves where the intrinsics change.
MatIntrinsics direction_by_intrinsics(const CameraModel& camera, const Vec2& normalised) {
  MatIntrinsics by = -ideal_by_intrinsics(camera, normalised);
  by.row(0) /= camera.fx;
  by.row(1) /= camera.fy;
  return by;
}

struct Sighting {
  Vec2 pixel;    ///< of the first camera
  double depth;  ///< along its optical axis
};
using DepthByIntrinsics = Eigen::Matrix<double, 1, static_cast<int>(intrinsic_count)>;

/// Derivative of log(depth), the ground's pixel in the second image being given. False where that image has none.
bool depth_by_intrinsics(const CameraModel& model, const RigidTransform& second_from_first,
                         const SixByIntrinsics& step_by_lens, const Sighting& seen, DepthByIntrinsics& derivative) {
  const Vec2 first = normalised_from_pixel(model, seen.pixel);
  const Vec3 ray = second_from_first.rotation * Vec3(first.x(), first.y(), 1);
  const Vec3 q = seen.depth * ray + second_from_first.translation;
  if (!(q.z() > 1e-9 * seen.depth)) return false;
  const Vec2 second(q.x() / q.z(), q.y() / q.z());
  const Vec2 there = pixel_from_normalised(model, second);
  if (!(there.x() >= 0 && there.y() >= 0 && there.x() < model.width && there.y() < model.height)) return false;
  Eigen::Matrix<double, 2, 3> projection;
  projection << 1 / q.z(), 0, -second.x() / q.z(), 0, 1 / q.z(), -second.y() / q.z();
  const Vec2 along = projection * ray;
  if (!(along.squaredNorm() > 0)) return false;
  // The place q turns with the second camera, and moves against it.
  Eigen::Matrix<double, 3, 6> moved;
  moved.leftCols<3>() = -cross_matrix(q);
  moved.rightCols<3>() = -second_from_first.rotation;
  const Eigen::Matrix<double, 3, static_cast<int>(intrinsic_count)> place =
      moved.lazyProduct(step_by_lens) +
      seen.depth * second_from_first.rotation.leftCols<2>().lazyProduct(direction_by_intrinsics(model, first));
  const MatIntrinsics left = direction_by_intrinsics(model, second) - projection.lazyProduct(place);
  derivative = along.transpose().lazyProduct(left) / (along.squaredNorm() * seen.depth);
  return true;
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
  const Eigen::Matrix<double, 6, 12> by_cameras = step_by_cameras(previous, camera);
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
  strip.by_intrinsics.fill(0);
  strip.known = 1;
}

void drop_oldest_camera(StripCovariance& strip) {
  for (std::size_t r = 0; r < strip_size; ++r) {
    for (std::size_t c = 0; c < strip_size; ++c) {
      const bool kept = r + camera_size < strip_size && c + camera_size < strip_size;
      strip.matrix[strip_size * r + c] = kept ? strip.matrix[strip_size * (r + camera_size) + c + camera_size] : 0;
    }
  }
  std::copy(strip.by_intrinsics.begin() + camera_size * intrinsic_count, strip.by_intrinsics.end(),
            strip.by_intrinsics.begin());
  std::fill(strip.by_intrinsics.end() - camera_size * intrinsic_count, strip.by_intrinsics.end(), 0);
  strip.known >>= 1U;
}

IntrinsicsCovariance intrinsics_covariance(const std::array<double, intrinsic_count*(intrinsic_count + 1) / 2>& lower) {
  IntrinsicsCovariance whole;
  std::size_t k = 0;
  for (int row = 0; row < static_cast<int>(intrinsic_count); ++row) {
    for (int column = 0; column <= row; ++column, ++k) whole(row, column) = whole(column, row) = lower[k];
  }
  return whole;
}

void add_error_of_lens(const StripCovariance& strip, std::size_t index, const IntrinsicsCovariance& lens,
                       double (&pose)[21]) {
  if (((strip.known >> index) & 1U) == 0) return;
  add_transformed(derivative_of(strip, index), lens, pose);
}

double depth_error_of_lens(const StripCovariance& strip, const StripStep& step, const CameraModel& model,
                           const IntrinsicsCovariance& lens, double depth) {
  if (step.index == 0 || ((strip.known >> (step.index - 1)) & 3U) != 3U || !(lens.trace() > 0)) return 0;
  Eigen::Matrix<double, 12, static_cast<int>(intrinsic_count)> both;
  both << derivative_of(strip, step.index - 1), derivative_of(strip, step.index);
  const SixByIntrinsics by_lens = step_by_cameras(step.previous, step.camera).lazyProduct(both);
  const RigidTransform second_from_first = compose(step.camera, inverse(step.previous));
  constexpr int cells = 5;
  double sum = 0;
  int count = 0;
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells; ++column) {
      const Vec2 pixel(model.width * (column + 0.5) / cells - 0.5, model.height * (row + 0.5) / cells - 0.5);
      DepthByIntrinsics derivative;
      if (!depth_by_intrinsics(model, second_from_first, by_lens, {pixel, depth}, derivative)) continue;
      sum += derivative.dot(derivative * lens);
      ++count;
    }
  }
  return count > 0 && sum > 0 ? std::sqrt(sum / count) : 0;
}

void derive_by_intrinsics(const BundleProblem& problem, const BundleParams& params, const CameraModel& camera,
                          StripCovarianceWorkspace& workspace) {
  const BundleCovariance& window = workspace.window;
  workspace.by_intrinsics.fill(0);
  if (!window.valid || !(window.variance > 0)) return;
  std::array<bundle::Camera, limits::max_bundle_cameras> cameras;
  free_cameras(problem, window, cameras);
  const bundle::Loss loss{params.robust_px};
  double* sums = workspace.product.data();
  const std::size_t n = camera_size * window.free_count;
  std::fill_n(sums, n * intrinsic_count, 0.0);
  TrackEquations track;
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    const BundleObservation& o = problem.observations[i];
    const bundle::Camera& seen_by = cameras[o.camera];
    const double* point = problem.points[o.point].position;
    if (in_front(seen_by, point)) {
      const bundle::Linearised at = bundle::linearise(seen_by, {o.x, o.y, o.camera}, point, loss);
      const double weight = loss.weight(at.eu * at.eu + at.ev * at.ev);
      const MatIntrinsics by_intrinsics =
          std::sqrt(weight) * ideal_by_intrinsics(camera, normalised_from_ideal(camera, Vec2(o.x, o.y)));
      track.add(seen_by.free ? camera_size * seen_by.block : TrackEquations::none, at, by_intrinsics);
    }
    if (i + 1 < problem.observations.size() && problem.observations[i + 1].point == o.point) continue;
    track.scatter_into(sums);
    track.clear();
  }
  multiply(window.conditional.data(), sums, n, n, intrinsic_count, workspace.by_intrinsics.data());
  for (std::size_t k = 0; k < n * intrinsic_count; ++k) workspace.by_intrinsics[k] /= -window.variance;
}

void allow_correlated_tracks(const BundleProblem& problem, const BundleParams& params,
                             StripCovarianceWorkspace& workspace) {
  BundleCovariance& window = workspace.window;
  const std::size_t n = camera_size * window.free_count;
  const std::size_t tracks = problem.points.size();
  if (!window.valid || tracks <= n) return;
  std::array<bundle::Camera, limits::max_bundle_cameras> cameras;
  free_cameras(problem, window, cameras);
  double* scatter = workspace.scatter.data();
  const bundle::Loss loss{params.robust_px};
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
  multiply(derivative, strip.by_intrinsics.data(), n, strip_size, intrinsic_count, product);
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t c = 0; c < intrinsic_count; ++c) {
      strip.by_intrinsics[intrinsic_count * row[r] + c] =
          product[intrinsic_count * r + c] + workspace.by_intrinsics[intrinsic_count * r + c];
    }
  }
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
