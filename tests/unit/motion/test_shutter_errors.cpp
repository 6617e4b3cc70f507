// What errors of a rolling shutter do to the estimated error of a pose, against strips whose first images are moved at
// random.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fsw/motion/shutter_errors.hpp"
#include "fsw/vision/geometry/types.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp {
namespace {

constexpr double turn = 2e-4, depth = 5;

PoseRecord pose_at(double x, double y, double z) {
  PoseRecord pose;
  pose.centre[0] = x;
  pose.centre[1] = y;
  pose.centre[2] = z;
  pose.ground_distance = depth;
  for (const int i : {0, 2, 5, 9, 14, 20}) pose.covariance[i] = 1e-12;
  for (double& sigma : pose.sigma) sigma = 1e-6;
  return pose;
}

TEST(ShutterErrors, TheFirstImagesMoveAndStretchTheWholeTrack) {
  const Vec3 second(1, 0, 0);
  for (const Vec3& place : {Vec3(6, 0, 0), Vec3(12, 5, 0.5), Vec3(-8, 9, 1)}) {
    PoseRecord pose = pose_at(place.x(), place.y(), place.z());
    add_errors(0, {.first = turn, .length = std::sqrt(2.0) * turn / second.norm()}, pose);

    // The strip as it is told: from the first camera, in units of the first baseline.
    std::mt19937 random(5);
    std::normal_distribution<double> moves(0, turn * depth);
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    constexpr int trials = 20000;
    for (int k = 0; k < trials; ++k) {
      Vec3 moved[2];
      for (Vec3& error : moved) error = Vec3(moves(random), moves(random), moves(random));
      const double length = (second + moved[1] - moved[0]).norm() / second.norm();
      const Vec3 error = (place - moved[0]) / length - place;
      scatter += error * error.transpose() / trials;
    }
    // Lower triangle of the centre in the pose's.
    const double stated[6] = {pose.covariance[9],  pose.covariance[13], pose.covariance[14],
                              pose.covariance[18], pose.covariance[19], pose.covariance[20]};
    int at = 0;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j, ++at) {
        // The estimated error takes the first camera's two effects as independent.
        EXPECT_NEAR(stated[at], scatter(i, j), 0.25 * std::sqrt(scatter(i, i) * scatter(j, j))) << place << i << j;
      }
      EXPECT_NEAR(pose.sigma[i], std::sqrt(stated[i == 0 ? 0 : i == 1 ? 2 : 5]), 1e-9);
    }
  }
}

TEST(ShutterErrors, AnImagesOwnErrorTurnsItsCamera) {
  PoseRecord pose = pose_at(3, 0, 0);
  add_errors(turn, {}, pose);
  EXPECT_NEAR(pose.covariance[0], turn * turn, 1e-11);
  EXPECT_NEAR(pose.sigma[2], turn * depth, 1e-8);
}

TEST(ShutterErrors, TheFirstCameraHasNone) {
  PoseRecord pose{.ground_distance = depth};
  add_errors(turn, {turn, turn}, pose);
  for (const double value : pose.covariance) EXPECT_EQ(value, 0);
}

class BaselineErrorsOnRecord : public test::ComponentTest {};

// The storage manager erases the records of old keyframes while their strip goes on.
TEST_F(BaselineErrorsOnRecord, OutliveTheRecordsOfTheFirstKeyframes) {
  StripRecord strip{.id = 1, .first_keyframe_id = 5};
  write(strip);
  CameraRecord camera{.id = 1, .fx = 500, .fy = 500, .readout_s = 0.03};
  for (std::int64_t id = 5; id <= 7; ++id) {
    ShutterRecord shutter{.id = id, .source = MotionSource::frames, .sigma_px_s = 2};
    write(shutter);
    PoseRecord pose = pose_at(2 * static_cast<double>(id - 5), 0, 0);
    pose.id = id;
    pose.strip_id = 1;
    write(pose);
  }
  BaselineErrors errors;
  ASSERT_TRUE(find_baseline_errors(store, camera, read<PoseRecord>(7), errors).ok());
  EXPECT_GT(errors.first, 0);
  EXPECT_NEAR(errors.length, std::sqrt(2.0) * errors.first / 2, 1e-12) << "two images, a baseline of 2";
  const BaselineErrors before = errors;
  test::in_transaction(store, [&] {
    ASSERT_TRUE(store.erase(record_info<ShutterRecord>(), 5).ok());
    ASSERT_TRUE(store.erase(record_info<PoseRecord>(), 5).ok());
  });
  ASSERT_TRUE(find_baseline_errors(store, camera, read<PoseRecord>(7), errors).ok());
  EXPECT_EQ(errors.first, before.first);
  EXPECT_EQ(errors.length, before.length);
}

}  // namespace
}  // namespace ilp
