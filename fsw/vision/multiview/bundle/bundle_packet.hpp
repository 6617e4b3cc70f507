// Inner loops of the bundle adjustment. Points that the same cameras see are processed together in one register. Two
// such points form a packet; vectors of 32 bytes hold two packets side by side. Sums add one packet after the other, so
// that the results are bit-identical for both vector widths.
//
// The derivatives with respect to a camera are taken with its centre in its own axes, where two of the twelve are zero.
// Their order is rotation x y z, centre z, centre x, centre y, so that the zeros come last. The derivatives with
// respect to a point are taken in the world. With B = J_point L^-T of an observation, V = L L^T, the Schur complement
// of cameras a and b is the sum over points of -J_a^T (B_a B_b^T) J_b, where the factor between the Jacobians is 2 x 2.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "fsw/vision/multiview/bundle/bundle_observation.hpp"

namespace ilp::bundle {

/// Additions and multiplications work lane by lane, so that their results do not depend on the machine.
using Lanes = double __attribute__((vector_size(16)));
/// The points of two packets. Only functions compiled for 32-byte vectors may use it.
using WideLanes = double __attribute__((vector_size(32)));

template <typename V>
constexpr std::size_t lanes_of = sizeof(V) / sizeof(double);
template <typename V>
constexpr std::size_t packets_of = sizeof(V) / sizeof(Lanes);

[[gnu::always_inline]] inline double sum(const Lanes& v) {
  return v[0] + v[1];
}
/// Returns the lanes of packet `Packet`.
template <std::size_t Packet, typename V>
[[gnu::always_inline]] inline Lanes lanes_of_packet(const V& v) {
  if constexpr (packets_of<V> == 1) {
    return v;
  } else {
    return __builtin_shufflevector(v, v, 2 * Packet, 2 * Packet + 1);
  }
}
/// to += the lanes of each packet, one packet after the other.
template <typename V>
[[gnu::always_inline]] inline void add_packets(Lanes& to, const V& v) {
  to += lanes_of_packet<0>(v);
  if constexpr (packets_of<V> == 2) to += lanes_of_packet<1>(v);
}
/// Returns a vector of the values at(0), at(1) and so on.
template <typename V, typename At>
[[gnu::always_inline]] inline V gather(const At& at) {
  if constexpr (packets_of<V> == 1) {
    return V{at(0), at(1)};
  } else {
    return V{at(0), at(1), at(2), at(3)};
  }
}
template <typename V>
[[gnu::always_inline]] inline V square_root(const V& v) {
  return gather<V>([&](std::size_t lane) { return std::sqrt(v[lane]); });
}
template <typename V>
[[gnu::always_inline]] inline bool positive(const V& v) {
  bool all = true;
  for (std::size_t lane = 0; lane < lanes_of<V>; ++lane) all &= v[lane] > 0;
  return all;
}

/// Residuals and derivatives of the observations by one camera.
template <typename V>
struct View {
  /// Residual, px. Like all members, it is multiplied by the square root of the robust weight.
  V eu, ev;
  V pu[3], pv[3];  ///< derivatives with respect to the point
  V u[6], v[6];    ///< derivatives with respect to the camera; u[5] and v[4] are zero and not written
};

/// Projections of the points. The depth of a point that is not in front of the camera is 0 or negative.
template <typename V>
struct Projection {
  V x, y, inverse_z, depth;
};
template <typename V>
[[gnu::always_inline]] inline void project(const Camera& camera, const V (&point)[3], Projection<V>& out) {
  const double* r = camera.rotation;
  const V d0 = point[0] - camera.centre[0];
  const V d1 = point[1] - camera.centre[1];
  const V d2 = point[2] - camera.centre[2];
  out.depth = r[6] * d0 + r[7] * d1 + r[8] * d2;
  out.inverse_z = 1.0 / out.depth;
  out.x = (r[0] * d0 + r[1] * d1 + r[2] * d2) * out.inverse_z;
  out.y = (r[3] * d0 + r[4] * d1 + r[5] * d2) * out.inverse_z;
}

/// Square roots of the robust weights.
template <typename V>
[[gnu::always_inline]] inline V root_weights(const V& squared, const Loss& loss) {
  if (loss.bound <= 0) return V{} + 1.0;
  const double bound2 = loss.bound * loss.bound;
  return square_root<V>(bound2 / (bound2 + squared));
}

/// The robust function of squared residuals.
template <typename V>
[[gnu::always_inline]] inline V robust_cost(const V& squared, const Loss& loss) {
  if (loss.bound <= 0) return squared;
  return gather<V>([&](std::size_t lane) { return loss.cost(squared[lane]); });
}

/// Computes residuals and derivatives. The derivatives with respect to the camera are zero in lanes where `counts` is
/// zero.
template <typename V>
[[gnu::always_inline]] inline void view(const Camera& camera, const V& observed_x, const V& observed_y,
                                        const V (&point)[3], const Loss& loss, const V& counts, View<V>& out) {
  Projection<V> p;
  project<V>(camera, point, p);
  const double* r = camera.rotation;
  const V x = p.x;
  const V y = p.y;
  const V eu = camera.fx * x + camera.cx - observed_x;
  const V ev = camera.fy * y + camera.cy - observed_y;
  const V root = root_weights<V>(eu * eu + ev * ev, loss);
  out.eu = eu * root;
  out.ev = ev * root;
  V fu = camera.fx * root;
  V fv = camera.fy * root;
  const V au = fu * p.inverse_z;
  const V av = fv * p.inverse_z;
  for (int k = 0; k < 3; ++k) {
    out.pu[k] = au * (r[k] - x * r[6 + k]);
    out.pv[k] = av * (r[3 + k] - y * r[6 + k]);
  }
  if (!camera.free) return;
  fu *= counts;
  fv *= counts;
  const V xy = x * y;
  out.u[0] = -fu * xy;
  out.u[1] = fu * (1.0 + x * x);
  out.u[2] = -fu * y;
  out.u[4] = -au * counts;
  out.u[3] = -out.u[4] * x;
  out.v[0] = -fv * (1.0 + y * y);
  out.v[1] = fv * xy;
  out.v[2] = fv * x;
  out.v[5] = -av * counts;
  out.v[3] = -out.v[5] * y;
}

/// n0 = m00 u + m01 v, n1 = m10 u + m11 v.
template <typename V>
[[gnu::always_inline]] inline void weigh(const View<V>& b, const V& m00, const V& m01, const V& m10, const V& m11,
                                         V (&n0)[6], V (&n1)[6]) {
  for (int c = 0; c < 4; ++c) {
    n0[c] = m00 * b.u[c] + m01 * b.v[c];
    n1[c] = m10 * b.u[c] + m11 * b.v[c];
  }
  n0[4] = m00 * b.u[4];
  n1[4] = m10 * b.u[4];
  n0[5] = m01 * b.v[5];
  n1[5] = m11 * b.v[5];
}

/// A block of the Schur complement, 6 x 6 row-major in the order of the derivatives. `at` takes indices in the order of
/// a camera's parameters. A diagonal block contains only elements with row <= column in the order of the derivatives.
struct Block {
  Lanes element[36];

