#include "sim/host/alignment.hpp"

#include <gtest/gtest.h>

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp::host {
namespace {

struct Cameras {
  std::vector<Vec3> centres;
  std::vector<Mat3> attitudes;
};

// On a straight line.
Cameras straight_track() {
  Cameras cameras;
  for (int i = 0; i < 8; ++i) {
    cameras.centres.emplace_back(10.0 * i, 0, 50);
    cameras.attitudes.push_back(rotation_from_vector(Vec3(3.1, 0.01 * i, 0.02)));
  }
  return cameras;
}

Cameras moved(const Cameras& cameras, const Similarity3& motion) {
  Cameras result;
  for (std::size_t i = 0; i < cameras.centres.size(); ++i) {
    result.centres.push_back(motion * cameras.centres[i]);
    result.attitudes.push_back(cameras.attitudes[i] * motion.rotation.transpose());
  }
  return result;
}

Similarity3 some_motion() {
  return {0.31, rotation_from_vector(Vec3(1.2, -0.4, 2)), Vec3(5, -7, 1)};
}

TEST(Alignment, AttitudesTellTheTurnAboutAStraightTrack) {
  const Similarity3 motion = some_motion();
  const Cameras reference = straight_track(), estimate = moved(reference, motion);
  const auto found = align_cameras(estimate.centres, estimate.attitudes, reference.centres, reference.attitudes, 50);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->scale, 1 / 0.31, 1e-9);
  EXPECT_LT((found->rotation - motion.rotation.transpose()).norm(), 1e-9);
  // A point beside the track.
  const Vec3 beside(30, 20, 10);
  EXPECT_LT((*found * (motion * beside) - beside).norm(), 1e-8);
}

TEST(Alignment, RigidAlignmentKeepsTheScale) {
  Similarity3 motion = some_motion();
  motion.scale = 1;
  const Cameras reference = straight_track();
  Cameras estimate = moved(reference, motion);
  auto found = align_rigid(estimate.centres, reference.centres);
  ASSERT_TRUE(found);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_LT((*found * estimate.centres[i] - reference.centres[i]).norm(), 1e-9);
  }
  // Ten per cent too long: 7 steps of 10, so the ends are off by 3.5, and the middle of the track by nothing.
  motion.scale = 1.1;
  estimate = moved(reference, motion);
  found = align_rigid(estimate.centres, reference.centres);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->scale, 1);
  EXPECT_NEAR((*found * estimate.centres[0] - reference.centres[0]).norm(), 3.5, 1e-9);
  EXPECT_NEAR((*found * estimate.centres[7] - reference.centres[7]).norm(), 3.5, 1e-9);
}

TEST(Alignment, OnePositionOrCoincidentOnesAreRefused) {
  const std::vector<Vec3> one{Vec3(1, 2, 3)}, same{Vec3(1, 2, 3), Vec3(1, 2, 3)};
  const std::vector<Mat3> attitudes(2, Mat3::Identity());
  EXPECT_FALSE(align_rigid(one, one));
  EXPECT_FALSE(align_rigid(same, same));
  EXPECT_FALSE(align_cameras(same, attitudes, same, attitudes, 1));
}

}  // namespace
}  // namespace ilp::host
