#include "fsw/vision/calibration/intrinsics_equations.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/multiview/bundle/dense_cholesky.hpp"

namespace ilp {
namespace {

using Mat2x3 = Eigen::Matrix<double, 2, 3>;
using Mat2x6 = Eigen::Matrix<double, 2, 6>;
using Mat2xU = Eigen::Matrix<double, 2, static_cast<int>(camera_unknowns)>;
using Mat6x3 = Eigen::Matrix<double, 6, 3>;
using MatUx3 = Eigen::Matrix<double, static_cast<int>(camera_unknowns), 3>;

constexpr std::size_t poses = IntrinsicsWorkspace::poses;
constexpr std::size_t camera_at = poses + IntrinsicsWorkspace::rates;
constexpr std::size_t system_size = IntrinsicsWorkspace::size;
constexpr double loss_sigmas = 5;     ///< bound of the Cauchy weights, in sigmas of a coordinate
constexpr double least_weight = 0.2;  ///< a point with one below it, at twice the bound, is a wrong match
constexpr double least_sigma_px = 0.01;
constexpr double most_turn_by_lens_rad = 0.2;  ///< between views of a window, of a lens that is far off
constexpr double pose_ridge = 1e-9;            ///< of the diagonal: the scale of a window is free
constexpr double camera_ridge = 1e-6;          ///< of the information of a usual error
constexpr double near_vertical = 0.25;         ///< tangent from the vertical, of points that show the ground below
constexpr double least_ground_points = 8;

/// One observation with its derivatives.
struct Seen {
  std::size_t view = 0;
  Vec3 at;     ///< the point, in the view's axes
  Vec2 pixel;  ///< of the real image
  Vec2 residual;
  double weight = 1;
  Mat2x3 by_point;
  Mat2x6 by_pose;  ///< rotation vector from the left, translation
  Mat2xU by_camera;
  double by_rate = 0;  ///< of each coordinate, by the error of the view's motion along it, px per px/s
};

/// One point with its observations, in the order of the views.
struct SeenPoint {
  std::size_t count = 0;
  std::array<Seen, limits::max_calibration_views> seen;
};

struct Window {
  const CameraModel& camera;
  BundleProblem& problem;
  CameraUnknowns units;
  std::array<RigidTransform, limits::max_calibration_views> cam_from_world;
  double loss2 = 0;  ///< square of the bound of the Cauchy weights, px^2; 0: no weights
  const WindowMotion* motion = nullptr;
  const MeasuredHeights* heights = nullptr;
  double left_px = 0;  ///< noise of a coordinate that the step before has left; 0: there was none
};

/// How far a pixel's place at the middle row's time goes back for each second of readout time.
Vec2 shift_by_readout(const Window& window, std::size_t view, const Vec2& at, const DistortionJacobian& j, double row) {
  const Vec2 rate = rate_at(window.motion->of_view[view], at);
  const CameraModel& c = window.camera;
  return row_share(c, row) * Vec2(c.fx * (j.a * rate.x() + j.b * rate.y()), c.fy * (j.c * rate.x() + j.d * rate.y()));
}

/// Residual and derivatives; false for a point that is not in front of the camera.
bool linearise(const Window& window, const BundleObservation& o, Seen& out) {
  const CameraModel& c = window.camera;
  const RigidTransform& pose = window.cam_from_world[o.camera];
  const double* point = window.problem.points[o.point].position;
  const Vec3 at = pose * Vec3(point[0], point[1], point[2]);
  if (!(at.z() > 1e-9)) return false;
  const double inverse_z = 1 / at.z();
  const double x = at.x() * inverse_z, y = at.y() * inverse_z;
  const Vec2 distorted = distort(c, Vec2(x, y));
  const DistortionJacobian j = distortion_jacobian(c, x, y);
  out.view = o.camera;
  out.at = at;
  out.pixel = pixel_from_ideal(c, Vec2(o.x, o.y));
  out.residual = Vec2(c.fx * distorted.x() + c.cx, c.fy * distorted.y() + c.cy) - out.pixel;
  Mat2x3 by_position;
  by_position << c.fx * j.a, c.fx * j.b, -c.fx * (j.a * x + j.b * y),  //
      c.fy * j.c, c.fy * j.d, -c.fy * (j.c * x + j.d * y);
  by_position *= inverse_z;
  out.by_point = by_position * pose.rotation;
  out.by_pose.leftCols<3>() = -by_position * cross_matrix(at);
  out.by_pose.rightCols<3>() = by_position;
  out.by_camera.leftCols<static_cast<int>(intrinsic_count)>() = pixel_by_intrinsics(c, Vec2(x, y));
  out.by_camera.rightCols<1>().setZero();
  out.by_rate = 0;
  if (window.motion != nullptr) {
    const Vec2 shift = shift_by_readout(window, o.camera, Vec2(x, y), j, out.pixel.y());
    out.residual += (c.readout_s - window.motion->readout_s) * shift;
    if (window.motion->readout_open) out.by_camera.rightCols<1>() = shift;
    const bool exact = !(window.motion->sigma_px_s[o.camera] > 0);
    out.by_rate = exact ? 0 : row_time_s(c, out.pixel.y());
  }
  for (std::size_t i = 0; i < camera_unknowns; ++i) out.by_camera.col(static_cast<int>(i)) *= window.units[i];
  if (!out.residual.allFinite()) return false;
  out.weight = window.loss2 > 0 ? 1 / (1 + out.residual.squaredNorm() / window.loss2) : 1;
  return true;
}

/// The observations of the point of `first`; `first` moves to those of the next one.
void collect(const Window& window, std::size_t& first, SeenPoint& out) {
  const auto& observations = window.problem.observations;
  const std::size_t point = observations[first].point;
  out.count = 0;
  // bound: the observations of the window
  for (; first < observations.size() && observations[first].point == point; ++first) {
    if (out.count == out.seen.size() || !linearise(window, observations[first], out.seen[out.count])) continue;
    ++out.count;
  }
  std::sort(out.seen.begin(), out.seen.begin() + static_cast<std::ptrdiff_t>(out.count),
            [](const Seen& a, const Seen& b) { return a.view < b.view; });
}

/// The point, eliminated: (its block)^-1 and gradient.
struct Eliminated {
  Mat3 inverse;
  Vec3 gradient;
};

bool eliminate(const SeenPoint& point, Eliminated& out) {
  if (point.count < 2) return false;
  Mat3 block = Mat3::Zero();
  out.gradient.setZero();
  for (std::size_t i = 0; i < point.count; ++i) {
    const Seen& s = point.seen[i];
    if (s.weight < least_weight || (i > 0 && s.view == point.seen[i - 1].view)) return false;
    block += s.weight * s.by_point.transpose() * s.by_point;
    out.gradient += s.weight * s.by_point.transpose() * s.residual;
  }
  block.diagonal().array() += 1e-12 * block.trace() + 1e-300;
  const Eigen::LLT<Mat3> factor(block);
  if (factor.info() != Eigen::Success) return false;
  out.inverse = factor.solve(Mat3::Identity());
  return out.inverse.allFinite();
}

/// The lower triangle of the system, the camera last.
struct System {
  IntrinsicsWorkspace& w;

