// Whether steps towards the lens that windows ask for reach the one they were seen through.
#include "fsw/vision/calibration/lens_solution.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "fsw/vision/geometry/camera.hpp"
#include "tests/unit/vision/calibration/posed_window.hpp"

namespace ilp::test {
namespace {

constexpr CameraCheckParams params;
constexpr double focal_sigma = 0.1;

FlightScene scene_of(unsigned seed) {
  FlightScene scene;
  scene.seed = seed;
  scene.keyframes = 6;
  scene.wrong = 0;
  scene.noise_px = 0.1;
  return scene;
}

/// The flight as a camera with another lens would have seen it that is taken for `given`.
void see_through(const CameraModel& lens, const CameraModel& given, SyntheticFlight& flight) {
  for (FlightKeyframe& keyframe : flight.keyframes) {
    for (Corner& corner : keyframe.corners) {
      const Vec2 seen = ideal_from_pixel(given, pixel_from_ideal(lens, Vec2(corner.x, corner.y)));
      corner.x = static_cast<float>(seen.x());
      corner.y = static_cast<float>(seen.y());
    }
  }
}

Intrinsics intrinsics_of(const CameraModel& c) {
  return {c.fx, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2};
}

class LensSolutionTest : public ::testing::Test {
 protected:
  CameraEvidence evidence_of(unsigned seed, const CameraModel& lens, const CameraModel& given) {
    CameraEvidence evidence;
    for (unsigned window = 0; window < 3; ++window) {
      SyntheticFlight flight(scene_of(seed + window));
      see_through(lens, given, flight);
      PosedWindow window_of(flight, given);
      EXPECT_TRUE(window_of.ok());
      IntrinsicsEquations equations;
      EXPECT_TRUE(reduce_to_intrinsics(given, ReductionParams{.error_factor = params.error_factor}, window_of.problem(),
                                       *workspace_, equations, evidence.field)
                      .ok());
      add_window(equations, params, evidence);
    }
    return evidence;
  }

  const CameraModel nominal_ = SyntheticFlight(scene_of(4001)).camera;
  std::unique_ptr<IntrinsicsWorkspace> workspace_ = std::make_unique<IntrinsicsWorkspace>();
};

TEST_F(LensSolutionTest, WithoutEvidenceTheCameraStaysAsItWasGivenWithItsSigmas) {
  const LensPrior prior = prior_of(nominal_, focal_sigma);
  EXPECT_DOUBLE_EQ(prior.sigmas[0], focal_sigma * nominal_.fx);
  const Intrinsics before = intrinsics_of(nominal_);
  const CameraModel moved = corrected(nominal_, {20, 3, -2, 0.01, 0.01, 0.0001, 0});
  for (const CameraModel& now : {nominal_, moved}) {
    const LensStep step = step_towards_lens({}, now, prior, 0);
    EXPECT_FALSE(step.shortened);
    const Intrinsics found = intrinsics_of(step.camera);
    std::size_t at = 0;
    for (std::size_t i = 0; i < intrinsic_count; ++i) {
      EXPECT_NEAR(found[i], before[i], 1e-6 * prior.sigmas[i]) << i;
      EXPECT_NEAR(step.sigmas[i], prior.sigmas[i], 1e-9 * prior.sigmas[i]) << i;
      for (std::size_t j = 0; j <= i; ++j, ++at) {
        const double expected = i == j ? prior.sigmas[i] * prior.sigmas[i] : 0;
        EXPECT_NEAR(step.covariance[at], expected, 1e-9 * prior.sigmas[i] * prior.sigmas[j]) << i << " " << j;
      }
    }
  }
}

TEST_F(LensSolutionTest, StepsReachTheTrueLens) {
  for (unsigned seed = 4101; seed <= 4141; seed += 10) {
    const CameraModel lens = corrected(nominal_, {0, 6, -4, -0.08, 0.01, 0.0004, -0.0003});
    CameraModel given = nominal_;
    given.fx *= 1.05;
    given.fy *= 1.05;
    const LensPrior prior = prior_of(given, focal_sigma);
    CameraModel now = given;
    LensStep step;
    for (int round = 0; round < 12; ++round) {
      const CameraEvidence evidence = evidence_of(seed, lens, now);
      const CameraCheck check = judge(evidence, now, params);
      step = step_towards_lens(evidence, now, prior, check.spread > params.max_spread ? check.spread : 1);
      now = step.camera;
    }
    EXPECT_FALSE(step.shortened) << seed;
    EXPECT_LT(step.length, 0.5) << seed;
    const Intrinsics found = intrinsics_of(now), truth = intrinsics_of(lens);
    for (std::size_t i = 0; i < intrinsic_count; ++i) {
      EXPECT_LT(std::abs(found[i] - truth[i]), 4 * step.sigmas[i]) << seed << " " << i;
    }
    EXPECT_LT(step.sigmas[3], 0.2 * prior.sigmas[3]) << seed;
    EXPECT_LE(step.lens_sigma, step.sigmas[3]) << seed;
  }
}

TEST_F(LensSolutionTest, WindowsThatContradictEachOtherCountLess) {
  const CameraEvidence evidence = evidence_of(4201, nominal_, nominal_);
  const LensPrior prior = prior_of(nominal_, focal_sigma);
  const LensStep agree = step_towards_lens(evidence, nominal_, prior, 1);
  const LensStep contradict = step_towards_lens(evidence, nominal_, prior, 9);
  EXPECT_EQ(step_towards_lens(evidence, nominal_, prior, 0).sigmas, agree.sigmas) << "no better than their errors";
  for (std::size_t i = 0; i < intrinsic_count; ++i) {
    EXPECT_GT(contradict.sigmas[i], agree.sigmas[i]) << i;
    EXPECT_LE(contradict.sigmas[i], 3.001 * agree.sigmas[i]) << i;
    EXPECT_LE(contradict.sigmas[i], 1.001 * prior.sigmas[i]) << i;
  }
  EXPECT_GT(contradict.sigmas[3], 2 * agree.sigmas[3]) << "k1 comes from the images alone";
}

TEST_F(LensSolutionTest, NoStepLeavesTheCameraInvalid) {
  const LensPrior prior = prior_of(nominal_, focal_sigma);
  for (std::size_t i = 0; i < intrinsic_count; ++i) {
    for (const double sign : {-1.0, 1.0}) {
      CameraEvidence evidence;
      evidence.gradient[i] = sign * 1e6;
      CameraModel now = nominal_;
      for (int round = 0; round < 40; ++round) {
        const LensStep step = step_towards_lens(evidence, now, prior, 0);
        ASSERT_TRUE(validate(step.camera).ok()) << i << " " << sign << " round " << round;
        EXPECT_TRUE(step.shortened) << i << " " << sign << " round " << round;
        now = step.camera;
      }
    }
  }
}

}  // namespace
}  // namespace ilp::test
