#include "fsw/vision/calibration/projective_reconstruction.hpp"
#include "fsw/base/median.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "fsw/base/rng.hpp"
#include "fsw/vision/calibration/views_adjustment.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/twoview/solvers/singular_values.hpp"
#include "fsw/vision/twoview/solvers/symmetric_eigen.hpp"

namespace ilp {
namespace {

using Vec12 = Eigen::Matrix<double, 12, 1>;
using Mat12 = Eigen::Matrix<double, 12, 12>;

std::uint32_t common_tracks(const CalibrationTracks& tracks, std::size_t a, std::size_t b) {
  std::uint32_t count = 0;
  for (const CalibrationTrack& track : tracks) count += has_view(track.used, a) && has_view(track.used, b) ? 1 : 0;
  return count;
}

/// P_1 = [[e]x F | e] for the camera whose epipole is e.
bool camera_from_fundamental(const Mat3& fundamental, ProjectiveCamera& camera) {
  SingularValues svd;
  if (!singular_values(fundamental / fundamental.norm(), svd)) return false;
  const Vec3 epipole = svd.u.col(2);
  const Mat3 m = cross_matrix(epipole) * fundamental / fundamental.norm();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) camera.p[4 * r + c] = m(r, c);
    camera.p[4 * r + 3] = epipole[r];
  }
  return true;
}

void normalise(ProjectiveCamera& camera) {
  double norm2 = 0;
  for (const double entry : camera.p) norm2 += entry * entry;
  const double scale = std::sqrt(3 / norm2);
  for (double& entry : camera.p) entry *= scale;
}

/// Adds m a^T to M and subtracts a . x from w: another plane becomes w = 0. Then w is divided by `unit`.
void change_plane(const Vec3& a, double unit, std::size_t second, CalibrationTracks& tracks,
                  ProjectiveCameras& cameras) {
  ProjectiveCamera& camera = cameras[second];
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) camera.p[4 * r + c] += camera.p[4 * r + 3] * a[c];
    camera.p[4 * r + 3] *= unit;
  }
  for (CalibrationTrack& track : tracks) {
    if (!track.known) continue;
    track.point[2] = (track.point[2] - (a[0] * track.point[0] + a[1] * track.point[1] + a[2])) / unit;
  }
}

double median(double* values, std::size_t count) {
  if (count == 0) return 0;
  return upper_median(std::span(values, count));
}

/// The plane w = a . (x, y, 1) nearest to the known points; distant points have less weight.
bool fit_plane(const CalibrationTracks& tracks, ProjectiveWorkspace& ws, Vec3& a, double& unit) {
  a.setZero();
  double scale = 0;  // of the residuals; 0: all weights alike
  for (int round = 0; round < 4; ++round) {
    Mat3 normal = Mat3::Zero();
    Vec3 right = Vec3::Zero();
    std::size_t count = 0;
    for (const CalibrationTrack& track : tracks) {
      if (!track.known) continue;
      const Vec3 x(track.point[0], track.point[1], 1);
      const double off = track.point[2] - a.dot(x);
      const double weight = scale > 0 ? 1 / (1 + off * off / (scale * scale)) : 1;
      normal += weight * x * x.transpose();
      right += weight * x * track.point[2];
      ++count;
    }
    const Eigen::LDLT<Mat3> factor(normal);
    a = factor.solve(right);
    if (count < 8 || !a.allFinite()) return false;
    std::size_t k = 0;
    for (const CalibrationTrack& track : tracks) {
      if (track.known) ws.values[k++] = std::fabs(track.point[2] - a.dot(Vec3(track.point[0], track.point[1], 1)));
    }
    scale = 1.5 * median(ws.values.data(), k);
    if (!(scale > 0)) return false;
  }
  unit = scale;
  return true;
}

