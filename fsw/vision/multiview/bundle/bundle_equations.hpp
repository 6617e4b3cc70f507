// The normal equations of a bundle adjustment with the points eliminated, and the data that they are made of.
#pragma once

#include "fsw/base/status.hpp"
#include "fsw/vision/multiview/bundle/bundle_covariance.hpp"
#include "fsw/vision/multiview/bundle/bundle_packet.hpp"
#include "fsw/vision/multiview/bundle/bundle_problem.hpp"

namespace ilp::bundle {

constexpr std::size_t max_cameras = limits::max_bundle_cameras;
constexpr std::size_t max_system = camera_size * max_cameras;
static_assert(max_cameras <= 32, "cameras of a point are bits");
using Cameras = std::array<Camera, max_cameras>;

/// Observations [first, last) of one point of the adjustment.
struct PointSpan {
  std::uint32_t first, last;
  std::uint32_t cameras;  ///< bit i: camera i sees the point
  std::uint16_t point;
};
/// Two points that the same cameras see, as indices of spans. a and b are equal for a point without a partner.
struct Packet {
  std::uint32_t a, b;
};
/// Factors of the elimination, kept for back substitution: V + damping = L L^T.
struct Eliminated {
  Lanes l[6];  ///< l10, l20, l21, then the inverses of the diagonal l00, l11, l22
  Lanes y[3];  ///< L^-1 gradient
  Lanes damping[3];
};
/// Normal equations of one camera, with its centre in the camera's own axes.
struct CameraNormal {
  Lanes gradient[6];  ///< gradient after the points are eliminated
  Lanes turn[3];      ///< diagonal of J^T J for the rotation
  Lanes shift[5];     ///< elements 00 02 11 12 22 of J^T J for the centre; 01 is zero
};
struct Cost {
  double robust = 0;
  double squared = 0;
  bool valid = true;  ///< every point is in front of its cameras, and all values are finite
};

/// Infinite damping along the line from origin to anchor, so that no step changes the held distance to first order.
struct HeldDistance {
  std::size_t block;  ///< index of the anchor among the free cameras
  double stiffness;
  double length;
  double direction[3];  ///< unit vector from the origin to the anchor
};

/// The state of an adjustment, a few megabytes.
struct Equations {
  BundleProblem* problem = nullptr;
  BundleParams params;
  std::size_t free_count = 0;
  std::size_t span_count = 0;
  std::size_t active_observations = 0;
  Cameras cameras;
  Cameras trial_cameras;
  std::array<std::uint16_t, max_cameras> camera_of_free;
  std::array<Observation, limits::max_bundle_observations> observations;
  std::array<std::uint32_t, limits::max_bundle_points + 1> offsets;
  std::array<PointSpan, limits::max_bundle_points> spans;
  std::array<Packet, limits::max_bundle_points> packets;
  std::size_t packet_count = 0;
  std::array<Eliminated, limits::max_bundle_points> eliminated;
  std::array<BundlePoint, limits::max_bundle_points> trial_points;
  std::array<CameraNormal, max_cameras> normals;
  /// Upper blocks of the Schur complement, with the centres in their cameras' axes. Block (a, b) is element a *
  /// max_bundle_cameras + b.
  std::array<Block, max_cameras * max_cameras> blocks;
  /// Diagonal of the cameras' normal equations before any point is eliminated.
  std::array<double, max_system> diagonal;
  std::array<double, max_system> reduced_gradient;
  std::array<double, max_system * max_system> system;
  std::array<double, max_system> camera_step;
  std::array<double, max_system> own_step;  ///< camera_step with the centres in their cameras' axes
  std::array<std::array<double, 4>, max_cameras> trial_quaternions;

  [[nodiscard]] Loss loss() const { return {params.robust_px}; }
};

/// Converts a camera to the form of the inner loops; it is marked as fixed.
[[nodiscard]] Camera camera_from(const BundleCamera& camera);

/// Pairs points that the same cameras see.
void pair_points(Equations& eq);
[[nodiscard]] Cost evaluate(const Equations& eq);
/// Linearises and eliminates the points. Returns false if a point is not determined.
bool linearise(Equations& eq, double damping);
/// Assembles the matrix of the cameras.
void assemble(Equations& eq, double damping);
[[nodiscard]] HeldDistance held_distance(const Equations& eq);
bool solve_cameras(Equations& eq, double damping, double& predicted_twice);
/// Steps the points into trial_points and returns the cost with the trial's cameras.
Cost step_all_points(Equations& eq, double& predicted_twice);

void covariances(Equations& eq, BundleResult& result, BundleCovariance* joint);

}  // namespace ilp::bundle
