// Whether steps towards the lens that windows ask for reach the one they were seen through.
#include "fsw/vision/calibration/lens_solution.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <random>

#include "fsw/vision/geometry/camera.hpp"
#include "tests/support/middle_pixel.hpp"
#include "tests/unit/vision/calibration/posed_window.hpp"

namespace ilp::test {
namespace {

constexpr double focal_sigma = 0.1;

FlightScene scene_of(unsigned seed) {
  FlightScene scene{.seed = seed, .keyframes = 6, .noise_px = 0.1, .wrong = 0};
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

CameraUnknowns unknowns_of(const CameraModel& c) {
  return {c.fx, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.readout_s};
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
      EXPECT_TRUE(
          reduce_to_intrinsics(given, ReductionParams{}, window_of.problem(), *workspace_, equations, evidence.field)
              .ok());
      add_window(equations, evidence);
    }
    return evidence;
  }

  const CameraModel nominal_ = SyntheticFlight(scene_of(4001)).camera;
  std::unique_ptr<IntrinsicsWorkspace> workspace_ = std::make_unique<IntrinsicsWorkspace>();
};

TEST_F(LensSolutionTest, WithoutEvidenceTheCameraStaysAsItWasGivenWithItsSigmas) {
  const LensPrior prior = prior_of(nominal_, {.focal_sigma = focal_sigma});
  EXPECT_DOUBLE_EQ(prior.sigmas[0], focal_sigma * nominal_.fx);
  const CameraUnknowns before = unknowns_of(nominal_);
  const CameraModel moved = corrected(nominal_, {20, 3, -2, 0.01, 0.01, 0.0001, 0});
  for (const CameraModel& now : {nominal_, moved}) {
    const LensStep step = step_towards_lens({}, now, prior, 0);
    EXPECT_FALSE(step.shortened);
    const CameraUnknowns found = unknowns_of(step.camera);
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
    const LensPrior prior = prior_of(given, {.focal_sigma = focal_sigma});
    CameraModel now = given;
    LensStep step;
    for (int round = 0; round < 12; ++round) {
      const CameraEvidence evidence = evidence_of(seed, lens, now);
      const CameraCheck check = judge(evidence, now);
      step = step_towards_lens(evidence, now, prior, check.spread > max_camera_spread ? check.spread : 1);
      now = step.camera;
    }
    EXPECT_FALSE(step.shortened) << seed;
    EXPECT_LT(step.length, 0.5) << seed;
    const CameraUnknowns found = unknowns_of(now), truth = unknowns_of(lens);
    for (std::size_t i = 0; i < intrinsic_count; ++i) {
      EXPECT_LT(std::abs(found[i] - truth[i]), 4 * step.sigmas[i]) << seed << " " << i;
    }
    EXPECT_LT(step.sigmas[3], 0.2 * prior.sigmas[3]) << seed;
    EXPECT_LE(step.lens_sigma, step.sigmas[3]) << seed;
  }
}

/// As a rolling shutter reads it from a camera that turns: a swing, seen over a plane.
ImageMotion motion_of(unsigned seed, std::size_t view) {
  const double phase = 1.7 * static_cast<double>(view) + seed;
  const double about_x = 0.12 * std::sin(phase), about_y = 0.1 * std::cos(1.3 * phase), along = 0.05;
  return {
      {0, 0.02 * std::sin(2 * phase), about_y + along, -0.02 * std::sin(2 * phase), 0, -about_x, -about_y, about_x}};
}

/// All of its flights have one camera.
FlightScene centred_scene_of(unsigned seed) {
  FlightScene scene = scene_of(seed);
  scene.centre_offset_px = 0;
  return scene;
}

/// What is taken for the motion of a view is off by this much (one sigma) along x and y, px/s, and said to be off by
/// `sigma`.
struct MotionError {
  double error = 0, sigma = 0;
};

/// Evidence of windows that `lens` saw with its readout time. Their rows were brought to the middle one by `given`,
/// and count as `now` would do it.
CameraEvidence evidence_of_rows(unsigned seed, const CameraModel& lens, const CameraModel& given,
                                const CameraModel& now, IntrinsicsWorkspace& workspace, const MotionError& off = {}) {
  CameraEvidence evidence;
  for (unsigned window = 0; window < 3; ++window) {
    SyntheticFlight flight(centred_scene_of(seed + window));
    std::mt19937 random(seed + window);
    std::normal_distribution<double> normal(0, 1);
    WindowMotion motion{.readout_s = given.readout_s, .readout_open = true};
    for (std::size_t view = 0; view < flight.keyframes.size(); ++view) {
      const ImageMotion true_motion = motion_of(seed + window, view);
      motion.of_view[view] = true_motion;
      motion.of_view[view].m[2] += normal(random) * off.error / lens.fx;
      motion.of_view[view].m[5] += normal(random) * off.error / lens.fy;
      motion.sigma_px_s[view] = off.sigma;
      for (Corner& corner : flight.keyframes[view].corners) {
        const Vec2 seen = seen_pixel(lens, true_motion, pixel_from_ideal(lens, Vec2(corner.x, corner.y)));
        const Vec2 ideal = ideal_from_pixel(now, test::middle_pixel(given, motion.of_view[view], seen));
        corner.x = static_cast<float>(ideal.x());
        corner.y = static_cast<float>(ideal.y());
      }
    }
    PosedWindow window_of(flight, now);
    EXPECT_TRUE(window_of.ok());
    IntrinsicsEquations equations;
    const ReductionParams reduction{.steps = 5, .motion = &motion};
    EXPECT_TRUE(reduce_to_intrinsics(now, reduction, window_of.problem(), workspace, equations, evidence.field).ok());
    add_window(equations, evidence);
  }
  return evidence;
}

TEST_F(LensSolutionTest, StepsReachTheTrueReadoutTime) {
  const CameraModel ideal = SyntheticFlight(centred_scene_of(4301)).camera;
  for (const unsigned seed : {4301U, 4311U}) {
    for (const double truth : {0.03, -0.02}) {
      for (const double brought_with : {0.0, 0.8}) {
        for (const bool lens_known : {true, false}) {
          CameraModel lens = corrected(ideal, {0, 0, 0, -0.08, 0.01});
          lens.readout_s = truth;
          CameraModel given = lens;
          given.readout_s = brought_with * truth;
          if (!lens_known) given.k1 += 0.01;
          const LensPrior prior =
              prior_of(given, {.focal_sigma = focal_sigma, .lens = lens_known, .readout_sigma_s = 0.05});
          CameraModel now = given;
          LensStep step;
          for (int round = 0; round < 4; ++round) {
            step = step_towards_lens(evidence_of_rows(seed, lens, given, now, *workspace_), now, prior, 1);
            now = step.camera;
          }
          EXPECT_LT(step.sigmas[readout_unknown], 0.001) << seed << " " << truth;
          // Rows of an image that was not brought to the middle one move further than to first order.
          const double of_second_order = 0.03 * std::abs(truth - given.readout_s);
          EXPECT_NEAR(now.readout_s, truth, 4 * step.sigmas[readout_unknown] + of_second_order)
              << seed << " " << brought_with << " " << lens_known;
          if (lens_known) {
            EXPECT_NEAR(now.fx, lens.fx, 1e-3 * lens.fx);
          } else {
            EXPECT_NEAR(now.k1, lens.k1, 4 * step.sigmas[3]);
          }
        }
      }
    }
  }
}

TEST_F(LensSolutionTest, AnErrorOfTheMotionIsNoErrorOfTheLens) {
  CameraModel lens = corrected(SyntheticFlight(centred_scene_of(4501)).camera, {0, 0, 0, -0.08, 0.01});
  lens.readout_s = 0.03;
  for (unsigned seed = 4501; seed <= 4531; seed += 10) {
    const MotionError reported{.error = 20, .sigma = 20}, untold{.error = 20};
    const CameraCheck fits = judge(evidence_of_rows(seed, lens, lens, lens, *workspace_, reported), lens);
    EXPECT_EQ(fits.verdict, CameraCheckVerdict::fits) << seed << " " << fits.statistic << " " << fits.spread;
    const CameraCheck accused = judge(evidence_of_rows(seed, lens, lens, lens, *workspace_, untold), lens);
    EXPECT_NE(accused.verdict, CameraCheckVerdict::fits) << seed;
    CameraModel wrong = lens;
    wrong.k1 += 0.03;
    const CameraCheck noticed = judge(evidence_of_rows(seed, lens, wrong, wrong, *workspace_, reported), wrong);
    EXPECT_EQ(noticed.verdict, CameraCheckVerdict::contradicts) << seed << " " << noticed.statistic;
  }
}

TEST_F(LensSolutionTest, WithoutMotionNothingIsAskedOfTheReadoutTime) {
  const CameraEvidence evidence = evidence_of(4401, nominal_, nominal_);
  const LensStep step = step_towards_lens(evidence, nominal_,
                                          prior_of(nominal_, {.focal_sigma = focal_sigma, .readout_sigma_s = 0.02}), 1);
  EXPECT_NEAR(step.sigmas[readout_unknown], 0.02, 1e-4);
  EXPECT_NEAR(step.camera.readout_s, 0, 1e-6);
}

/// What the vehicle measures exactly of a flight over level ground at height 0.
struct MeasuredByVehicle {
  MeasuredPlaces places;
  MeasuredHeights heights;

