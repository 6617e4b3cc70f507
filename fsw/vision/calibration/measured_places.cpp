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
/// Of a height, by which a focal length that is far off changes it.
constexpr double most_stretch_by_lens = 0.4;
/// Turns that the centres leave open, as those about a straight track, stay as they are.
constexpr double open_turn = 1e-9;

using Row7 = Eigen::Matrix<double, 1, 7>;

struct Track {
  std::size_t count = 0;
  std::array<Vec3, limits::max_calibration_views> centre, place, sigma;
  HeightsInWindow heights;
  [[nodiscard]] std::size_t rows() const { return PlaceEquations::centre_rows + heights.size(); }
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

/// The fit at the centres as they are: whitened rows by the similarity, their residuals and weights, and what they add
/// up to. Rows of views without a place, or without a height, are 0.
struct Fit {
  Eigen::Matrix<double, PlaceEquations::size, 7> by_similarity = decltype(by_similarity)::Zero();
  Eigen::Matrix<double, PlaceEquations::size, 1> residual = decltype(residual)::Zero();
  Eigen::Matrix<double, PlaceEquations::size, 1> root_weight = decltype(root_weight)::Zero();
  Eigen::Matrix<double, 7, 7> normal = decltype(normal)::Zero(), inverse = decltype(inverse)::Zero();
  SimilarityStep right = SimilarityStep::Zero();
  double furthest_m = 0;    ///< of a place, beyond the loss' bound
  double most_stretch = 0;  ///< of a height, as a share of it, beyond the loss' bound
};

void add_row(std::size_t at, double off, double sigma, double loss_sigmas, const Row7& change, Fit& fit) {
  const auto row = static_cast<Eigen::Index>(at);
  const double sigmas = off / (loss_sigmas * sigma);
  fit.root_weight[row] = 1 / (sigma * std::sqrt(1 + sigmas * sigmas));
  fit.residual[row] = off * fit.root_weight[row];
  fit.by_similarity.row(row) = fit.root_weight[row] * change;
  fit.normal += fit.by_similarity.row(row).transpose() * fit.by_similarity.row(row);
  fit.right += fit.by_similarity.row(row).transpose() * fit.residual[row];
}

void add_places(const Track& track, const Similarity& world, double loss_sigmas, Fit& fit) {
  for (std::size_t i = 0; i < track.count; ++i) {
    const Vec3 at = world * track.centre[i];
    const Eigen::Matrix<double, 3, 7> change = change_by_step(at);
    for (int axis = 0; axis < 3; ++axis) {
      const double off = at[axis] - track.place[i][axis], sigma = track.sigma[i][axis];
      add_row(3 * i + static_cast<std::size_t>(axis), off, sigma, loss_sigmas, change.row(axis), fit);
      fit.furthest_m = std::fmax(fit.furthest_m, std::fabs(off) - loss_sigmas * sigma);
    }
  }
}

/// The attitude says what is up: of the similarity the scale alone matters.
void add_heights(const Track& track, const Similarity& world, double loss_sigmas, Fit& fit) {
  for (std::size_t i = 0; i < track.heights.size(); ++i) {
    const HeightInWindow& height = track.heights[i];
    const double distance_m = world.scale * height.distance, of_ground = world.scale * height.sigma;
    const double sigma = std::sqrt(height.sigma_m * height.sigma_m + of_ground * of_ground);
    Row7 change = Row7::Zero();
    change[6] = distance_m;
    const double off = distance_m - height.height_m;
    add_row(PlaceEquations::centre_rows + i, off, sigma, loss_sigmas, change, fit);
    fit.most_stretch = std::fmax(fit.most_stretch, (std::fabs(off) - loss_sigmas * sigma) / height.height_m);
  }
}

bool linearise(const Track& track, const Similarity& world, double loss_sigmas, Fit& fit, SimilarityStep& step) {
  fit = {};
  add_places(track, world, loss_sigmas, fit);
  add_heights(track, world, loss_sigmas, fit);
  Eigen::Matrix<double, 7, 7>& normal = fit.normal;
  const double least = open_turn * open_turn * normal.trace();
  normal.diagonal() += open_turn * normal.diagonal();
  normal.diagonal().array() += least;
  const Eigen::LLT<Eigen::Matrix<double, 7, 7>> factor(normal);
  if (factor.info() != Eigen::Success) return false;
  step = -factor.solve(fit.right);
  fit.inverse = factor.solve(Eigen::Matrix<double, 7, 7>::Identity());
  return step.allFinite();
}

bool best_fit(const Track& track, const Similarity& first, double loss_sigmas, Similarity& world, Fit& fit,
              SimilarityStep& step) {
  world = first;
  for (int i = 0; i < fit_steps; ++i) {
    if (!linearise(track, world, loss_sigmas, fit, step)) return false;
    world = stepped(step, world);
  }
  return linearise(track, world, loss_sigmas, fit, step);
}

/// How a measurement's whitened residual changes with the view's own centre, or with the distance.
struct OwnChange {
  std::size_t first = 0, count = 1;
  std::array<double, 3> by{};