/// Adds the two equations of a point's image to A^T A of the twelve entries of P.
void add_equations(const CalibrationTrack& track, std::size_t view, Mat12& normal) {
  const double x[4] = {track.point[0], track.point[1], 1, track.point[2]};
  double norm2 = 0;
  for (const double value : x) norm2 += value * value;
  const double weight = 1 / norm2;
  const double s[2] = {track.u[view], track.v[view]};
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      const double xx = weight * x[i] * x[j];
      normal(i, j) += xx;
      normal(4 + i, 4 + j) += xx;
      normal(i, 8 + j) -= s[0] * xx;
      normal(4 + i, 8 + j) -= s[1] * xx;
      normal(8 + i, 8 + j) += (s[0] * s[0] + s[1] * s[1]) * xx;
    }
  }
}

bool solve_camera(Mat12& normal, ProjectiveCamera& camera) {
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < i; ++j) normal(i, j) = normal(j, i);
  }
  SymmetricEigen<12> eigen;
  if (!symmetric_eigen<12>(normal, eigen)) return false;
  for (int i = 0; i < 12; ++i) camera.p[i] = eigen.vectors(i, 0);
  normalise(camera);
  return true;
}

double score(const CalibrationTracks& tracks, const ProjectiveWorkspace& ws, std::size_t count, std::size_t view,
             const ProjectiveCamera& camera, double bound2, std::uint32_t& inliers) {
  double sum = 0;
  inliers = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double squared = squared_residual(camera.p, tracks[ws.selected[i]], view);
    sum += std::fmin(squared, bound2);
    inliers += squared < bound2 ? 1 : 0;
  }
  return sum;
}

bool fit_to_inliers(const CalibrationTracks& tracks, const ProjectiveWorkspace& ws, std::size_t count, std::size_t view,
                    double bound2, ProjectiveCamera& camera) {
  Mat12 normal = Mat12::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    const CalibrationTrack& track = tracks[ws.selected[i]];
    if (squared_residual(camera.p, track, view) < bound2) add_equations(track, view, normal);
  }
  return solve_camera(normal, camera);
}

}  // namespace

std::size_t choose_second_view(const CalibrationTracks& tracks, std::size_t views) {
  constexpr std::uint32_t enough = 40;
  std::size_t best = 0;
  double best_value = 0;
  for (std::size_t view = 1; view < views; ++view) {
    const std::uint32_t common = common_tracks(tracks, 0, view);
    const double value = common < enough ? 0 : static_cast<double>(view) * std::sqrt(static_cast<double>(common));
    if (!(value > best_value)) continue;
    best_value = value;
    best = view;
  }
  return best;
}

Result<bool> reconstruct_pair(const CentredFrame& frame, std::size_t second, const RansacParams& params,
                              CalibrationTracks& tracks, ProjectiveWorkspace& ws, ProjectiveCameras& cameras) {
  ws.pairs.clear();
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    CalibrationTrack& track = tracks[i];
    track.known = false;
    if (!has_view(track.used, 0) || !has_view(track.used, second)) continue;
    ws.selected[ws.pairs.size()] = static_cast<std::uint16_t>(i);
    static_cast<void>(ws.pairs.push_back(
        {frame.x_px(track.u[0]), frame.y_px(track.v[0]), frame.x_px(track.u[second]), frame.y_px(track.v[second]), 0}));
  }
  FundamentalResult pair;
  ILP_TRY(estimate_fundamental(ws.pairs, params, ws.two_view, ws.inliers, pair));
  if (!pair.found || pair.gric_inliers >= pair.gric_homography) return false;
  Mat3 pixel_from_centred;
  pixel_from_centred << frame.unit_x_px, 0, frame.middle_x_px, 0, frame.unit_y_px, frame.middle_y_px, 0, 0, 1;
  const Mat3 fundamental = pixel_from_centred.transpose() * pair.fundamental * pixel_from_centred;
  cameras = {};
  if (!camera_from_fundamental(fundamental, cameras[second])) return false;
  const auto both = static_cast<ViewSet>(only_view(0) | only_view(second));
  for (std::size_t k = 0; k < ws.pairs.size(); ++k) {
    CalibrationTrack& track = tracks[ws.selected[k]];
    track.known = ws.inliers[k] != 0 && triangulate_linear(cameras, both, track);
  }
  Vec3 plane;
  double unit = 1;
  if (!fit_plane(tracks, ws, plane, unit)) return false;
  change_plane(plane, unit, second, tracks, cameras);
  normalise(cameras[second]);
  return true;
}