  explicit MeasuredByVehicle(const SyntheticFlight& flight) {
    for (std::size_t i = 0; i < flight.keyframes.size(); ++i) {
      const world::CameraState& truth = flight.keyframes[i].truth;
      const auto view = static_cast<std::uint16_t>(i);
      const Vec3& c = truth.centre;
      (void)places.push_back({view, {c.x(), c.y(), c.z()}, {0.02, 0.02, 0.02}});
      const Vec3 up = truth.rotation.col(2);
      (void)heights.push_back({view, c.z(), 0.02, {up.x(), up.y(), up.z()}});
    }
  }
};

/// A wrong derivative by poses, points or camera would lead past it, and further steps would hide that.
TEST_F(LensSolutionTest, HeightsBesidePlacesLeadToTheFocalLengthInOneStep) {
  for (const unsigned seed : {4601U, 4602U, 4603U}) {
    for (const double error : {-0.01, 0.01}) {
      FlightScene scene = scene_of(seed);
      scene.world = "flat";
      scene.line = true;
      scene.noise_px = 0.02;
      SyntheticFlight flight(scene);
      const CameraModel& lens = flight.camera;
      CameraModel given = lens;
      given.fx *= 1 + error;
      given.fy *= 1 + error;
      see_through(lens, given, flight);
      PosedWindow window(flight, given);
      ASSERT_TRUE(window.ok());
      const MeasuredByVehicle measured(flight);
      CameraEvidence evidence;
      IntrinsicsEquations equations;
      const ReductionParams reduction{.steps = 5, .places = &measured.places, .heights = &measured.heights};
      ASSERT_TRUE(
          reduce_to_intrinsics(given, reduction, window.problem(), *workspace_, equations, evidence.field).ok());
      add_window(equations, evidence);
      const LensStep step = step_towards_lens(evidence, given, prior_of(given, {.focal_sigma = focal_sigma}), 1);
      EXPECT_LT(step.sigmas[0], 0.004 * lens.fx) << seed << " " << error;
      EXPECT_NEAR(step.camera.fx, lens.fx, 0.1 * std::abs(error) * lens.fx) << seed << " " << error;
    }
  }
}

TEST_F(LensSolutionTest, WindowsThatContradictEachOtherCountLess) {
  const CameraEvidence evidence = evidence_of(4201, nominal_, nominal_);
  const LensPrior prior = prior_of(nominal_, {.focal_sigma = focal_sigma});
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

TEST_F(LensSolutionTest, EvidenceThatIsNoNumberLeavesTheCameraWithItsErrors) {
  const LensPrior prior = prior_of(nominal_, {.focal_sigma = focal_sigma, .readout_sigma_s = 0.05});
  CameraEvidence evidence;
  evidence.information[0] = std::numeric_limits<double>::quiet_NaN();
  const LensStep step = step_towards_lens(evidence, nominal_, prior, 1);
  EXPECT_EQ(unknowns_of(step.camera), unknowns_of(nominal_));
  EXPECT_EQ(step.sigmas, prior.sigmas);
  EXPECT_DOUBLE_EQ(step.covariance.front(), prior.sigmas[0] * prior.sigmas[0]);
  EXPECT_DOUBLE_EQ(step.covariance.back(), 0.05 * 0.05);
}

TEST_F(LensSolutionTest, NoStepLeavesTheCameraInvalid) {
  const LensPrior prior = prior_of(nominal_, {.focal_sigma = focal_sigma, .readout_sigma_s = 0.05});
  for (std::size_t i = 0; i < camera_unknowns; ++i) {
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