  OwnChange(const Similarity& world, const Fit& fit, std::size_t row) : first(row) {
    const double weight = fit.root_weight[static_cast<Eigen::Index>(row)];
    by[0] = weight * world.scale;
    if (row >= PlaceEquations::centre_rows) return;
    first = row - row % 3;
    count = 3;
    for (int i = 0; i < 3; ++i)
      by[static_cast<std::size_t>(i)] = weight * world.scale * world.rotation(static_cast<int>(row % 3), i);
  }
};

}  // namespace

bool place_equations(std::span<const RigidTransform> cam_from_world, const MeasuredPlaces& places,
                     const HeightsInWindow& heights, double loss_sigmas, PlaceEquations& out) {
  out = {};
  if (places.size() < least_places) return false;
  Track track;
  // Counted from the first place: a step turns about the origin, which shall be near.
  const Eigen::Map<const Vec3> begin(places[0].place_m);
  for (const MeasuredPlace& place : places) {
    track.centre[track.count] = camera_centre(cam_from_world[place.view]);
    track.place[track.count] = Eigen::Map<const Vec3>(place.place_m) - begin;
    track.sigma[track.count++] = Eigen::Map<const Vec3>(place.sigma_m);
  }
  Similarity first;
  double spread = 0;
  if (!first_fit(track, first, spread)) return false;
  track.heights = heights;
  Similarity world;
  Fit fit;
  SimilarityStep step;
  if (!best_fit(track, first, loss_sigmas, world, fit, step)) return false;
  if (!(fit.most_stretch < most_stretch_by_lens)) {
    track.heights.clear();
    if (!best_fit(track, first, loss_sigmas, world, fit, step)) return false;
  }
  if (!(fit.furthest_m < most_bend_by_lens * spread)) return false;
  const std::size_t rows = track.rows();
  // What is left in the direction of a similarity would pull at what the window leaves open.
  for (std::size_t row = 0; row < rows; ++row) {
    const auto r = static_cast<Eigen::Index>(row);
    fit.residual[r] += fit.by_similarity.row(r).dot(step);
  }
  for (std::size_t a = 0; a < rows; ++a) {
    const OwnChange own(world, fit, a);
    const Row7 solved = fit.by_similarity.row(static_cast<Eigen::Index>(a)) * fit.inverse;
    const double residual = fit.residual[static_cast<Eigen::Index>(a)];
    out.squared += residual * residual;
    for (std::size_t i = 0; i < own.count; ++i) out.gradient[own.first + i] += own.by[i] * residual;
    for (std::size_t b = 0; b < rows; ++b) {
      const OwnChange other(world, fit, b);
      const double left = (a == b ? 1 : 0) - solved.dot(fit.by_similarity.row(static_cast<Eigen::Index>(b)));
      for (std::size_t i = 0; i < own.count; ++i) {
        for (std::size_t k = 0; k < other.count; ++k) {
          out.information[own.first + i][other.first + k] += left * own.by[i] * other.by[k];
        }
      }
    }
  }
  return true;
}

}  // namespace ilp
