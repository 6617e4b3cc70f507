// One observation of a bundle adjustment: residual, loss and derivatives.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "fsw/base/math.hpp"

namespace ilp::bundle {

constexpr std::size_t camera_size = 6;

/// A camera as the inner loops read it.
struct Camera {
  double rotation[9];  ///< row-major, cam_from_world
  double centre[3];
  double fx, fy, cx, cy;
  bool free;            ///< not fixed
  std::uint32_t block;  ///< index among the free cameras
};

struct Observation {
  double x, y;
  std::uint16_t camera;
};

/// Cauchy's loss of squared residuals, bound^2 log(1 + squared / bound^2). With bound 0 it is plain least squares.
struct Loss {
  double bound = 0;  ///< px

  [[nodiscard]] double cost(double squared) const {
    return bound > 0 ? bound * bound * det_log(1 + squared / (bound * bound)) : squared;
  }
  /// The weight with which weighted least squares has the same gradient.
  [[nodiscard]] double weight(double squared) const {
    return bound > 0 ? bound * bound / (bound * bound + squared) : 1;
  }
  /// Derivative of a weighted residual with respect to the residual, averaged over all directions.
  [[nodiscard]] static double slope(double weight) { return weight * weight; }
};

/// Residual and its derivatives, both multiplied by the square root of the robust weight.
struct Linearised {
  double eu, ev;  ///< residual, px
  /// Derivatives with respect to the point; those with respect to the camera's centre have the opposite sign.
  double pu[3], pv[3];
  double wu[3], wv[3];  ///< derivatives with respect to the camera's rotation vector
};

inline Linearised linearise(const Camera& camera, const Observation& o, const double point[3], const Loss& loss) {
  const double* r = camera.rotation;
  const double d0 = point[0] - camera.centre[0];
  const double d1 = point[1] - camera.centre[1];
  const double d2 = point[2] - camera.centre[2];
  const double inverse_z = 1 / (r[6] * d0 + r[7] * d1 + r[8] * d2);
  const double x = (r[0] * d0 + r[1] * d1 + r[2] * d2) * inverse_z;
  const double y = (r[3] * d0 + r[4] * d1 + r[5] * d2) * inverse_z;
  double eu = camera.fx * x + camera.cx - o.x;
  double ev = camera.fy * y + camera.cy - o.y;
  double fu = camera.fx;
  double fv = camera.fy;
  if (loss.bound > 0) {
    const double root = std::sqrt(loss.weight(eu * eu + ev * ev));
    eu *= root;
    ev *= root;
    fu *= root;
    fv *= root;
  }
  const double au = fu * inverse_z;
  const double av = fv * inverse_z;
  return {eu,
          ev,
          {au * (r[0] - x * r[6]), au * (r[1] - x * r[7]), au * (r[2] - x * r[8])},
          {av * (r[3] - y * r[6]), av * (r[4] - y * r[7]), av * (r[5] - y * r[8])},
          {-fu * x * y, fu * (1 + x * x), -fu * y},
          {-fv * (1 + y * y), fv * x * y, fv * x}};
}

}  // namespace ilp::bundle