bool resect_projective(std::size_t view, ViewSet posed, double bound, std::uint32_t min_inliers, std::uint64_t seed,
                       CalibrationTracks& tracks, ProjectiveWorkspace& ws, ProjectiveCameras& cameras) {
  constexpr std::size_t sample_size = 6;
  constexpr int trials = 80;
  std::size_t count = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    // Points far off are wrong matches on their epipolar line.
    const bool near = std::fabs(tracks[i].point[2]) < 30;
    if (tracks[i].known && near && has_view(tracks[i].used, view)) {
      ws.selected[count++] = static_cast<std::uint16_t>(i);
    }
  }
  if (count < min_inliers || count < 2 * sample_size) return false;
  const double bound2 = bound * bound;
  Rng rng(seed, view);
  ProjectiveCamera best;
  double best_score = 1e300;
  std::uint32_t inliers = 0;
  for (int trial = 0; trial < trials; ++trial) {
    Mat12 normal = Mat12::Zero();
    for (std::size_t k = 0; k < sample_size; ++k) {
      add_equations(tracks[ws.selected[rng.below(static_cast<std::uint32_t>(count))]], view, normal);
    }
    ProjectiveCamera camera;
    if (!solve_camera(normal, camera)) continue;
    std::uint32_t agreeing = 0;
    double value = score(tracks, ws, count, view, camera, bound2, agreeing);
    // A sample of nearly coplanar points gives only a rough pose, so it is judged after a fit to its supporters.
    if (value < 1.2 * best_score && agreeing >= 2 * sample_size) {
      for (int round = 0; round < 3; ++round) {
        ProjectiveCamera fitted = camera;
        if (!fit_to_inliers(tracks, ws, count, view, bound2, fitted)) break;
        const double fitted_value = score(tracks, ws, count, view, fitted, bound2, agreeing);
        if (!(fitted_value < value)) break;
        value = fitted_value;
        camera = fitted;
      }
    }
    if (!(value < best_score)) continue;
    best_score = value;
    best = camera;
  }
  score(tracks, ws, count, view, best, bound2, inliers);
  if (inliers < min_inliers || std::size_t{2} * inliers < count) return false;
  cameras[view] = best;
  const auto now_posed = static_cast<ViewSet>(posed | only_view(view));
  for (CalibrationTrack& track : tracks) {
    if (!has_view(track.used, view)) continue;
    if (track.known) {
      if (!(squared_residual(best.p, track, view) < 4 * bound2)) track.used &= static_cast<ViewSet>(~only_view(view));
    } else if (view_count(track.used & now_posed) >= 2) {
      track.known = triangulate_linear(cameras, now_posed, track) && std::fabs(track.point[2]) < 30;
      for (std::size_t v = 0; v < limits::max_calibration_views && track.known; ++v) {
        if (!has_view(track.used & now_posed, v)) continue;
        track.known = squared_residual(cameras[v].p, track, v) < 4 * bound2;
      }
    }
  }
  return true;
}

std::uint32_t prune_tracks(const ProjectiveCameras& cameras, double bound, CalibrationTracks& tracks) {
  std::uint32_t known = 0;
  for (CalibrationTrack& track : tracks) {
    if (!track.known) continue;
    for (std::size_t view = 0; view < limits::max_calibration_views; ++view) {
      if (!has_view(track.used, view)) continue;
      if (!(squared_residual(cameras[view].p, track, view) < bound * bound)) {
        track.used &= static_cast<ViewSet>(~only_view(view));
      }
    }
    track.known = view_count(track.used) >= 2;
    known += track.known ? 1 : 0;
  }
  return known;
}

double residual_rms(const ProjectiveCameras& cameras, const CalibrationTracks& tracks) {
  double sum = 0;
  double count = 0;
  for (const CalibrationTrack& track : tracks) {
    if (!track.known) continue;
    for (std::size_t view = 0; view < limits::max_calibration_views; ++view) {
      if (!has_view(track.used, view)) continue;
      sum += squared_residual(cameras[view].p, track, view);
      count += 2;
    }
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

}  // namespace ilp
