#include "fsw/motion/keyframe_motion.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/fixed_vector.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rolling_shutter.hpp"
#include "fsw/vision/geometry/symmetric_solver.hpp"
#include "fsw/vision/overlap/overlap.hpp"

namespace ilp {
namespace {

constexpr int on_each_side = 2;
constexpr std::size_t most_frames = 2 * on_each_side + 1;
/// Further apart, a swing of a few seconds is no polynomial.
constexpr double longest_interval_s = 2;
/// Of the motion: three frames at an eighth of a swing's period attenuate it by a tenth, and nothing shows it.
constexpr double share_of_few_frames = 0.1;
constexpr int grid = 7;
constexpr double grid_margin = 0.06;
/// Each round corrects the planes with the motion of the round before.
constexpr int rounds = 3;

/// The image of the keyframe in another frame, or in itself.
struct Neighbour {
  double seconds = 0;                                  ///< after the keyframe
  double plane[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};       ///< real px of the keyframe to real px of the frame
  double normalised[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< homography of normalised coordinates
  ImageMotion motion;

  [[nodiscard]] Mat3 homography() const {
    Mat3 h;
    for (int i = 0; i < 9; ++i) h(i / 3, i % 3) = normalised[i];
    return h;
  }
};
using Neighbours = FixedVector<Neighbour, most_frames>;

/// Real px of keyframe `from` to those of `to`, of one strip; false where a record is missing.
Result<bool> plane_between(Reader<KeyframeRecord> store, const KeyframeRecord& from, std::int64_t to,
                           double (&plane)[9]) {
  for (int i = 0; i < 9; ++i) plane[i] = i % 4 == 0 ? 1 : 0;
  const std::int64_t low = std::min(from.id, to), high = std::max(from.id, to);
  if (high - low > on_each_side + 1) return false;
  for (std::int64_t id = low + 1; id <= high; ++id) {
    KeyframeRecord keyframe;
    ILP_TAKE(const bool known, find(store, id, keyframe));
    if (!known || keyframe.strip_id != from.strip_id || keyframe.index == 0) return false;
    compose_planes(keyframe.plane_from_previous, plane, plane);
  }
  return to >= from.id || invert_plane(plane, plane);
}

/// The keyframe whose frame is `frame_id`, among those near the given one; 0: none.
Result<std::int64_t> keyframe_of(Reader<KeyframeRecord> store, const KeyframeRecord& near, std::int64_t frame_id) {
  for (std::int64_t id = std::max<std::int64_t>(near.id - on_each_side, 1); id <= near.id + on_each_side; ++id) {
    KeyframeRecord keyframe;
    ILP_TAKE(const bool known, find(store, id, keyframe));
    if (known && keyframe.frame_id == frame_id && keyframe.strip_id == near.strip_id) return id;
  }
  return std::int64_t{0};
}

Result<bool> find_neighbour(KeyframeMotionStore store, const KeyframeRecord& keyframe, std::int64_t frame_id,
                            Neighbour& neighbour) {
  FrameRecord frame;
  ILP_TAKE(const bool known, find<FrameRecord>(store, frame_id, frame));
  if (!known) return false;
  neighbour.seconds = 1e-9 * static_cast<double>(frame.time_ns - keyframe.time_ns);
  ILP_TAKE(std::int64_t compared_with, keyframe_of(store, keyframe, frame_id));
  FramePlaneRecord plane;
  if (compared_with == 0) {
    ILP_TAKE(const bool measured, find<FramePlaneRecord>(store, frame_id, plane));
    if (!measured) return false;
    compared_with = plane.keyframe_id;
  }
  double to_compared[9];
  ILP_TAKE(const bool usable, plane_between(store, keyframe, compared_with, to_compared));
  if (!usable) return false;
  compose_planes(plane.plane_from_keyframe, to_compared, neighbour.plane);
  return true;
}

Vec2 mapped(const double (&h)[9], const Vec2& p) {
  const double w = h[6] * p.x() + h[7] * p.y() + h[8];
  return {(h[0] * p.x() + h[1] * p.y() + h[2]) / w, (h[3] * p.x() + h[4] * p.y() + h[5]) / w};
}

/// The homography of normalised coordinates that is nearest to the plane over the common view. Registration fits a
/// plane to the real images, distortion included, over the same view.
bool fit_homography(const CameraModel& camera, const ImageMotion& motion, Neighbour& neighbour) {
  Eigen::Matrix<double, 8, 8> a = Eigen::Matrix<double, 8, 8>::Zero();
  Eigen::Matrix<double, 8, 1> b = Eigen::Matrix<double, 8, 1>::Zero();
  int points = 0;
  for (int j = 0; j < grid; ++j) {
    for (int i = 0; i < grid; ++i) {
      const Vec2 here((grid_margin + (1 - 2 * grid_margin) * i / (grid - 1)) * (camera.width - 1),
                      (grid_margin + (1 - 2 * grid_margin) * j / (grid - 1)) * (camera.height - 1));
      const Vec2 there = mapped(neighbour.plane, here);
      if (!(there.x() >= 0 && there.y() >= 0 && there.x() <= camera.width - 1 && there.y() <= camera.height - 1))
        continue;
      ++points;
      const Vec2 p = moved_back(motion, row_time_s(camera, here.y()), normalised_from_pixel(camera, here));
      const Vec2 q = moved_back(neighbour.motion, row_time_s(camera, there.y()), normalised_from_pixel(camera, there));
      for (Eigen::Index k = 0; k < 2; ++k) {
        Eigen::Matrix<double, 8, 1> row = Eigen::Matrix<double, 8, 1>::Zero();
        row[3 * k] = p.x();
        row[3 * k + 1] = p.y();
        row[3 * k + 2] = 1;
        row[6] = -q[k] * p.x();
        row[7] = -q[k] * p.y();
        for (int m = 0; m < 8; ++m) {
          for (int n = 0; n < 8; ++n) a(m, n) += row[m] * row[n];
          b[m] += row[m] * q[k];
        }
      }
    }
  }
  if (points < grid * grid / 4) return false;
  const Eigen::Matrix<double, 8, 1> h = solve_symmetric<8>(a, b);
  std::copy_n(h.data(), 8, neighbour.normalised);
  return true;
}

/// Derivative of Lagrange's basis polynomial `of` at the time of neighbour `at`.
double basis_derivative(const Neighbours& all, std::size_t of, std::size_t at) {
  double sum = 0;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (k == of) continue;
    double product = 1 / (all[of].seconds - all[k].seconds);
    for (std::size_t m = 0; m < all.size(); ++m) {
      if (m != of && m != k) product *= (all[at].seconds - all[m].seconds) / (all[of].seconds - all[m].seconds);
    }
    sum += product;
  }
  return sum;
}

/// At the time of neighbour `at`, in its own coordinates.
ImageMotion motion_at(const Neighbours& all, std::size_t at) {
  Mat3 rate = Mat3::Zero();
  for (std::size_t k = 0; k < all.size(); ++k) rate += basis_derivative(all, k, at) * all[k].homography();
  const Mat3 h = all[at].homography();
  // The adjugate is the inverse but for a factor, which the determinant takes out.
  Mat3 inverse;
  inverse.col(0) = h.row(1).transpose().cross(h.row(2).transpose());
  inverse.col(1) = h.row(2).transpose().cross(h.row(0).transpose());
  inverse.col(2) = h.row(0).transpose().cross(h.row(1).transpose());
  const Mat3 m = rate * inverse / h.row(0).dot(inverse.col(0));
  ImageMotion motion;
  for (int i = 0; i < 8; ++i) motion.m[i] = m(i / 3, i % 3) - (i % 4 == 0 ? m(2, 2) : 0);
  return motion;
}

/// The distance of the derivatives of the image's middle, px/s, where only the nearest frames take part and where all
/// do.
double change_without_outer(const CameraModel& camera, const Neighbours& all, std::size_t own) {
  Neighbours inner;
  for (std::size_t k = own == 0 ? 0 : own - 1; k < std::min(own + 2, all.size()); ++k)
    static_cast<void>(inner.push_back(all[k]));
  const ImageMotion a = motion_at(inner, own == 0 ? 0 : 1);
  const ImageMotion& b = all[own].motion;
  const Vec2 change(camera.fx * (a.m[2] - b.m[2]), camera.fy * (a.m[5] - b.m[5]));
  return change.norm();
}

}  // namespace

double motion_sigma_px_s(const CameraModel& camera, const ShutterRecord& shutter) {
  // Of an image that stays as it was read: the turn of a swing.
  constexpr double unknown_turn_rad_s = 0.1;
  // Where the swing is at its end, derivatives by three and five frames agree, and relief disturbs both alike.
  constexpr double unseen_factor = 2;
  const bool known = shutter.source != MotionSource::none;
  return known ? unseen_factor * shutter.sigma_px_s : unknown_turn_rad_s * camera.fx;
}

double shutter_error_rad(const CameraRecord& camera, const ShutterRecord& shutter) {
  // Of what grows evenly from the first row to the last one, the root mean square about the middle row.
  constexpr double of_all_rows = 0.2886751345948129;  // 1 / sqrt(12)
  const double sigma = motion_sigma_px_s(camera_model(camera), shutter) / camera.fx;
  if (shutter.source == MotionSource::none)
    return of_all_rows * (std::fabs(camera.readout_s) + camera.sigma_readout_s) * sigma;
  const double of_readout = camera.sigma_readout_s * Vec2(shutter.motion[2], shutter.motion[5]).norm();
  return of_all_rows * Vec2(camera.readout_s * sigma, of_readout).norm();
}

Result<bool> keyframe_motion(KeyframeMotionStore store, const CameraRecord& record, const KeyframeRecord& keyframe,
                             ShutterRecord& shutter) {
  shutter = {};
  if (!has_rolling_shutter(record)) return true;
  const CameraModel camera = camera_model(record);
  StripRecord strip;
  ILP_TAKE(const bool known, find<StripRecord>(store, keyframe.strip_id, strip));
  OverlapRecord newest;
  ILP_TAKE(const bool judged, find<OverlapRecord>(store, keyframe.frame_id + on_each_side, newest));
  if (!judged && known && strip.end == StripEnd::open) return false;
  shutter.id = keyframe.id;
  shutter.sigma_px_s = unknown;

  Neighbours all;
  std::size_t own = 0;
  double last_s = -longest_interval_s * (on_each_side + 1);
  for (std::int64_t offset = -on_each_side; offset <= on_each_side; ++offset) {
    Neighbour neighbour;
    if (offset == 0) {
      own = all.size();
    } else {
      ILP_TAKE(const bool found, find_neighbour(store, keyframe, keyframe.frame_id + offset, neighbour));
      if (!found || !(std::fabs(neighbour.seconds) <= on_each_side * longest_interval_s)) continue;
      if (!fit_homography(camera, {}, neighbour)) continue;
    }
    if (!(neighbour.seconds > last_s) || (neighbour.seconds > 0) != (offset > 0)) continue;
    last_s = neighbour.seconds;
    static_cast<void>(all.push_back(neighbour));
  }
  shutter.frames = static_cast<std::uint32_t>(all.size()) - 1;
  if (shutter.frames == 0) return true;
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t k = 0; round > 0 && k < all.size(); ++k) {
      if (k != own) static_cast<void>(fit_homography(camera, all[own].motion, all[k]));
    }
    FixedVector<ImageMotion, most_frames> motions;
    for (std::size_t k = 0; k < all.size(); ++k) static_cast<void>(motions.push_back(motion_at(all, k)));
    for (std::size_t k = 0; k < all.size(); ++k) all[k].motion = motions[k];
  }
  if (!within_reach(camera, all[own].motion)) return true;
  shutter.source = MotionSource::frames;
  std::copy_n(all[own].motion.m, 8, shutter.motion);
  const ImageMotion& found = all[own].motion;
  const double speed = Vec2(camera.fx * found.m[2], camera.fy * found.m[5]).norm();
  const double unchecked = shutter.frames < 2 * on_each_side ? share_of_few_frames * speed : 0;
  shutter.sigma_px_s = std::fmax(0.5 * change_without_outer(camera, all, own), unchecked);
  return true;
}

}  // namespace ilp
