#include "fsw/vision/twoview/solvers/homography.hpp"

#include <Eigen/LU>
#include <cmath>

#include "fsw/vision/twoview/solvers/singular_values.hpp"

namespace ilp {
namespace {

double triangle(const Vec3& p, const Vec3& q, const Vec3& r) {
  return p.dot(q.cross(r));
}

/// The matrix that maps the projective frame (1,0,0), (0,1,0), (0,0,1), (1,1,1) to four points.
bool frame_to_points(const Vec3 (&p)[4], Mat3& m) {
  Mat3 columns;
  columns << p[0], p[1], p[2];
  const double det = triangle(p[0], p[1], p[2]);
  if (!(std::fabs(det) > 1e-8)) return false;
  const Vec3 weights(triangle(p[3], p[1], p[2]) / det, triangle(p[0], p[3], p[2]) / det,
                     triangle(p[0], p[1], p[3]) / det);
  m = columns * weights.asDiagonal();
  return weights.cwiseAbs().minCoeff() > 1e-8;
}

}  // namespace

bool homography_from_four(const NormalisedPairs& pairs, const std::uint16_t sample[4], Mat3& homography) {
  Vec3 a[4];
  Vec3 b[4];
  for (int i = 0; i < 4; ++i) {
    a[i] = pairs.exact[sample[i]].ray_a();
    b[i] = pairs.exact[sample[i]].ray_b();
  }
  // Every triangle keeps its orientation when all points are in front of both cameras.
  for (int i = 0; i < 4; ++i) {
    const int j = (i + 1) % 4;
    const int k = (i + 2) % 4;
    if (!(triangle(a[i], a[j], a[k]) * triangle(b[i], b[j], b[k]) > 0)) return false;
  }
  Mat3 frame_to_a;
  Mat3 frame_to_b;
  if (!frame_to_points(a, frame_to_a) || !frame_to_points(b, frame_to_b)) return false;
  homography = frame_to_b * frame_to_a.inverse();
  homography /= homography.norm();
  // Positive depths: H x_a is a positive multiple of x_b.
  if ((homography * a[0]).z() < 0) homography = -homography;
  return homography.allFinite();
}

std::size_t decompose_homography(const Mat3& homography, PlaneMotion motions[4]) {
  SingularValues svd;
  if (!singular_values(homography, svd)) return 0;
  // Scaled to middle singular value 1 and positive determinant, H = R + t n^T / d.
  const double middle = svd.values[1];
  if (!(middle > 0) || svd.values[2] == 0) return 0;
  const Mat3 h = homography * ((svd.values[2] < 0 ? -1 : 1) / middle);
  const double s1 = svd.values[0] / middle;
  const double s3 = std::fabs(svd.values[2]) / middle;
  const double spread = s1 * s1 - s3 * s3;
  if (!(spread > 1e-12)) return 0;
  const double c1 = std::sqrt(std::fmax(0.0, 1 - s3 * s3) / spread);
  const double c3 = std::sqrt(std::fmax(0.0, s1 * s1 - 1) / spread);
  const Vec3 v1 = svd.v.col(0);
  const Vec3 v2 = svd.v.col(1);
  const Vec3 v3 = svd.v.col(2);
  for (std::size_t i = 0; i < 2; ++i) {
    // A direction in the plane through the origin that H maps without a change of lengths.
    const Vec3 u = c1 * v1 + (i == 0 ? c3 : -c3) * v3;
    Mat3 before;
    before << v2, u, v2.cross(u);
    Mat3 after;
    const Vec3 hv = h * v2;
    const Vec3 hu = h * u;
    after << hv, hu, hv.cross(hu);
    const Mat3 rotation = after * before.transpose();
    const Vec3 normal = v2.cross(u);
    const Vec3 t = (h - rotation) * normal;
    const double length = t.norm();
    if (!(length > 1e-9) || !rotation.allFinite()) return 0;
    motions[2 * i] = {{rotation, t / length}, length * normal};
    motions[2 * i + 1] = {{rotation, -t / length}, -length * normal};
  }
  return 4;
}

}  // namespace ilp
