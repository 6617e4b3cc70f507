#include "fsw/vision/calibration/measured_places.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "fsw/vision/geometry/similarity.hpp"
#include "fsw/vision/twoview/solvers/symmetric_eigen.hpp"

namespace ilp {
namespace {

constexpr std::size_t least_places = 3;
constexpr int fit_steps = 8;
/// Of the places' spread, that a lens which is far off bends the centres.
constexpr double most_bend_by_lens = 0.2;
/// Turns that the centres leave open, as those about a straight track, stay as they are.
constexpr double open_turn = 1e-9;

using Row7 = Eigen::Matrix<double, 1, 7>;

Vec3 centre_of(const RigidTransform& cam_from_world) {
  return -(cam_from_world.rotation.transpose() * cam_from_world.translation);
}

struct Track {
  std::size_t count = 0;
  std::array<Vec3, limits::max_calibration_views> centre, place, sigma;
};

/// Rotation and scale between the two by B. K. P. Horn, "Closed-form solution of absolute orientation using unit
/// quaternions", 1987; no weights. `spread`: root mean square distance of the places from their mean, m.
bool first_fit(const Track& track, Similarity& out, double& spread) {
  const auto count = static_cast<double>(track.count);
  Vec3 centre = Vec3::Zero(), place = Vec3::Zero();
  for (std::size_t i = 0; i < track.count; ++i) {
    centre += track.centre[i] / count;
    place += track.place[i] / count;
  }
  Mat3 s = Mat3::Zero();
  double of_centres = 0, of_places = 0;
  for (std::size_t i = 0; i < track.count; ++i) {
    const Vec3 from = track.centre[i] - centre, to = track.place[i] - place;
    s += from * to.transpose();
    of_centres += from.squaredNorm();
    of_places += to.squaredNorm();
  }
  spread = std::sqrt(of_places / count);
  if (!(of_centres > 0) || !(of_places > 0)) return false;
  Eigen::Matrix4d n;
  n << s.trace(), s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0),   //
      0, s(0, 0) - s(1, 1) - s(2, 2), s(0, 1) + s(1, 0), s(2, 0) + s(0, 2),  //
      0, 0, -s(0, 0) + s(1, 1) - s(2, 2), s(1, 2) + s(2, 1),                 //
      0, 0, 0, -s(0, 0) - s(1, 1) + s(2, 2);
  for (int r = 1; r < 4; ++r) {
    for (int c = 0; c < r; ++c) n(r, c) = n(c, r);
  }
  SymmetricEigen<4> eigen;
  // Of centres in a line, two rotations are equally good, and the sweeps need not converge: either will do.
  static_cast<void>(symmetric_eigen<4>(n, eigen));
  const Eigen::Vector4d q = eigen.vectors.col(3);
  const double quaternion[4] = {q[0], q[1], q[2], q[3]};
  out.rotation = rotation_from_quaternion(quaternion);
  out.scale = std::sqrt(of_places / of_centres);
  out.translation = place - out.scale * (out.rotation * centre);
  return out.translation.allFinite();
}

/// The fit at the centres as they are: whitened rows by the similarity, their residuals and weights.
struct Fit {
  Eigen::Matrix<double, PlaceEquations::size, 7> by_similarity;
  Eigen::Matrix<double, PlaceEquations::size, 1> residual, root_weight;
  Eigen::Matrix<double, 7, 7> inverse;
  double furthest_m = 0;  ///< beyond the loss' bound
};

bool linearise(const Track& track, const Similarity& world, double loss_sigmas, Fit& fit, SimilarityStep& step) {
  Eigen::Matrix<double, 7, 7> normal = Eigen::Matrix<double, 7, 7>::Zero();
  SimilarityStep right = SimilarityStep::Zero();
  fit.furthest_m = 0;
  for (std::size_t i = 0; i < track.count; ++i) {
    const Vec3 at = world * track.centre[i];
    const Eigen::Matrix<double, 3, 7> change = change_by_step(at);
    for (int axis = 0; axis < 3; ++axis) {
      const auto row = static_cast<Eigen::Index>(3 * i) + axis;
      const double off = at[axis] - track.place[i][axis], sigma = track.sigma[i][axis];
      const double sigmas = off / (loss_sigmas * sigma);
      fit.root_weight[row] = 1 / (sigma * std::sqrt(1 + sigmas * sigmas));
      fit.residual[row] = off * fit.root_weight[row];
      fit.by_similarity.row(row) = fit.root_weight[row] * change.row(axis);
      fit.furthest_m = std::fmax(fit.furthest_m, std::fabs(off) - loss_sigmas * sigma);
      normal += fit.by_similarity.row(row).transpose() * fit.by_similarity.row(row);
      right += fit.by_similarity.row(row).transpose() * fit.residual[row];
    }
  }
  const double least = open_turn * open_turn * normal.trace();
  normal.diagonal() += open_turn * normal.diagonal();
  normal.diagonal().array() += least;
  const Eigen::LLT<Eigen::Matrix<double, 7, 7>> factor(normal);
  if (factor.info() != Eigen::Success) return false;
  step = -factor.solve(right);
  fit.inverse = factor.solve(Eigen::Matrix<double, 7, 7>::Identity());
  return step.allFinite();
}

}  // namespace

bool place_equations(std::span<const RigidTransform> cam_from_world, const MeasuredPlaces& places, double loss_sigmas,
                     PlaceEquations& out) {
  out = {};
  if (places.size() < least_places) return false;
  Track track;
  // Counted from the first place: a step turns about the origin, which shall be near.
  const Eigen::Map<const Vec3> begin(places[0].place_m);
  for (const MeasuredPlace& place : places) {
    track.centre[track.count] = centre_of(cam_from_world[place.view]);
    track.place[track.count] = Eigen::Map<const Vec3>(place.place_m) - begin;
    track.sigma[track.count++] = Eigen::Map<const Vec3>(place.sigma_m);
  }
  Similarity world;
  double spread = 0;
  if (!first_fit(track, world, spread)) return false;
  Fit fit;
  SimilarityStep step;
  for (int i = 0; i < fit_steps; ++i) {
    if (!linearise(track, world, loss_sigmas, fit, step)) return false;
    world = stepped(step, world);
  }
  if (!linearise(track, world, loss_sigmas, fit, step)) return false;
  if (!(fit.furthest_m < most_bend_by_lens * spread)) return false;
  const auto rows = static_cast<int>(3 * track.count);
  // What is left in the direction of a similarity would pull at what the window leaves open.
  for (int row = 0; row < rows; ++row) fit.residual[row] += fit.by_similarity.row(row).dot(step);
  Eigen::Matrix<double, PlaceEquations::size, 3> by_centre;  // of the row's own view
  for (int row = 0; row < rows; ++row) {
    by_centre.row(row) = fit.root_weight[row] * world.scale * world.rotation.row(row % 3);
  }
  for (int a = 0; a < rows; ++a) {
    const Row7 solved = fit.by_similarity.row(a) * fit.inverse;
    out.squared += fit.residual[a] * fit.residual[a];
    for (int i = 0; i < 3; ++i) out.gradient[a - a % 3 + i] += by_centre(a, i) * fit.residual[a];
    for (int b = 0; b < rows; ++b) {
      const double left = (a == b ? 1 : 0) - solved.dot(fit.by_similarity.row(b));
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
          out.information[a - a % 3 + i][b - b % 3 + k] += left * by_centre(a, i) * by_centre(b, k);
        }
      }
    }
  }
  return true;
}

}  // namespace ilp