  [[nodiscard]] const Lanes& at(std::size_t row, std::size_t column) const {
    constexpr std::size_t places[6] = {0, 1, 2, 4, 5, 3};
    return element[6 * places[row] + places[column]];
  }
};

/// Two neighbouring columns of packet `Packet`.
template <std::size_t Packet>
[[gnu::always_inline]] inline WideLanes two_columns(const WideLanes& first, const WideLanes& second) {
  return __builtin_shufflevector(first, second, 2 * Packet, 2 * Packet + 1, 4 + 2 * Packet, 5 + 2 * Packet);
}
template <std::size_t Packet>
[[gnu::always_inline]] inline WideLanes twice(const WideLanes& v) {
  return __builtin_shufflevector(v, v, 2 * Packet, 2 * Packet + 1, 2 * Packet, 2 * Packet + 1);
}
[[gnu::always_inline]] inline void add_columns(Lanes* to, const WideLanes& value) {
  WideLanes columns;
  std::memcpy(&columns, to, sizeof(columns));
  columns += value;
  std::memcpy(to, &columns, sizeof(columns));
}

/// block += J_a^T (n0; n1) for one of two packets. In a diagonal block only the upper triangle is updated.
template <std::size_t Packet, bool Diagonal>
[[gnu::always_inline]] inline void add_packet_block(const View<WideLanes>& a, const WideLanes (&n0)[6],
                                                    const WideLanes (&n1)[6], Block& block) {
  WideLanes m0[3], m1[3];
  for (std::size_t c = 0; c < 3; ++c) {
    m0[c] = two_columns<Packet>(n0[2 * c], n0[2 * c + 1]);
    m1[c] = two_columns<Packet>(n1[2 * c], n1[2 * c + 1]);
  }
  for (std::size_t r = 0; r < 4; ++r) {
    const WideLanes u = twice<Packet>(a.u[r]);
    const WideLanes v = twice<Packet>(a.v[r]);
    for (std::size_t c = Diagonal ? r / 2 : 0; c < (Diagonal && r == 3 ? 2U : 3U); ++c) {
      add_columns(&block.element[6 * r + 2 * c], u * m0[c] + v * m1[c]);
    }
  }
  const WideLanes u = twice<Packet>(a.u[4]);
  const WideLanes v = twice<Packet>(a.v[5]);
  for (std::size_t c = Diagonal ? 1 : 0; c < 3; ++c) {
    add_columns(&block.element[24 + 2 * c], u * m0[c]);
    add_columns(&block.element[30 + 2 * c], v * m1[c]);
  }
}

/// block += J_a^T (n0; n1).
template <bool Diagonal>
[[gnu::always_inline]] inline void add_block(const View<WideLanes>& a, const WideLanes (&n0)[6],
                                             const WideLanes (&n1)[6], Block& block) {
  add_packet_block<0, Diagonal>(a, n0, n1, block);
  add_packet_block<1, Diagonal>(a, n0, n1, block);
}

template <bool Diagonal>
[[gnu::always_inline]] inline void add_block(const View<Lanes>& a, const Lanes (&n0)[6], const Lanes (&n1)[6],
                                             Block& block) {
  for (std::size_t r = 0; r < 4; ++r) {
    for (std::size_t c = Diagonal ? r : 0; c < (Diagonal && r == 3 ? 4U : 6U); ++c) {
      block.element[6 * r + c] += a.u[r] * n0[c] + a.v[r] * n1[c];
    }
  }
  for (std::size_t c = Diagonal ? 3 : 0; c < 6; ++c) block.element[24 + c] += a.u[4] * n0[c];
  for (std::size_t c = Diagonal ? 3 : 0; c < 6; ++c) block.element[30 + c] += a.v[5] * n1[c];
}

}  // namespace ilp::bundle
