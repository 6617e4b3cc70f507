// Bundle adjustment of one window: cameras with known intrinsics and points, Levenberg-Marquardt on the Schur
// complement (B. Triggs, P. McLauchlan, R. Hartley, A. Fitzgibbon, "Bundle Adjustment - A Modern Synthesis", 2000;
// damping by H. B. Nielsen, IMM-REP-1999-05).
//
// A free camera has six parameters: a rotation vector w, R <- exp([w]x) R, and its centre C; x_cam = R (X - C).
// Observations are ideal pixels (distortion removed), the residual is projection minus observation in px. Points are
// always free.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/multiview/bundle/bundle_covariance.hpp"
#include "fsw/vision/multiview/bundle/bundle_packet.hpp"

namespace ilp {

struct BundleCamera {
  Pose pose;
  double fx = 0, fy = 0;  ///< px
  double cx = 0, cy = 0;  ///< px
  bool fixed = false;     ///< takes part with its observations, never moves, and its pose is not written
};

struct BundlePoint {
  double position[3] = {0, 0, 0};  ///< world
};

struct BundleObservation {
  std::uint16_t camera = 0;
  std::uint16_t point = 0;
  double x = 0, y = 0;  ///< ideal px
};

/// Holds the distance of camera `anchor` (free) from camera `origin` (the only fixed one) when nothing else determines
/// the scale. Negative: no distance is held.
struct BundleScaleHold {
  std::int32_t origin = -1;
  std::int32_t anchor = -1;
};

/// A barometer or satellite navigation: direction . C = value. It constrains one camera only, so that points stay
/// independent of each other given the cameras. To use a height over ground, add the height of the ground.
struct BundleHeightPrior {
  std::uint16_t camera = 0;
  double direction[3] = {0, 0, 1};  ///< world, unit length
  double value = 0;                 ///< world units
  double sigma = 1;                 ///< same
};

/// An attitude sensor: the turn from the given to the adjusted attitude, as a rotation vector in the camera's axes,
/// should be zero. A sensor with a less accurate heading has a larger sigma about the axis that looks down.
struct BundleAttitudePrior {
  std::uint16_t camera = 0;
  double q_cam_from_world[4] = {1, 0, 0, 0};
  double sigma_rad[3] = {1, 1, 1};  ///< about the camera's axes
};

struct BundleProblem {
  FixedVector<BundleCamera, limits::max_bundle_cameras> cameras;
  FixedVector<BundlePoint, limits::max_bundle_points> points;
  FixedVector<BundleObservation, limits::max_bundle_observations> observations;  ///< in any order
  BundleScaleHold hold;
  /// Priors of free cameras. Those of fixed cameras only change the cost.
  FixedVector<BundleHeightPrior, limits::max_bundle_cameras> heights;
  FixedVector<BundleAttitudePrior, limits::max_bundle_cameras> attitudes;
};

enum class BundleLoss : std::uint8_t { huber, cauchy };

struct BundleParams {
  std::uint32_t max_iterations = 20;
  double relative_tolerance = 1e-6;  ///< of the cost: the adjustment ends when one step gains less
  double robust_px = 0;              ///< bound of the loss; 0 = plain least squares
  BundleLoss loss = BundleLoss::huber;
  double initial_damping =
      1e-4;  ///< times the diagonal of the normal equations; small, because windows start near the solution
  double observation_sigma_px = 0.5;  ///< weight of the observations relative to the sigmas of priors
};

/// The state of an adjustment between iterations, in addition to the problem itself. With it the adjustment can be
/// interrupted, stored and resumed with the same result to the last bit.
struct BundleProgress {
  double damping = 0;
  double damping_growth = 2;
  double initial_cost = 0;  ///< half the sum of squared residuals, px^2; the loss of them if robust; and priors'
  double cost = 0;          ///< same, now
  double initial_rms_px = 0;
  double held_distance = 0;
  std::uint32_t iterations = 0;  ///< accepted and rejected ones
  bool converged = false;
  bool done = false;
};

struct BundleResult {
  /// Half the sum of squared residuals (their loss if robust), and for every prior half of
  /// (observation_sigma_px * residual / sigma)^2; px^2.
  double initial_cost = 0, final_cost = 0;
  double initial_rms_px = 0, final_rms_px = 0;  ///< per residual coordinate, no robust weights
  std::uint32_t iterations = 0;
  bool converged = false;
  std::uint32_t points = 0, observations = 0;  ///< those that took part
  std::uint32_t dropped_observations = 0;      ///< behind their camera at the start, or alone on their point
  /// From the inverse of the reduced normal equations and the variance of the residuals (bundle_covariance.hpp),
  /// relative to the fixed cameras. Valid only if two cameras are fixed, or if one is fixed and a held distance or a
  /// height prior determines the scale.
  bool covariance_valid = false;
  struct PositionCovariance {
    double sigma[3] = {0, 0, 0};  ///< one sigma, world axes; 0 for fixed cameras
    double matrix[9] = {};
  };
  std::array<PositionCovariance, limits::max_bundle_cameras> cameras{};
};

namespace bundle {
/// The camera in the form of the inner loops; `free_index` -1 = fixed.
[[nodiscard]] Camera camera_from(const BundleCamera& camera, std::int32_t free_index);
}  // namespace bundle

/// The adjustment and its scratch of a few megabytes: keep it in static storage. Between `begin` or `resume` and
/// `finish` the problem belongs to the adjuster. After each `step` its poses and points are the best so far.
class BundleAdjuster {
 public:
  /// `invalid_argument` (camera, point, observation, parameters, scale hold, height prior, attitude prior, where there
  /// are several with the index) for non-finite values, indices out of range, or two observations of a point in one
  /// camera; `no_model` when no observation can be used.
  Status begin(BundleProblem& problem, const BundleParams& params);
  /// Continues from `progress`, which an earlier `begin` or `step` left together with this problem. The observations
  /// that `begin` dropped must have been removed.
  Status resume(BundleProblem& problem, const BundleParams& params, const BundleProgress& progress);
  /// Does one iteration: linearise, solve, try. Does nothing once done.
  Status step();
  [[nodiscard]] const BundleProgress& progress() const { return progress_; }
  /// Restores a held distance exactly and computes errors and covariances; the joint covariance only on request.
  Status finish(BundleResult& result, BundleCovariance* joint = nullptr);
  /// Runs begin, step until done, finish.
  Status run(BundleProblem& problem, const BundleParams& params, BundleResult& result,
             BundleCovariance* joint = nullptr);

