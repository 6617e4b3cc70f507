// Steps between two passes over ground whose height is known, one pass lifted by a known step.

#include "sim/ground/model/height_steps.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "fsw/places/strip_tie.hpp"
#include "sim/ground/model/model.hpp"
#include "tests/unit/ground/model/noisy_flight.hpp"

namespace ilp::model {
namespace {

using test::flying_height, test::looking_down, test::NoisyFlight;

/// 1 / depth along the camera's axis of a ground at every pixel; the ground is flat but for `relief` of its height.
host::Raster<float> inverse_depths(const CameraModel& camera, const RigidTransform& pose, double relief) {
  host::Raster<float> inverse(camera.width, camera.height);
  const Vec3 centre = centre_of(pose);
  for (std::int32_t y = 0; y < camera.height; ++y) {
    for (std::int32_t x = 0; x < camera.width; ++x) {
      const Vec2 n = normalised_from_pixel(camera, Vec2(x, y));
      const Vec3 ray = pose.rotation.transpose() * Vec3(n.x(), n.y(), 1);
      double depth = 0;
      for (int i = 0; i < 10; ++i) {
        const Vec3 point = centre + depth * ray;
        depth = (relief * test::ground(point.x(), point.y()) - centre.z()) / ray.z();
      }
      inverse.at(x, y) = static_cast<float>(1 / depth);
    }
  }
  return inverse;
}

class HeightStepsTest : public ::testing::Test {
 protected:
  HeightStepsTest() {
    for (std::size_t i = 0; i < 2; ++i) {
      keyframes_[i].id = static_cast<std::int64_t>(i) + 1;
      keyframes_[i].camera = camera_of_field(320, 240, 1);
      keyframes_[i].inverse_depth = inverse_depths(keyframes_[i].camera, poses_[i], 0);
    }
  }
  /// The second pass stands too high by `lift`; `pass` is the number of its keyframe in the strip of the first.
  HeightSteps steps(double lift, std::int64_t strip = 2, std::int64_t index = 0) {
    std::array<MaskedDepth, 2> depths = {MaskedDepth(keyframes_[0]), MaskedDepth(keyframes_[1])};
    RigidTransform lifted = poses_[1];
    lifted.translation -= lifted.rotation * Vec3(0, 0, lift);
    return measure_height_steps({{1, 0, &keyframes_[0].camera, &depths[0], poses_[0], 1},
                                 {strip, index, &keyframes_[1].camera, &depths[1], lifted, 1}});
  }

  std::array<RigidTransform, 2> poses_ = {looking_down(0, 0, 0, 10), looking_down(1.5, 0.5, 1.5, 7)};
  std::array<intake::Keyframe, 2> keyframes_;
};

TEST_F(HeightStepsTest, ALiftedPassIsFoundOnFlatGround) {
  constexpr double lift = 0.05, mean_distance = 8.5;
  const HeightSteps lifted = steps(lift), at_its_place = steps(0);
  EXPECT_EQ(lifted.pairs, 1U);
  EXPECT_GT(lifted.samples, 50000U);
  EXPECT_NEAR(lifted.median_percent, 100 * lift / mean_distance, 0.005);
  EXPECT_NEAR(lifted.p95_percent, 100 * lift / mean_distance, 0.02) << "it is the same everywhere";
  EXPECT_GT(at_its_place.samples, 50000U);
  EXPECT_LT(at_its_place.p95_percent, 1e-3);
}

TEST_F(HeightStepsTest, KeyframesOfOnePassAreNotCompared) {
  EXPECT_EQ(steps(0.05, 1, keyframes_of_one_pass).samples, 0U);
  EXPECT_GT(steps(0.05, 1, keyframes_of_one_pass + 1).samples, 0U);
}

TEST_F(HeightStepsTest, OnlyWhatBothMasksHoldIsCompared) {
  const std::size_t all = steps(0).samples;
  std::vector<float>& earlier = keyframes_[0].inverse_depth.samples;
  std::fill_n(earlier.begin(), earlier.size() / 2, 0.0F);
  const HeightSteps half = steps(0.05);
  EXPECT_GT(half.samples, all / 10);
  EXPECT_LT(half.samples, 9 * all / 10);
  std::vector<float>& later = keyframes_[1].inverse_depth.samples;
  std::fill(later.begin(), later.end(), 0.0F);
  EXPECT_EQ(steps(0.05).samples, 0U);
}

TEST_F(HeightStepsTest, AJumpOfDepthIsNoSurface) {
  for (std::int32_t y = 0; y < 240; ++y) {
    for (std::int32_t x = y % 2; x < 320; x += 2) keyframes_[0].inverse_depth.at(x, y) *= 0.7F;
  }
  EXPECT_EQ(steps(0).samples, 0U);
}

/// Two lanes that the ground joins by three links, with the depths of the true ground.
struct JoinedLanes : NoisyFlight {
  JoinedLanes() {
    fly_two_lanes();
    link(5, 6);
    link(4, 7);
    link(1, 10);
  }
  JoinedModel measured() {
    JoinedFlight joined = join();
    if (joined.models.size() != 1) return {};
    // Depths are in the unit of the model, which is that of the truth, as decoded products are.
    for (auto& [id, keyframe] : flight_.keyframes)
      keyframe.inverse_depth = inverse_depths(keyframe.camera, truth_[static_cast<std::size_t>(id - 1)], 1);
    state_height_steps(flight_, joined);
    return joined.models[0];
  }
};

TEST(HeightStepsOfModel, ATieThatLiftsAStripIsStatedBeforeAndGoneAfter) {
  JoinedLanes flight;
  TieRecord tie{.id = 2, .to_strip_id = 1};
  const Similarity to_from_this = inverse(flight.second_);
  quaternion_from_rotation(to_from_this.rotation, tie.q_to_from_this);
  std::copy_n(to_from_this.translation.data(), 3, tie.translation);
  tie.translation[2] += 0.05;
  tie.scale = to_from_this.scale;
  flight.flight_.ties.push_back(tie);
  const JoinedModel joined = flight.measured();
  const HeightSteps &before = joined.steps_before, &after = joined.steps_after;
  EXPECT_EQ(before.pairs, 25U) << "each keyframe of a lane shares ground with each of the other";
  EXPECT_EQ(after.pairs, before.pairs);
  EXPECT_NEAR(before.median_percent, 100 * 0.05 / flying_height, 0.03);
  EXPECT_GT(after.samples, 100000U);
  EXPECT_LT(after.median_percent, 0.02);
}

TEST(HeightStepsOfModel, WithoutATieNothingIsKnownBefore) {
  const JoinedModel joined = JoinedLanes().measured();
  EXPECT_EQ(joined.steps_before.samples, 0U);
  EXPECT_GT(joined.steps_after.samples, 100000U);
}

}  // namespace
}  // namespace ilp::model