  template <typename Block>
  void add(std::size_t row, std::size_t column, const Block& block) {
    for (int r = 0; r < block.rows(); ++r) {
      double* out = w.system.data() + (row + static_cast<std::size_t>(r)) * system_size + column;
      for (int c = 0; c < block.cols(); ++c) out[c] += block(r, c);
    }
  }
  template <typename Column>
  void add_right(std::size_t row, const Column& column) {
    for (int r = 0; r < column.rows(); ++r) w.right[row + static_cast<std::size_t>(r)] += column(r);
  }
};

std::size_t row_of(const Seen& seen) {
  return 6 * (seen.view - 1);  // the first view does not move
}
std::size_t rate_of(const Seen& seen) {
  return poses + 2 * seen.view;
}

/// What the errors of the views' motion share with the rest.
void add_rates(const SeenPoint& point, const Eliminated& own,
               const std::array<Mat6x3, limits::max_calibration_views>& with_pose, const MatUx3& with_camera,
               System& system) {
  for (std::size_t i = 0; i < point.count; ++i) {
    const Seen& s = point.seen[i];
    const std::size_t row = rate_of(s);
    const double weight = s.weight * s.by_rate;
    const Mat2x3 with_rate = weight * s.by_point, of_rate = with_rate * own.inverse;
    system.add(row, row, (weight * s.by_rate * Eigen::Matrix2d::Identity()).eval());
    system.add_right(row, (weight * s.residual - of_rate * own.gradient).eval());
    if (s.view != 0) system.add(row, row_of(s), (weight * s.by_pose).eval());
    system.add(camera_at, row, (weight * s.by_camera.transpose() - with_camera * of_rate.transpose()).eval());
    for (std::size_t k = 0; k < point.count; ++k) {
      const Seen& other = point.seen[k];
      if (other.view != 0) system.add(row, row_of(other), (-of_rate * with_pose[k].transpose()).eval());
      if (k > i) continue;
      const Mat2x3 rate_of_other = other.weight * other.by_rate * other.by_point;
      system.add(row, rate_of(other), (-of_rate * rate_of_other.transpose()).eval());
    }
  }
}

/// What the point says of the ground below the views that measured a height. It answers to poses and camera as it is
/// eliminated.
void add_ground(const Window& window, const SeenPoint& point, const Eliminated& own,
                const std::array<Mat6x3, limits::max_calibration_views>& with_pose, const MatUx3& with_camera,
                IntrinsicsWorkspace& w) {
  const auto segment = [](std::array<double, system_size>& row, std::size_t first, const auto& values) {
    for (int i = 0; i < values.size(); ++i) row[first + static_cast<std::size_t>(i)] += values(i);
  };
  for (std::size_t h = 0; h < window.heights->size(); ++h) {
    const MeasuredHeight& height = (*window.heights)[h];
    for (std::size_t i = 0; i < point.count; ++i) {
      const Seen& s = point.seen[i];
      if (s.view != height.view) continue;
      const Eigen::Map<const Vec3> up(height.up);
      const double distance = -up.dot(s.at);
      const double off2 = s.at.squaredNorm() - distance * distance;
      if (!(distance > 0) || off2 > near_vertical * near_vertical * distance * distance) continue;
      const Vec3 response = -(own.inverse * (window.cam_from_world[s.view].rotation.transpose() * up));
      const double settled = distance - response.dot(own.gradient);
      GroundSums& ground = w.ground[h];
      ground.points += 1;
      ground.distance += settled;
      ground.squared += settled * settled;
      std::array<double, system_size>& row = w.by_unknowns[h];
      if (s.view != 0) {
        segment(row, row_of(s), (-s.at.cross(up)).eval());
        segment(row, row_of(s) + 3, (-up).eval());
      }
      segment(row, camera_at, (-(with_camera * response)).eval());
      for (std::size_t k = 0; k < point.count; ++k) {
        const Seen& other = point.seen[k];
        if (other.view != 0) segment(row, row_of(other), (-(with_pose[k] * response)).eval());
        segment(row, rate_of(other), (-(other.weight * other.by_rate * (other.by_point * response))).eval());
      }
    }
  }
}

void add_point(const Window& window, const SeenPoint& point, const Eliminated& own, System& system) {
  std::array<Mat6x3, limits::max_calibration_views> with_pose;
  MatUx3 with_camera = MatUx3::Zero();
  for (std::size_t i = 0; i < point.count; ++i) {
    const Seen& s = point.seen[i];
    const Mat2x3 weighted = s.weight * s.by_point;
    with_camera += s.by_camera.transpose() * weighted;
    system.add(camera_at, camera_at, (s.weight * s.by_camera.transpose().lazyProduct(s.by_camera)).eval());
    system.add_right(camera_at, (s.weight * s.by_camera.transpose() * s.residual).eval());
    if (s.view == 0) continue;
    with_pose[i] = s.by_pose.transpose() * weighted;
    system.add(row_of(s), row_of(s), (s.weight * s.by_pose.transpose() * s.by_pose).eval());
    system.add(camera_at, row_of(s), (s.weight * s.by_camera.transpose() * s.by_pose).eval());
    system.add_right(row_of(s), (s.weight * s.by_pose.transpose() * s.residual).eval());
  }
  const MatUx3 of_camera = with_camera * own.inverse;
  system.add(camera_at, camera_at, (-of_camera.lazyProduct(with_camera.transpose())).eval());
  system.add_right(camera_at, (-of_camera * own.gradient).eval());
  for (std::size_t i = 0; i < point.count; ++i) {
    if (point.seen[i].view == 0) continue;
    const Mat6x3 of_pose = with_pose[i] * own.inverse;
    system.add_right(row_of(point.seen[i]), (-of_pose * own.gradient).eval());
    system.add(camera_at, row_of(point.seen[i]), (-of_camera * with_pose[i].transpose()).eval());
    for (std::size_t k = 0; k <= i; ++k) {
      if (point.seen[k].view == 0) continue;
      system.add(row_of(point.seen[i]), row_of(point.seen[k]), (-of_pose * with_pose[k].transpose()).eval());
    }
  }
  if (window.motion != nullptr) add_rates(point, own, with_pose, with_camera, system);
  if (window.heights != nullptr) add_ground(window, point, own, with_pose, with_camera, system.w);
}

Status check(const BundleProblem& window, const MeasuredPlaces* places, const MeasuredHeights* heights) {
  if (window.cameras.size() > limits::max_calibration_views) {
    return out_of_range(Argument::window, window.cameras.size());
  }
  for (std::size_t i = 0; i < window.observations.size(); ++i) {
    const BundleObservation& o = window.observations[i];
    if (o.camera >= window.cameras.size() || o.point >= window.points.size() || !std::isfinite(o.x) ||
        !std::isfinite(o.y)) {
      return out_of_range(Argument::observation, i);
    }
  }
  for (const BundleAttitudePrior& prior : window.attitudes) {
    if (prior.camera >= window.cameras.size()) return out_of_range(Argument::window, prior.camera);
  }
  for (std::size_t i = 0; places != nullptr && i < places->size(); ++i) {
    if ((*places)[i].view >= window.cameras.size()) return out_of_range(Argument::window, (*places)[i].view);
  }
  for (std::size_t i = 0; heights != nullptr && i < heights->size(); ++i) {
    if ((*heights)[i].view >= window.cameras.size()) return out_of_range(Argument::window, (*heights)[i].view);
  }
  return {};
}

/// Standard deviation of a coordinate, by the median of a sample of squared residuals.
double scatter(const Window& window, std::array<double, IntrinsicsWorkspace::samples>& squared) {
  const auto& observations = window.problem.observations;
  const std::size_t stride = (observations.size() + squared.size() - 1) / squared.size();
  std::size_t count = 0;
  for (std::size_t i = 0; i < observations.size(); i += stride) {
    Seen seen;
    if (linearise(window, observations[i], seen)) squared[count++] = seen.residual.squaredNorm();
  }
  if (count == 0) return least_sigma_px;
  std::nth_element(squared.begin(), squared.begin() + static_cast<std::ptrdiff_t>(count / 2),
                   squared.begin() + static_cast<std::ptrdiff_t>(count));
  constexpr double median_of_squares = 1.386;  // of a residual with two coordinates, in variances of one
  return std::fmax(std::sqrt(squared[count / 2] / median_of_squares), least_sigma_px);
}

/// The residuals of a point after the steps of poses and camera, and its own step.
struct Stepped {
  std::array<Vec2, limits::max_calibration_views> left;
  Vec3 moved;
};

Stepped after_step(const SeenPoint& point, const Eliminated& own, const IntrinsicsWorkspace& w) {
  using Step6 = Eigen::Map<const Eigen::Matrix<double, 6, 1>>;
  const Eigen::Map<const Eigen::Matrix<double, static_cast<int>(camera_unknowns), 1>> lens(w.right.data() + camera_at);
  Stepped out;
  Vec3 right = Vec3::Zero();
  for (std::size_t i = 0; i < point.count; ++i) {
    const Seen& s = point.seen[i];
    out.left[i] = s.residual + s.by_camera * lens;
    if (s.view != 0) out.left[i] += s.by_pose * Step6(w.right.data() + row_of(s));
    out.left[i] += s.by_rate * Eigen::Map<const Vec2>(w.right.data() + rate_of(s));
    right += s.weight * s.by_point.transpose() * out.left[i];
  }
  out.moved = -(own.inverse * right);
  for (std::size_t i = 0; i < point.count; ++i) out.left[i] += point.seen[i].by_point * out.moved;
  return out;
}

void add_to_field(const CameraModel& camera, const SeenPoint& point, const Stepped& stepped, ResidualField& field) {
  const auto part = [](double at, std::int32_t side, std::size_t parts) {
    const double place = at / side * static_cast<double>(parts);
    return place < 0 ? 0 : std::min(parts - 1, static_cast<std::size_t>(place));
  };
  for (std::size_t i = 0; i < point.count; ++i) {
    const Seen& s = point.seen[i];
    const std::size_t column = part(s.pixel.x(), camera.width, ResidualField::columns);
    const std::size_t row = part(s.pixel.y(), camera.height, ResidualField::rows);
    ResidualField::Cell& cell = field.cells[row * ResidualField::columns + column];
    cell.weight += s.weight;
    cell.x += s.weight * stepped.left[i].x();
    cell.y += s.weight * stepped.left[i].y();
    field.weight += s.weight;
    field.squared += s.weight * stepped.left[i].squaredNorm();
  }
}

/// What the points of a window add up to.
struct WindowSums {
  std::uint32_t points = 0, observations = 0;
  double weight = 0, squared = 0;
  double explained = 0;  ///< of `squared`, by points and poses
  double variance = 0;   ///< of a coordinate, by the median
};

/// A view's turn from the first one, which does not move, less what the sensor measured of it.
struct MeasuredTurn {
  std::size_t view = 0;
  double contradiction[3] = {};  ///< rad, in the view's axes
  double variance[3] = {};
};
using MeasuredTurns = FixedVector<MeasuredTurn, limits::max_calibration_views>;

/// Empty where one of them is further from the images than a lens can explain.
void measured_turns(const Window& window, MeasuredTurns& turns) {
  const BundleAttitudePrior* first = nullptr;
  for (const BundleAttitudePrior& prior : window.problem.attitudes) {
    if (prior.camera == 0) first = &prior;
  }
  if (first == nullptr) return;
  const Mat3 level_from_first = rotation_from_quaternion(first->q_cam_from_world).transpose();
  const Mat3 world_from_first = window.cam_from_world[0].rotation.transpose();
  const Eigen::Map<const Vec3> sigma_of_first(first->sigma_rad);
  for (const BundleAttitudePrior& prior : window.problem.attitudes) {
    if (prior.camera == 0) continue;
    const Mat3 measured = rotation_from_quaternion(prior.q_cam_from_world) * level_from_first;
    const Mat3 adjusted = window.cam_from_world[prior.camera].rotation * world_from_first;
    const Vec3 contradiction = vector_from_rotation(adjusted * measured.transpose());
    const Vec3 variance = Eigen::Map<const Vec3>(prior.sigma_rad).cwiseAbs2() +
                          (measured * sigma_of_first.asDiagonal()).rowwise().squaredNorm();
    if (!((contradiction.cwiseAbs() - loss_sigmas * variance.cwiseSqrt()).maxCoeff() < most_turn_by_lens_rad)) {
      turns.clear();
      return;
    }
    static_cast<void>(turns.push_back({prior.camera,
                                       {contradiction[0], contradiction[1], contradiction[2]},
                                       {variance[0], variance[1], variance[2]}}));
  }
}

void add_attitudes(const Window& window, double unit2, System& system, WindowSums& sums) {
  MeasuredTurns turns;
  measured_turns(window, turns);
  for (const MeasuredTurn& turn : turns) {
    for (int axis = 0; axis < 3; ++axis) {
      const double squared = turn.contradiction[axis] * turn.contradiction[axis];
      const double weight =
          unit2 / turn.variance[axis] / (1 + squared / (loss_sigmas * loss_sigmas * turn.variance[axis]));
      const std::size_t place = 6 * (turn.view - 1) + static_cast<std::size_t>(axis);
      system.w.system[place * system_size + place] += weight;
      system.w.right[place] += weight * turn.contradiction[axis];
      sums.squared += weight * squared;
    }
  }
}

/// A height whose ground the window sees: its row of the equations, and how the distance changes with the unknowns.
struct SeenHeight {
  std::size_t row = 0;
  std::array<double, system_size> by_unknowns{};
};
using SeenHeights = FixedVector<SeenHeight, limits::max_calibration_views>;

HeightsInWindow heights_in_window(const Window& window, const IntrinsicsWorkspace& w, SeenHeights& seen) {
  HeightsInWindow out;
  for (std::size_t h = 0; window.heights != nullptr && h < window.heights->size(); ++h) {
    const GroundSums& ground = w.ground[h];
    if (ground.points < least_ground_points) continue;
    const double mean = ground.distance / ground.points;
    const double scatter2 = std::fmax(ground.squared / ground.points - mean * mean, 0);
    SeenHeight of{PlaceEquations::centre_rows + out.size(), w.by_unknowns[h]};
    for (double& value : of.by_unknowns) value /= ground.points;
    static_cast<void>(seen.push_back(of));
    const MeasuredHeight& measured = (*window.heights)[h];
    static_cast<void>(out.push_back({mean, std::sqrt(scatter2), measured.height_m, measured.sigma_m}));
  }
  return out;
}

void add_heights(const Window& window, const MeasuredPlaces& places, const SeenHeights& heights,
                 const PlaceEquations& of, double unit2, System& system) {
  const auto at = [&system](std::size_t row, std::size_t column) -> double& {
    return system.w.system[row * system_size + column];
  };
  for (const SeenHeight& height : heights) {
    const auto& by = height.by_unknowns;
    for (std::size_t r = 0; r < system_size; ++r) {
      system.w.right[r] += unit2 * of.gradient[height.row] * by[r];
      for (const SeenHeight& other : heights) {
        const double shared = unit2 * of.information[height.row][other.row];
        for (std::size_t c = 0; c <= r; ++c) at(r, c) += shared * by[r] * other.by_unknowns[c];
      }
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (places[i].view == 0) continue;
      Vec3 with_centre;
      for (std::size_t k = 0; k < 3; ++k) with_centre[static_cast<int>(k)] = of.information[3 * i + k][height.row];
      const Vec3 shared = -unit2 * (window.cam_from_world[places[i].view].rotation * with_centre);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t p = 6 * (places[i].view - 1U) + 3 + k;
        for (std::size_t c = 0; c < system_size; ++c) {
          at(std::max(p, c), std::min(p, c)) += (p == c ? 2 : 1) * shared[static_cast<int>(k)] * by[c];
        }
      }
    }
  }
}

void add_places(const Window& window, const MeasuredPlaces& places, double unit2, System& system, WindowSums& sums) {
  PlaceEquations of;
  SeenHeights heights;
  const HeightsInWindow distances = heights_in_window(window, system.w, heights);
  if (!place_equations(window.cam_from_world, places, distances, loss_sigmas, of)) return;
  add_heights(window, places, heights, of, unit2, system);
  sums.squared += unit2 * of.squared;
  using Block = Eigen::Map<const Mat3, 0, Eigen::Stride<1, static_cast<int>(PlaceEquations::size)>>;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].view == 0) continue;
    // A translation v of the view moves its centre by -R^T v.
    const Mat3& turn = window.cam_from_world[places[i].view].rotation;
    const std::size_t row = 6 * (places[i].view - 1U) + 3;
    system.add_right(row, (-unit2 * (turn * Eigen::Map<const Vec3>(of.gradient + 3 * i))).eval());
    for (std::size_t k = 0; k < places.size(); ++k) {
      if (places[k].view == 0 || places[k].view > places[i].view) continue;
      const Mat3& other = window.cam_from_world[places[k].view].rotation;
      const Block block(&of.information[3 * i][3 * k]);
      system.add(row, 6 * (places[k].view - 1U) + 3, (unit2 * (turn * block * other.transpose())).eval());
    }
  }
}

