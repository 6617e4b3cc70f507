// Inner loops of the bundle adjustment: two points that the same cameras see share one register.
//
// A camera's derivatives are taken with its centre in its own axes, where two of the twelve are zero; those of a point
// in the world. With B = J_point L^-T of an observation, V = L L^T, the Schur complement of cameras a and b is the sum
// over points of -J_a^T (B_a B_b^T) J_b: the factor between the Jacobians is 2 x 2.
#pragma once

#include <cmath>
#include <cstddef>

#include "fsw/vision/multiview/bundle/bundle_observation.hpp"

namespace ilp::bundle {

/// Additions and multiplications go lane by lane, so that their results do not depend on the machine.
using Lanes = double __attribute__((vector_size(16)));

inline Lanes both(double value) {
  return Lanes{value, value};
}
inline Lanes square_root(Lanes v) {
  return Lanes{std::sqrt(v[0]), std::sqrt(v[1])};
}
inline double sum(Lanes v) {
  return v[0] + v[1];
}
inline bool positive(Lanes v) {
  return v[0] > 0 && v[1] > 0;
}

/// Two observations by one camera.
struct View {
  Lanes eu, ev;        ///< residual, px, times the root of the robust weight; so all below
  Lanes pu[3], pv[3];  ///< by the point
  Lanes u[6], v[6];    ///< by the camera; u[4] and v[3] are zero and not written
};

/// Projection of the two points; false if one is not in front of the camera.
struct Projection {
  Lanes x, y, inverse_z;
};
inline bool project(const Camera& camera, const Lanes point[3], Projection& out) {
  const double* r = camera.rotation;
  const Lanes d0 = point[0] - camera.centre[0];
  const Lanes d1 = point[1] - camera.centre[1];
  const Lanes d2 = point[2] - camera.centre[2];
  const Lanes z = r[6] * d0 + r[7] * d1 + r[8] * d2;
  out.inverse_z = 1.0 / z;
  out.x = (r[0] * d0 + r[1] * d1 + r[2] * d2) * out.inverse_z;
  out.y = (r[3] * d0 + r[4] * d1 + r[5] * d2) * out.inverse_z;
  return positive(z);
}

/// Roots of the robust weights.
inline Lanes root_weights(Lanes squared, const Loss& loss) {
  Lanes root = {1, 1};
  if (loss.bound <= 0) return root;
  const double bound2 = loss.bound * loss.bound;
  for (int lane = 0; lane < 2; ++lane) {
    if (!loss.cauchy && squared[lane] <= bound2) continue;
    root[lane] = std::sqrt(loss.weight(squared[lane]));
  }
  return root;
}

/// Residuals and derivatives; those by the camera are zero in a lane where `counts` is.
inline void view(const Camera& camera, Lanes observed_x, Lanes observed_y, const Lanes point[3], const Loss& loss,
                 Lanes counts, View& out) {
  Projection p;
  (void)project(camera, point, p);
  const double* r = camera.rotation;
  const Lanes x = p.x;
  const Lanes y = p.y;
  const Lanes eu = camera.fx * x + camera.cx - observed_x;
  const Lanes ev = camera.fy * y + camera.cy - observed_y;
  const Lanes root = root_weights(eu * eu + ev * ev, loss);
  out.eu = eu * root;
  out.ev = ev * root;
  Lanes fu = camera.fx * root;
  Lanes fv = camera.fy * root;
  const Lanes au = fu * p.inverse_z;
  const Lanes av = fv * p.inverse_z;
  for (int k = 0; k < 3; ++k) {
    out.pu[k] = au * (r[k] - x * r[6 + k]);
    out.pv[k] = av * (r[3 + k] - y * r[6 + k]);
  }
  if (camera.free_index < 0) return;
  fu *= counts;
  fv *= counts;
  const Lanes xy = x * y;
  out.u[0] = -fu * xy;
  out.u[1] = fu * (1.0 + x * x);
  out.u[2] = -fu * y;
  out.u[3] = -au * counts;
  out.u[5] = -out.u[3] * x;
  out.v[0] = -fv * (1.0 + y * y);
  out.v[1] = fv * xy;
  out.v[2] = fv * x;
  out.v[4] = -av * counts;
  out.v[5] = -out.v[4] * y;
}

/// n0 = m00 u + m01 v, n1 = m10 u + m11 v.
inline void weigh(const View& b, Lanes m00, Lanes m01, Lanes m10, Lanes m11, Lanes n0[6], Lanes n1[6]) {
  for (const int c : {0, 1, 2, 5}) {
    n0[c] = m00 * b.u[c] + m01 * b.v[c];
    n1[c] = m10 * b.u[c] + m11 * b.v[c];
  }
  n0[3] = m00 * b.u[3];
  n1[3] = m10 * b.u[3];
  n0[4] = m01 * b.v[4];
  n1[4] = m11 * b.v[4];
}

/// block += J_a^T (n0; n1), 6 x 6 row-major.
inline void add_block(const View& a, const Lanes n0[6], const Lanes n1[6], Lanes* block) {
  for (const int r : {0, 1, 2, 5}) {
    for (int c = 0; c < 6; ++c) block[6 * r + c] += a.u[r] * n0[c] + a.v[r] * n1[c];
  }
  for (int c = 0; c < 6; ++c) block[18 + c] += a.u[3] * n0[c];
  for (int c = 0; c < 6; ++c) block[24 + c] += a.v[4] * n1[c];
}

/// The upper triangle of the same.
inline void add_diagonal_block(const View& a, const Lanes n0[6], const Lanes n1[6], Lanes* block) {
  for (int r = 0; r < 3; ++r) {
    for (int c = r; c < 6; ++c) block[6 * r + c] += a.u[r] * n0[c] + a.v[r] * n1[c];
  }
  for (int c = 3; c < 6; ++c) block[18 + c] += a.u[3] * n0[c];
  for (int c = 4; c < 6; ++c) block[24 + c] += a.v[4] * n1[c];
  block[35] += a.u[5] * n0[5] + a.v[5] * n1[5];
}

}  // namespace ilp::bundle
