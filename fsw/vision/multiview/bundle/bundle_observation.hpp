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
  std::uint32_t block;  ///< of a free one: its number among them
};

struct Observation {
  double x, y;
  std::uint16_t camera;
};

/// Huber's function of a squared residual, and the weight with which weighted least squares has the same gradient.
/// Bound 0 = plain least squares.
inline double huber(double squared, double bound, double& weight) {
  weight = 1;
  if (bound <= 0 || squared <= bound * bound) return squared;
  const double norm = std::sqrt(squared);
  weight = bound / norm;
  return 2 * bound * norm - bound * bound;
}

/// A robust function of squared residuals; bound 0 = plain least squares.
struct Loss {
  double bound;  ///< px
  bool cauchy;   ///< else Huber's

  /// Value and weight, as `huber` gives them; Cauchy's function is bound^2 log(1 + squared / bound^2).
  double operator()(double squared, double& weight) const {
    if (!cauchy || bound <= 0) return huber(squared, bound, weight);
    const double bound2 = bound * bound;
    weight = bound2 / (bound2 + squared);
    return bound2 * det_log(1 + squared / bound2);
  }

  [[nodiscard]] double cost(double squared) const {
    double unused = 1;
    return (*this)(squared, unused);
  }
  [[nodiscard]] double weight(double squared) const {
    if (cauchy && bound > 0) return bound * bound / (bound * bound + squared);
    double weight = 1;
    (void)huber(squared, bound, weight);
    return weight;
  }
  /// Mean over all directions of the derivative of a weighted residual by the residual.
  [[nodiscard]] double slope(double weight) const {
    if (cauchy) return weight * weight;
    // Beyond the bound a weighted residual keeps its length, so it changes only across its direction.
    return weight < 1 ? 0.5 * weight : 1;
  }
};

/// Residual and derivatives, both times the square root of the robust weight.
struct Linearised {
  double eu, ev;        ///< residual, px
  double pu[3], pv[3];  ///< by the point; by the camera's centre with the opposite sign
  double wu[3], wv[3];  ///< by the camera's rotation vector
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
    double weight = 1;
    (void)loss(eu * eu + ev * ev, weight);
    const double root = std::sqrt(weight);
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

/// Linearises with Huber's function.
inline Linearised linearise(const Camera& camera, const Observation& o, const double point[3], double robust_px) {
  return linearise(camera, o, point, Loss{robust_px, false});
}

}  // namespace ilp::bundle