/// Sums the system up, factors it and solves L y = right. False where there is nothing to solve.
bool assemble(Window& window, IntrinsicsWorkspace& w, const ReductionParams& params, WindowSums& sums) {
  sums = {};
  window.loss2 = 0;
  const double sigma = scatter(window, w.squared);
  window.loss2 = loss_sigmas * loss_sigmas * sigma * sigma;
  sums.variance = sigma * sigma;
  System system{w};
  w.system.fill(0);
  w.right.fill(0);
  w.ground = {};
  w.by_unknowns = {};
  SeenPoint point;
  Eliminated own;
  for (std::size_t i = 0; i < window.problem.observations.size();) {  // collect moves on
    collect(window, i, point);
    if (!eliminate(point, own)) continue;
    ++sums.points;
    sums.observations += static_cast<std::uint32_t>(point.count);
    for (std::size_t k = 0; k < point.count; ++k) {
      sums.weight += point.seen[k].weight;
      sums.squared += point.seen[k].weight * point.seen[k].residual.squaredNorm();
    }
    sums.explained += own.gradient.dot(own.inverse * own.gradient);
    add_point(window, point, own, system);
  }
  if (sums.points == 0) return false;
  const double unit = std::fmax(params.error_factor * sigma, least_sigma_px);
  add_attitudes(window, unit * unit, system, sums);
  // Residuals have the errors of the motion in them until they are explained.
  const double left = std::fmax(params.error_factor * (window.left_px > 0 ? window.left_px : sigma), least_sigma_px);
  if (params.places != nullptr) add_places(window, *params.places, unit * unit, system, sums);
  const std::size_t moving = 6 * (window.problem.cameras.size() - 1);
  for (std::size_t i = 0; i < system_size; ++i) {
    double& diagonal = w.system[i * system_size + i];
    if (i < moving) diagonal += pose_ridge * diagonal;
    if (i >= moving && i < poses) diagonal = 1;  // of views that the window lacks
    if (i >= poses && i < camera_at) {
      const double of_motion = window.motion == nullptr ? 0 : window.motion->sigma_px_s[(i - poses) / 2];
      diagonal += of_motion > 0 ? left * left / (of_motion * of_motion) : 1;
    }
    if (i >= camera_at) diagonal += camera_ridge * params.error_factor * params.error_factor * sums.variance;
  }
  if (!cholesky_factor(w.system.data(), system_size)) return false;
  cholesky_solve_lower(w.system.data(), system_size, w.right.data());
  for (std::size_t i = 0; i < camera_at; ++i) sums.explained += w.right[i] * w.right[i];
  window.left_px = std::sqrt(std::fmax(sums.squared - sums.explained, 0) / (2 * sums.weight));
  return true;
}

