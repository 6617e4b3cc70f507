// Rotations and motions against their axioms and hand-made cases.
#include "fsw/vision/geometry/rigid_transform.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"

namespace ilp {
namespace {

Vec3 random_vector(Rng& rng, double reach) {
  return reach * Vec3(2 * rng.uniform() - 1, 2 * rng.uniform() - 1, 2 * rng.uniform() - 1);
}

TEST(Rotation, QuarterTurnAboutZ) {
  const Mat3 r = rotation_from_vector(Vec3(0, 0, pi / 2));
  EXPECT_LT((r * Vec3(1, 0, 0) - Vec3(0, 1, 0)).norm(), 1e-15);
  EXPECT_LT((r * Vec3(0, 1, 0) - Vec3(-1, 0, 0)).norm(), 1e-15);
  EXPECT_NEAR(rotation_angle(r), pi / 2, 1e-15);
}

TEST(Rotation, VectorAndMatrixAreInverse) {
  Rng rng(1);
  for (int i = 0; i < 2000; ++i) {
    const double length = i % 4 == 0 ? 1e-9 : (i % 4 == 1 ? 1e-4 : 3.1);
    const Vec3 v = random_vector(rng, 1).normalized() * length;
    const Mat3 r = rotation_from_vector(v);
    EXPECT_LT((r * r.transpose() - Mat3::Identity()).norm(), 1e-14);
    EXPECT_NEAR(r.determinant(), 1, 1e-14);
    EXPECT_LT((vector_from_rotation(r) - v).norm(), 1e-12 * (1 + length));
  }
  EXPECT_EQ(vector_from_rotation(Mat3::Identity()), Vec3(0, 0, 0));
}

TEST(Rotation, HalfTurnsKeepTheirAxis) {
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(0.6, 0, 0.8)}) {
    const Mat3 r = 2 * axis * axis.transpose() - Mat3::Identity();
    const Vec3 v = vector_from_rotation(r);
    EXPECT_NEAR(v.norm(), pi, 1e-12);
    EXPECT_NEAR(std::fabs(v.normalized().dot(axis)), 1, 1e-12);
  }
}

TEST(Rotation, QuaternionsAreUnitNonNegativeAndInverse) {
  Rng rng(2);
  for (int i = 0; i < 2000; ++i) {
    const Mat3 r = rotation_from_vector(random_vector(rng, 3));
    double q[4];
    quaternion_from_rotation(r, q);
    EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, 1e-14);
    EXPECT_GE(q[0], 0);
    EXPECT_LT((rotation_from_quaternion(q) - r).norm(), 1e-13);
  }
  const double quarter_about_x[4] = {std::sqrt(0.5), std::sqrt(0.5), 0, 0};
  EXPECT_LT((rotation_from_quaternion(quarter_about_x) * Vec3(0, 1, 0) - Vec3(0, 0, 1)).norm(), 1e-15);
}

TEST(Transform, ComposeAndInverseReadLikeAlgebra) {
  Rng rng(3);
  for (int i = 0; i < 100; ++i) {
    const RigidTransform b_from_a{rotation_from_vector(random_vector(rng, 2)), random_vector(rng, 5)};
    const RigidTransform c_from_b{rotation_from_vector(random_vector(rng, 2)), random_vector(rng, 5)};
    const Vec3 x = random_vector(rng, 4);
    EXPECT_LT((compose(c_from_b, b_from_a) * x - c_from_b * (b_from_a * x)).norm(), 1e-13);
    EXPECT_LT((inverse(b_from_a) * (b_from_a * x) - x).norm(), 1e-13);
  }
}

TEST(Transform, PoseHoldsTheCameraCentre) {
  Rng rng(4);
  for (int i = 0; i < 100; ++i) {
    const RigidTransform cam{rotation_from_vector(random_vector(rng, 2)), random_vector(rng, 5)};
    const Pose pose = pose_from(cam);
    const Vec3 centre(pose.centre[0], pose.centre[1], pose.centre[2]);
    EXPECT_LT((cam * centre).norm(), 1e-13);  // the centre is the origin of the camera's frame
    const RigidTransform again = cam_from_world(pose);
    EXPECT_LT((again.rotation - cam.rotation).norm(), 1e-13);
    EXPECT_LT((again.translation - cam.translation).norm(), 1e-12);
  }
}

TEST(CrossMatrix, IsTheCrossProduct) {
  const Vec3 a(1, -2, 3);
  const Vec3 b(0.5, 4, -1);
  EXPECT_LT((cross_matrix(a) * b - a.cross(b)).norm(), 1e-15);
}

}  // namespace
}  // namespace ilp