  static constexpr std::size_t camera_size = bundle::camera_size;
  static constexpr std::size_t max_system = camera_size * limits::max_bundle_cameras;

 private:
  static_assert(limits::max_bundle_cameras <= 32, "cameras of a point are bits");
  using Camera = bundle::Camera;
  using Observation = bundle::Observation;
  using Lanes = bundle::Lanes;
  /// Observations [first, last) of one point that takes part.
  struct PointSpan {
    std::uint32_t first, last;
    std::uint32_t cameras;  ///< as bits
    std::uint16_t point;
  };
  /// Two points with the same cameras, as indices of spans. a and b are equal for a point without a partner.
  struct Packet {
    std::uint32_t a, b;
  };
  /// The factors of elimination for back substitution: V + damping = L L^T.
  struct Eliminated {
    Lanes l[6];  ///< l10, l20, l21, then the inverses of the diagonal l00, l11, l22
    Lanes y[3];  ///< L^-1 gradient
    Lanes damping[3];
  };
  template <typename V>
  struct Factors;
  /// Normal equations of one camera, its centre in its own axes.
  struct CameraNormal {
    Lanes gradient[6];  ///< reduced
    Lanes turn[3];      ///< diagonal of J^T J
    Lanes shift[5];     ///< 00 02 11 12 22 of J^T J; 01 is zero
  };
  struct Cost {
    double robust = 0;
    double squared = 0;
    bool valid = true;  ///< every point in front of its cameras, all finite
  };

  /// An infinite damping along the line from origin to anchor: no step changes the held distance to first order.
  struct HeldDistance {
    std::size_t block;  ///< of the anchor
    double stiffness;
    double length;
    double direction[3];  ///< unit, from the origin
  };