/// Moves poses and points by one step with the camera as it is.
void adjust(Window& window, IntrinsicsWorkspace& w) {
  for (double& value : w.right) value = -value;
  std::fill(w.right.begin() + camera_at, w.right.end(), 0);
  cholesky_solve_upper(w.system.data(), system_size, w.right.data());
  SeenPoint point;
  Eliminated own;
  for (std::size_t i = 0; i < window.problem.observations.size();) {  // collect moves on
    BundlePoint& moved = window.problem.points[window.problem.observations[i].point];
    collect(window, i, point);
    if (!eliminate(point, own)) continue;
    const Vec3 step = after_step(point, own, w).moved;
    for (int k = 0; k < 3; ++k) moved.position[k] += step[k];
  }
  for (std::size_t view = 1; view < window.problem.cameras.size(); ++view) {
    RigidTransform& pose = window.cam_from_world[view];
    const double* step = w.right.data() + 6 * (view - 1);
    const Mat3 turn = rotation_from_vector(Vec3(step[0], step[1], step[2]));
    pose = {turn * pose.rotation, turn * pose.translation + Vec3(step[3], step[4], step[5])};
    window.problem.cameras[view].pose = pose_from(pose);
  }
}

/// By the factor of the system: what poses answer to a unit of each unknown, and how far that bends the track.
void add_displacement(const Window& window, IntrinsicsWorkspace& w, IntrinsicsEquations& equations) {
  MeasuredPlaces centres;
  Vec3 middle = Vec3::Zero();
  const std::size_t views = window.problem.cameras.size();
  for (std::size_t view = 0; view < views; ++view) {
    const Vec3 centre = camera_centre(window.cam_from_world[view]);
    static_cast<void>(
        centres.push_back({static_cast<std::uint16_t>(view), {centre[0], centre[1], centre[2]}, {1, 1, 1}}));
    middle += centre / static_cast<double>(views);
  }
  double extent2 = 0;
  for (const MeasuredPlace& place : centres) extent2 += (Eigen::Map<const Vec3>(place.place_m) - middle).squaredNorm();
  PlaceEquations of;
  if (!(extent2 > 0) || !place_equations(window.cam_from_world, centres, {}, loss_sigmas, of)) return;
  double moved[camera_unknowns][PlaceEquations::size] = {};
  for (std::size_t a = 0; a < camera_unknowns; ++a) {
    w.right.fill(0);
    const double* const row = w.system.data() + (camera_at + a) * system_size + camera_at;
    std::copy_n(row, a + 1, w.right.begin() + camera_at);
    cholesky_solve_upper(w.system.data(), system_size, w.right.data());
    for (std::size_t view = 1; view < views; ++view) {
      const double* const step = w.right.data() + 6 * (view - 1);
      const Vec3 centre_moves = -(window.cam_from_world[view].rotation.transpose() * Vec3(step[3], step[4], step[5]));
      std::copy_n(centre_moves.data(), 3, moved[a] + 3 * view);
    }
  }
  for (std::size_t a = 0; a < camera_unknowns; ++a) {
    for (std::size_t b = 0; b < camera_unknowns; ++b) {
      double sum = 0;
      for (std::size_t i = 0; i < 3 * views; ++i) {
        for (std::size_t k = 0; k < 3 * views; ++k) sum += moved[a][i] * of.information[i][k] * moved[b][k];
      }
      equations.displacement[a][b] = sum / extent2;
    }
  }
}

}  // namespace

