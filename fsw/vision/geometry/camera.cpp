#include "fsw/vision/geometry/camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "cfg/limits.hpp"
#include "fsw/base/argument.hpp"
#include "fsw/base/math.hpp"
#include "fsw/base/vector_width.hpp"

namespace ilp {

namespace {

constexpr int max_undistort_steps = 20;
constexpr double undistorted_within2 = 1e-26;  // squared
constexpr double smallest_determinant = 1e-6;

/// Points that take their Newton steps together.
constexpr std::int32_t points_at_once = 64;
using Points = std::array<double, static_cast<std::size_t>(points_at_once)>;

/// One step for all points of which `going` is not 0, which is then 1. False when none is left.
bool undistort_step(const CameraModel& camera, std::int32_t count, const double* __restrict x_distorted,
                    const double* __restrict y_distorted, double* __restrict x_out, double* __restrict y_out,
                    std::int64_t* __restrict going) {
  std::int64_t left = 0;
  for (std::int32_t i = 0; i < count; ++i) {
    const double x = x_out[i];
    const double y = y_out[i];
    const Distorted d = plain_distort(camera, x, y);
    const double residual_x = d.x - x_distorted[i];
    const double residual_y = d.y - y_distorted[i];
    const DistortionJacobian j = plain_jacobian(camera, x, y);
    const double determinant = j.a * j.d - j.b * j.c;
    const int away = static_cast<int>(!(residual_x * residual_x + residual_y * residual_y < undistorted_within2));
    const int regular = static_cast<int>(std::fabs(determinant) > smallest_determinant);
    const std::int64_t goes = going[i] & away & regular;
    const double x_new = x - (j.d * residual_x - j.b * residual_y) / determinant;
    const double y_new = y - (j.a * residual_y - j.c * residual_x) / determinant;
    x_out[i] = goes != 0 ? x_new : x;
    y_out[i] = goes != 0 ? y_new : y;
    going[i] = goes;
    left |= goes;
  }
  return left != 0;
}

/// A polynomial in q and its derivative by q.
struct Factor {
  double value, by_q;
};
/// 1 + c1 q + c2 q^2 + c3 q^3 + c4 q^4.
Factor polynomial(double q, double c1, double c2, double c3, double c4 = 0) {
  return {1 + q * (c1 + q * (c2 + q * (c3 + q * c4))), c1 + q * (2 * c2 + q * (3 * c3 + q * 4 * c4))};
}

/// s of fsw/base/geometry.hpp and its derivative by r2.
Factor brown_factor(const CameraModel& camera, double r2) {
  const Factor above = polynomial(r2, camera.k1, camera.k2, camera.k3);
  const Factor below = polynomial(r2, camera.k4, camera.k5, camera.k6);
  const double s = above.value / below.value;
  return {s, (above.by_q - s * below.by_q) / below.value};
}

/// Nearer to the axis than this, a fisheye and a pinhole are the same.
constexpr double on_axis2 = 1e-20;

/// The distance from the centre at an angle from the axis, and its derivative.
Factor fisheye_radius(const CameraModel& camera, double angle) {
  const double q = angle * angle;
  const Factor grown = polynomial(q, camera.k1, camera.k2, camera.k3, camera.k4);
  return {angle * grown.value, grown.value + 2 * q * grown.by_q};
}

Factor fisheye_factor(const CameraModel& camera, double r2) {
  if (r2 < on_axis2) return {1, 0};
  const double r = std::sqrt(r2);
  const Factor radius = fisheye_radius(camera, det_atan2(r, 1));
  const double s = radius.value / r;
  return {s, (radius.by_q / (1 + r2) - s) / (2 * r2)};
}

Factor factor_of(const CameraModel& camera, double r2) {
  return camera.lens == Lens::fisheye ? fisheye_factor(camera, r2) : brown_factor(camera, r2);
}

/// The angle from the axis at a distance from the centre, at most `widest`.
constexpr double widest = 1.5;
double fisheye_angle(const CameraModel& camera, double distance) {
  double angle = std::min(distance, widest);
  for (int step = 0; step < max_undistort_steps; ++step) {
    const Factor radius = fisheye_radius(camera, angle);
    const double residual = radius.value - distance;
    if (residual * residual < undistorted_within2 || !(std::fabs(radius.by_q) > smallest_determinant)) break;
    angle = std::clamp(angle - residual / radius.by_q, 0.0, widest);
  }
  return angle;
}

/// The distance from the centre grows with the angle up to the corners of the image, with a margin.
Status check_fisheye(const CameraModel& camera) {
  double farthest = 0;
  for (const double u : {-0.5, camera.width - 0.5}) {
    for (const double v : {-0.5, camera.height - 0.5}) {
      const Vec2 corner((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy);
      farthest = std::fmax(farthest, corner.norm());
    }
  }
  constexpr double degree = pi / 180;
  constexpr int steps = 100;
  double angle = 0;
  // A margin of 5 degrees, because the box around the ideal image has its corners there.
  for (int step = 0; step <= steps; ++step) {
    angle = step * (max_view_angle_deg + 5) * degree / steps;
    if (!(fisheye_radius(camera, angle).by_q > 0.05)) return out_of_range(Argument::distortion, camera.k1);
    if (fisheye_radius(camera, angle - 5 * degree).value > farthest) return {};
  }
  return out_of_range(Argument::view_angle, fisheye_angle(camera, farthest) / degree);
}

bool invertible_over_image(const CameraModel& camera) {
  // The Jacobian must keep its orientation from the centre to every border pixel, with a margin.
  constexpr int steps = 16;
  for (int iy = 0; iy <= steps; ++iy) {
    for (int ix = 0; ix <= steps; ++ix) {
      const Vec2 pixel(-0.5 + camera.width * ix / double{steps}, -0.5 + camera.height * iy / double{steps});
      const Vec2 distorted((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy);
      const Vec2 ideal = undistort(camera, distorted);
      const DistortionJacobian j = distortion_jacobian(camera, ideal.x(), ideal.y());
      if (!(j.a * j.d - j.b * j.c > 0.05)) return false;
      if (!((distort(camera, ideal) - distorted).norm() < 1e-9)) return false;
    }
  }
  return true;
}

}  // namespace

Status validate(const CameraModel& camera) {
  if (camera.width > limits::max_image_width || camera.height > limits::max_image_height) {
    return {StatusCode::image_too_large, camera.width, camera.height};
  }
  return validate_of_any_size(camera);
}

Status validate_of_any_size(const CameraModel& camera) {
  const double values[] = {camera.fx, camera.fy, camera.cx, camera.cy, camera.k1, camera.k2,
                           camera.p1, camera.p2, camera.k3, camera.k4, camera.k5, camera.k6};
  for (const double value : values) {
    if (!std::isfinite(value)) return out_of_range(Argument::camera, value);
  }
  if (camera.width < limits::min_image_side || camera.height < limits::min_image_side) {
    return out_of_range(Argument::image_size, camera.width < camera.height ? camera.width : camera.height);
  }
  const double longest = max_focal_sides * (camera.width > camera.height ? camera.width : camera.height);
  const double aspect = camera.fy / camera.fx;
  if (camera.fx <= 1 || camera.fy <= 1 || camera.fx > longest || camera.fy > longest ||
      !(aspect > 1 / max_pixel_aspect && aspect < max_pixel_aspect)) {
    return out_of_range(Argument::focal_length, camera.fx <= 1 || camera.fx > longest ? camera.fx : camera.fy);
  }
  if (camera.cx < -camera.width || camera.cx > 2 * camera.width || camera.cy < -camera.height ||
      camera.cy > 2 * camera.height) {
    return out_of_range(Argument::principal_point,
                        camera.cx < -camera.width || camera.cx > 2 * camera.width ? camera.cx : camera.cy);
  }
  // Not finite is outside too.
  if (!(std::fabs(camera.readout_s) <= max_readout_s)) return out_of_range(Argument::readout, camera.readout_s);
  if (camera.lens == Lens::fisheye) return check_fisheye(camera);
  if (camera.has_distortion() && !invertible_over_image(camera)) return out_of_range(Argument::distortion, camera.k1);
  return {};
}

CameraSuspicion suspicion_about(const CameraModel& camera) {
  // Half the width over the focal length: the tangent of half the field of view.
  constexpr double least = 0.0262, most = 2.1445;
  double tangent = 0.5 * camera.width / camera.fx;
  if (camera.lens == Lens::fisheye) tangent = undistort(camera, Vec2(tangent, 0)).x();
  if (tangent < least || tangent > most) return CameraSuspicion::field_of_view;
  const double x = (camera.cx + 0.5) / camera.width, y = (camera.cy + 0.5) / camera.height;
  const bool central = x > 1.0 / 3 && x < 2.0 / 3 && y > 1.0 / 3 && y < 2.0 / 3;
  return central ? CameraSuspicion::none : CameraSuspicion::principal_point;
}

CameraModel camera_of_field(std::int32_t width, std::int32_t height, double field_of_view_rad) {
  const double half = 0.5 * field_of_view_rad;
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 0.5 * width * det_cos(half) / det_sin(half);
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  return camera;
}

double focal_per_field(const CameraModel& camera) {
  // f = w / 2 / tan(field / 2), so that df / f = -d(field) / sin(field).
  const double tangent = 0.5 * camera.width / camera.fx;
  return -0.5 * (1 + tangent * tangent) / tangent;
}

Vec2 distort(const CameraModel& camera, const Vec2& normalised) {
  const double x = normalised.x();
  const double y = normalised.y();
  const Distorted plain = plain_distort(camera, x, y);
  if (camera.is_plain()) return {plain.x, plain.y};
  const double r2 = x * x + y * y;
  const double s = factor_of(camera, r2).value;
  if (camera.lens == Lens::fisheye) return s * normalised;
  const double xy2 = 2 * x * y;
  return {x * s + camera.p1 * xy2 + camera.p2 * (r2 + 2 * x * x),
          y * s + camera.p1 * (r2 + 2 * y * y) + camera.p2 * xy2};
}

DistortionJacobian distortion_jacobian(const CameraModel& camera, double x, double y) {
  if (camera.is_plain()) return plain_jacobian(camera, x, y);
  const Factor s = factor_of(camera, x * x + y * y);
  const double cross = 2 * x * y * s.by_q + 2 * camera.p1 * x + 2 * camera.p2 * y;
  return {s.value + 2 * x * x * s.by_q + 2 * camera.p1 * y + 6 * camera.p2 * x, cross, cross,
          s.value + 2 * y * y * s.by_q + 6 * camera.p1 * y + 2 * camera.p2 * x};
}

Eigen::Matrix<double, 2, static_cast<int>(intrinsic_count)> pixel_by_intrinsics(const CameraModel& camera,
                                                                                const Vec2& normalised) {
  const double x = normalised.x(), y = normalised.y(), r2 = x * x + y * y;
  const double x2 = camera.fx * x, y2 = camera.fy * y;
  const Vec2 distorted = distort(camera, normalised);
  // Derivatives of s by k1 and k2 are first and first * ratio.
  double first = r2, ratio = r2;
  double tangential = 1;
  if (camera.lens == Lens::fisheye) {
    const double r = std::sqrt(r2), angle = det_atan2(r, 1);
    ratio = angle * angle;
    first = r2 < on_axis2 ? 0 : ratio * angle / r;
    tangential = 0;
  } else if (!camera.is_plain()) {
    first = r2 / polynomial(r2, camera.k4, camera.k5, camera.k6).value;
  }
  Eigen::Matrix<double, 2, static_cast<int>(intrinsic_count)> by;
  by << distorted.x(), 1, 0, x2 * first, x2 * first * ratio, 2 * x2 * y, camera.fx * (r2 + 2 * x * x),  //
      distorted.y() * camera.fy / camera.fx, 0, 1, y2 * first, y2 * first * ratio, camera.fy * (r2 + 2 * y * y),
      2 * y2 * x;
  by.rightCols<2>() *= tangential;
  return by;
}

CameraModel with_focal_length(const CameraModel& camera, double factor) {
  CameraModel out = camera;
  out.fx *= factor;
  out.fy *= factor;
  if (camera.lens == Lens::fisheye) return out;
  const double factor2 = factor * factor;
  out.k1 *= factor2;
  out.k2 *= factor * factor * factor * factor;
  out.k3 *= factor2 * factor2 * factor2;
  out.k4 *= factor2;
  out.k5 *= factor2 * factor2;
  out.k6 *= factor2 * factor2 * factor2;
  out.p1 *= factor;
  out.p2 *= factor;
  return out;
}

Vec2 undistort(const CameraModel& camera, const Vec2& distorted) {
  if (!camera.has_distortion()) return distorted;
  if (camera.lens == Lens::fisheye) {
    const double distance = distorted.norm();
    if (distance * distance < on_axis2) return distorted;
    const double angle = fisheye_angle(camera, distance);
    return det_sin(angle) / (det_cos(angle) * distance) * distorted;
  }
  Vec2 x = distorted;
  for (int step = 0; step < max_undistort_steps; ++step) {
    const Vec2 residual = distort(camera, x) - distorted;
    if (residual.squaredNorm() < undistorted_within2) break;
    const DistortionJacobian j = distortion_jacobian(camera, x.x(), x.y());
    const double determinant = j.a * j.d - j.b * j.c;
    if (!(std::fabs(determinant) > smallest_determinant)) break;
    x -= Vec2((j.d * residual.x() - j.b * residual.y()) / determinant,
              (j.a * residual.y() - j.c * residual.x()) / determinant);
  }
  return x;
}

void undistort(const CameraModel& camera, std::int32_t count, double* x, double* y) {
  if (!camera.has_distortion()) return;
  if (!camera.is_plain()) {
    for (std::int32_t i = 0; i < count; ++i) {
      const Vec2 ideal = undistort(camera, Vec2(x[i], y[i]));
      x[i] = ideal.x();
      y[i] = ideal.y();
    }
    return;
  }
  with_widest_vectors([&] {
    for (std::int32_t first = 0; first < count; first += points_at_once) {
      const std::int32_t here = std::min(count - first, points_at_once);
      Points x_distorted, y_distorted;
      std::array<std::int64_t, static_cast<std::size_t>(points_at_once)> going;
      std::copy_n(x + first, here, x_distorted.begin());
      std::copy_n(y + first, here, y_distorted.begin());
      std::fill_n(going.begin(), here, 1);
      for (int step = 0; step < max_undistort_steps; ++step) {
        if (!undistort_step(camera, here, x_distorted.data(), y_distorted.data(), x + first, y + first, going.data())) {
          break;
        }
      }
    }
  });
}

Vec2 normalised_from_ideal(const CameraModel& camera, const Vec2& ideal) {
  return {(ideal.x() - camera.cx) / camera.fx, (ideal.y() - camera.cy) / camera.fy};
}

Vec2 ideal_from_normalised(const CameraModel& camera, const Vec2& normalised) {
  return {camera.fx * normalised.x() + camera.cx, camera.fy * normalised.y() + camera.cy};
}

Vec2 normalised_from_pixel(const CameraModel& camera, const Vec2& pixel) {
  return undistort(camera, normalised_from_ideal(camera, pixel));
}

Vec2 pixel_from_normalised(const CameraModel& camera, const Vec2& normalised) {
  return ideal_from_normalised(camera, distort(camera, normalised));
}

Vec2 ideal_from_pixel(const CameraModel& camera, const Vec2& pixel) {
  return ideal_from_normalised(camera, normalised_from_pixel(camera, pixel));
}

Vec2 pixel_from_ideal(const CameraModel& camera, const Vec2& ideal) {
  return pixel_from_normalised(camera, normalised_from_ideal(camera, ideal));
}

}  // namespace ilp