  Status load(BundleProblem& problem, const BundleParams& params);
  Status sort_observations();
  void choose_active();
  [[nodiscard]] bundle::Loss loss() const { return {params_.robust_px, params_.loss == BundleLoss::cauchy}; }
  [[nodiscard]] Cost evaluate() const;
  [[nodiscard]] Status check_priors(const BundleProblem& problem) const;
  [[nodiscard]] double prior_cost(const std::array<Camera, limits::max_bundle_cameras>& cameras) const;
  void add_priors();
  void multiply_priors(const double* x, double* y) const;
  void pair_points();
  template <typename Work>
  void for_each_packet(const Work& work) const;
  // Of packet p, or with wider lanes of it and the next one.
  [[nodiscard]] const PointSpan& span_of(std::size_t p, std::size_t lane) const;
  template <typename V>
  void load_points(std::size_t p, const BundlePoint* points, V (&out)[3]) const;
  template <typename V>
  void load_observation(std::size_t p, std::uint32_t k, V& x, V& y) const;
  template <typename V>
  void accumulate_cost(std::size_t p, const std::array<Camera, limits::max_bundle_cameras>& cameras,
                       const V (&point)[3], Cost& cost) const;
  bool linearise(double damping);
  template <typename V>
  bool eliminate(std::size_t p, double damping);
  template <typename V>
  static void add_camera(bundle::View<V>& at, const Factors<V>& point, CameraNormal& normal, bundle::Block& block);
  void finish_normal(std::size_t a);
  void world_block(std::size_t a, std::size_t b, double out[36]) const;
  template <typename V>
  void step_points(std::size_t p, V (&from)[3], double& predicted_twice);
  /// Into the trial; returns their cost with the trial's cameras.
  Cost step_all_points(double& predicted_twice);
  void assemble(double damping);
  [[nodiscard]] HeldDistance held_distance() const;
  bool solve_cameras(double& predicted_twice);
  Cost try_step(double& predicted_twice);
  void accept(double cost);
  void hold_scale();
  [[nodiscard]] double covariance_factor() const;
  void covariances(BundleResult& result, BundleCovariance* joint);
  [[nodiscard]] bool frame_is_fixed() const;
  void covariance_column(double factor, std::size_t column);
  void position_covariances(double factor, BundleResult& result);
  void joint_covariance(double factor, BundleCovariance& joint);
  void free_fixed_blocks(BundleCovariance& joint);
  void add_held_distance(BundleCovariance& joint);

  BundleProblem* problem_ = nullptr;
  BundleParams params_;
  BundleProgress progress_;
  std::size_t free_count_ = 0;
  std::size_t span_count_ = 0;
  std::size_t active_observations_ = 0;
  std::array<Camera, limits::max_bundle_cameras> cameras_;
  std::array<Camera, limits::max_bundle_cameras> trial_cameras_;
  std::array<std::uint16_t, limits::max_bundle_cameras> camera_of_free_;
  std::array<Observation, limits::max_bundle_observations> observations_;
  std::array<std::uint32_t, limits::max_bundle_points + 1> offsets_;
  std::array<PointSpan, limits::max_bundle_points> spans_;
  std::array<Packet, limits::max_bundle_points> packets_;
  std::size_t packet_count_ = 0;
  std::array<Eliminated, limits::max_bundle_points> eliminated_;
  std::array<BundlePoint, limits::max_bundle_points> trial_points_;
  std::array<CameraNormal, limits::max_bundle_cameras> normals_;
  /// Upper blocks of the Schur complement, block (a, b) at a * max_bundle_cameras + b, the centres in their cameras'
  /// axes.
  std::array<bundle::Block, limits::max_bundle_cameras * limits::max_bundle_cameras> blocks_;
  std::array<double, max_system> diagonal_;  ///< of the cameras' normal equations before any point is eliminated
  std::array<double, max_system> reduced_gradient_;
  std::array<double, max_system * max_system> system_;
  std::array<double, max_system> camera_step_;
  std::array<double, max_system> own_step_;  ///< same, the centres in their cameras' axes
  std::array<double, max_system> column_;
  std::array<double, 36 * limits::max_bundle_cameras> prior_blocks_;  ///< information of priors, 6x6 row-major
  std::array<std::array<double, 4>, limits::max_bundle_cameras> trial_quaternions_;
};

}  // namespace ilp