CameraUnknowns usual_errors(const CameraModel& nominal) {
  return {0.115 * nominal.fx, 0.02 * nominal.width, 0.02 * nominal.width, 0.3, 0.15, 0.002, 0.002, 0.05};
}

CameraModel corrected(const CameraModel& camera, const CameraUnknowns& corrections) {
  CameraModel out = camera;
  out.fx += corrections[0];
  out.fy += corrections[0] * camera.fy / camera.fx;
  out.cx += corrections[1];
  out.cy += corrections[2];
  out.k1 += corrections[3];
  out.k2 += corrections[4];
  out.p1 += corrections[5];
  out.p2 += corrections[6];
  out.readout_s += corrections[readout_unknown];
  return out;
}

Status reduce_to_intrinsics(const CameraModel& camera, const ReductionParams& params, BundleProblem& window,
                            IntrinsicsWorkspace& workspace, IntrinsicsEquations& equations, ResidualField& field) {
  equations = {};
  ILP_TRY(validate(camera));
  ILP_TRY(check(window, params.places, params.heights));
  if (window.cameras.size() < 3) return {};
  Window of{camera, window, usual_errors(camera), {}, 0, params.motion, nullptr, 0};
  for (std::size_t i = 0; i < window.cameras.size(); ++i) {
    of.cam_from_world[i] = cam_from_world(window.cameras[i].pose);
  }
  WindowSums sums;
  for (std::uint32_t step = 0; step < params.steps; ++step) {
    if (!assemble(of, workspace, params, sums)) return {};
    adjust(of, workspace);
  }
  // Heights take part here alone: beside the residuals of pixels that a camera leaves which has just changed, they
  // would count too much.
  of.heights = params.heights;
  if (!assemble(of, workspace, params, sums)) return {};
  equations.points = sums.points;
  equations.observations = sums.observations;
  equations.noise_px = of.left_px;
  const double unit = std::fmax(params.error_factor * equations.noise_px, least_sigma_px);
  double* x = workspace.right.data();
  const double* l = workspace.system.data();
  for (std::size_t a = 0; a < camera_unknowns; ++a) {
    const double* row_a = l + (camera_at + a) * system_size + camera_at;
    equations.gained += x[camera_at + a] * x[camera_at + a] / (unit * unit);
    for (std::size_t b = 0; b <= a; ++b) {
      const double* row_b = l + (camera_at + b) * system_size + camera_at;
      double sum = 0;
      for (std::size_t k = 0; k <= b; ++k) sum += row_a[k] * row_b[k];
      equations.information[a][b] = equations.information[b][a] = sum / (unit * unit);
      equations.gradient[a] += row_a[b] * x[camera_at + b] / (unit * unit);
    }
  }
  const std::array<double, system_size> solved = workspace.right;
  add_displacement(of, workspace, equations);
  workspace.right = solved;
  for (double& value : workspace.right) value = -value;
  cholesky_solve_upper(l, system_size, x);
  SeenPoint point;
  Eliminated own;
  for (std::size_t i = 0; i < window.observations.size();) {  // collect moves on
    collect(of, i, point);
    if (eliminate(point, own)) add_to_field(camera, point, after_step(point, own, workspace), field);
  }
  return {};
}

}  // namespace ilp
