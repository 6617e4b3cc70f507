// The normal equations of a bundle adjustment, whose points are eliminated, with what they are made of.
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

/// A few megabytes.
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
  /// Upper blocks of the Schur complement, block (a, b) at a * max_bundle_cameras + b, the centres in their cameras'
  /// axes.
  std::array<Block, max_cameras * max_cameras> blocks;
  std::array<double, max_system> diagonal;  ///< of the cameras' normal equations before any point is eliminated
  std::array<double, max_system> reduced_gradient;
  std::array<double, max_system * max_system> system;
  std::array<double, max_system> camera_step;
  std::array<double, max_system> own_step;  ///< same, the centres in their cameras' axes
  std::array<std::array<double, 4>, max_cameras> trial_quaternions;

  [[nodiscard]] Loss loss() const { return {params.robust_px}; }
};

/// The camera in the form of the inner loops, as a fixed one.
[[nodiscard]] Camera camera_from(const BundleCamera& camera);

/// Of points with the same cameras.
void pair_points(Equations& eq);
[[nodiscard]] Cost evaluate(const Equations& eq);
/// False where a point is not determined.
bool linearise(Equations& eq, double damping);
/// The matrix of the cameras.
void assemble(Equations& eq, double damping);
[[nodiscard]] HeldDistance held_distance(const Equations& eq);
bool solve_cameras(Equations& eq, double damping, double& predicted_twice);
/// Into the trial; returns their cost with the trial's cameras.
Cost step_all_points(Equations& eq, double& predicted_twice);

void covariances(Equations& eq, BundleResult& result, BundleCovariance* joint);

}  // namespace ilp::bundle
