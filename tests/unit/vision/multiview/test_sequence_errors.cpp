// What a sequence states about its own errors, and what grows along straight strips, against the truth of many strips.
#include <gtest/gtest.h>

#include "fsw/vision/multiview/sequence_covariance.hpp"
#include "sim/tools/score/drift.hpp"
#include "sim/tools/score/pose_score.hpp"
#include "tests/unit/vision/multiview/sequence_run.hpp"

namespace ilp {
namespace {

using test::StripScene;
using test::SyntheticStrip;

score::StripTrack track_of(const SyntheticStrip& strip, const test::Collected& out) {
  score::StripTrack track{.flying_height = 1};
  for (const SequenceCamera& camera : out.cameras) {
    const RigidTransform& truth = strip.keyframes[static_cast<std::size_t>(camera.keyframe_id - 100)].truth;
    score::PoseSample sample;
    sample.keyframe_id = camera.keyframe_id;
    sample.cam_from_world = cam_from_world(camera.pose).rotation;
    sample.centre = vector_of(camera.pose.centre);
    sample.sigma = vector_of(camera.sigma_position);
    sample.true_cam_from_world = truth.rotation;
    sample.true_centre = inverse(truth).translation;
    track.samples.push_back(sample);
  }
  return track;
}

struct Scores {
  score::SigmaScore of_matches;  ///< made-up matches have no errors in common: the factor for these is left out
  score::SigmaScore stated;
};

Scores scores_of(StripScene scene, unsigned strips) {
  SequenceParams params;
  const double factor = params.error_factor;
  params.error_factor = 1;
  Scores all;
  for (scene.seed = 1; scene.seed <= strips; ++scene.seed) {
    const SyntheticStrip strip(scene);
    const test::Collected out = test::run(strip, params);
    EXPECT_EQ(out.cameras.size(), strip.keyframes.size()) << "seed " << scene.seed;
    score::StripTrack track = track_of(strip, out);
    all.of_matches.add(score::score_sigmas(track));
    for (score::PoseSample& sample : track.samples) sample.sigma *= factor;
    all.stated.add(score::score_sigmas(track));
  }
  EXPECT_EQ(all.of_matches.components, strips * 3U * static_cast<unsigned>(scene.keyframes - 2));
  std::printf("%.3f of the errors within one sigma, %.3f within two, normalised error squared %.2f\n",
              all.of_matches.share_within_one(), all.of_matches.share_within_two(),
              all.of_matches.normalised_error_squared());
  return all;
}

/// Errors of one strip hang together: a hundred strips would be needed for the exact shares.
void expect_honest(const Scores& scores) {
  const score::SigmaScore& score = scores.of_matches;
  EXPECT_GT(score.share_within_one(), 0.5);
  EXPECT_LT(score.share_within_one(), 0.85);
  EXPECT_GT(score.share_within_two(), 0.86);
  EXPECT_GT(score.normalised_error_squared(), 0.6);
  EXPECT_LT(score.normalised_error_squared(), 1.8);
  EXPECT_GT(scores.stated.share_within_two(), 0.97);
}

TEST(SequenceErrors, AreCoveredAlongStripsOverAPlane) {
  expect_honest(scores_of({.keyframes = 20, .relief = 0, .tilt = 0, .wrong = 0}, 12));
}
TEST(SequenceErrors, AreCoveredAlongStripsOverReliefUnderASwing) {
  expect_honest(scores_of({.keyframes = 20, .wrong = 0}, 12));
}
TEST(SequenceErrors, AreCoveredWhereCornersWalkOffTheirPoints) {
  expect_honest(scores_of({.keyframes = 20, .relief = 0, .tilt = 0, .noise_px = 0.05, .wrong = 0, .walk_px = 0.1}, 12));
}
TEST(SequenceErrors, AreCoveredWhereImagesHardlyOverlap) {
  expect_honest(scores_of({.keyframes = 12, .overlap = 0.6, .noise_px = 0.2, .wrong = 0}, 12));
}

/// Error of a pose in the strip's own world, in the order of SequenceCamera::covariance.
Eigen::Matrix<double, 6, 1> pose_error(const SyntheticStrip& strip, const test::Collected& out, std::size_t k) {
  const auto truth = [&](std::size_t i) { return strip.keyframes[i].truth; };
  const auto centre = [&](std::size_t i) { return vector_of(out.cameras[i].pose.centre); };
  const Vec3 true_origin = inverse(truth(0)).translation;
  const Mat3 turn = cam_from_world(out.cameras[0].pose).rotation.transpose() * truth(0).rotation;
  const double scale = (centre(1) - centre(0)).norm() / (inverse(truth(1)).translation - true_origin).norm();
  Eigen::Matrix<double, 6, 1> error;
  error.head<3>() = vector_from_rotation(cam_from_world(out.cameras[k].pose).rotation *
                                         (truth(k).rotation * turn.transpose()).transpose());
  error.tail<3>() = centre(k) - centre(0) - scale * (turn * (inverse(truth(k)).translation - true_origin));
  return error;
}

TEST(SequenceErrors, AttitudeAndCentreErrTogetherAsTheCovarianceSays) {
  SequenceParams params{.error_factor = 1};
  double sum = 0, attitude_sum = 0, apart_sum = 0;
  int count = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const SyntheticStrip strip({.keyframes = 20, .wrong = 0, .seed = seed});
    const test::Collected out = test::run(strip, params);
    ASSERT_EQ(out.cameras.size(), 20U);
    // The second camera's distance is the gauge: its covariance has no inverse.
    for (std::size_t k = 2; k < 20; ++k) {
      const SequenceCamera& camera = out.cameras[k];
      Eigen::Matrix<double, 6, 6> covariance;
      for (int row = 0, i = 0; row < 6; ++row) {
        for (int column = 0; column <= row; ++column, ++i) {
          covariance(row, column) = covariance(column, row) = camera.covariance[i];
        }
      }
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(std::sqrt(covariance(3 + axis, 3 + axis)), camera.sigma_position[axis],
                    1e-9 * camera.sigma_position[axis]);
      }
      const Eigen::Matrix<double, 6, 1> error = pose_error(strip, out, k);
      sum += error.dot(covariance.ldlt().solve(error)) / 6;
      attitude_sum += error.head<3>().dot(covariance.topLeftCorner<3, 3>().ldlt().solve(error.head<3>())) / 3;
      const Eigen::Matrix<double, 6, 6> uncorrelated = covariance.diagonal().asDiagonal();
      apart_sum += std::log(uncorrelated.determinant() / covariance.determinant());
      ++count;
    }
  }
  std::printf("normalised error squared of the pose %.2f, of its attitude %.2f\n", sum / count, attitude_sum / count);
  EXPECT_GT(sum / count, 0.6);
  EXPECT_LT(sum / count, 1.8);
  EXPECT_GT(attitude_sum / count, 0.6);
  EXPECT_LT(attitude_sum / count, 1.8);
  EXPECT_GT(apart_sum / count, 2) << "attitude and place hang together: sigmas alone would not say how";
}

TEST(SequenceErrors, GrowAlongTheStripAndVanishInItsGauge) {
  const SyntheticStrip strip({.keyframes = 30});
  const test::Collected out = test::run(strip);
  ASSERT_EQ(out.cameras.size(), 30U);
  const auto sigma = [&](std::size_t k) { return vector_of(out.cameras[k].sigma_position).norm(); };
  EXPECT_EQ(sigma(0), 0);
  EXPECT_GT(sigma(1), 0) << "its direction is measured";
  for (std::size_t k = 6; k < 30; k += 6) EXPECT_GT(sigma(k), sigma(k - 6)) << k;
}

TEST(SequenceErrors, LongStraightStripsOverAPlaneNeitherDriftNorBend) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const SyntheticStrip strip({.keyframes = 60, .relief = 0, .tilt = 0.002, .noise_px = 0.15, .seed = seed});
    const test::Collected out = test::run(strip);
    ASSERT_EQ(out.cameras.size(), 60U);
    const score::StripTrack track = track_of(strip, out);
    const auto drift = score::measure_drift(track);
    const auto bow = score::measure_bow(track);
    ASSERT_TRUE(drift && bow);
    std::printf("drift %.3f %% of the distance, bow %.3f %% of the height\n", drift->percent, bow->percent);
    EXPECT_LT(drift->percent, 0.3);
    EXPECT_LT(std::abs(bow->percent), 0.5);
  }
}

/// Two cameras that look straight down, a baseline of 1 apart, over ground at 5.
struct LevelPair {
  LevelPair() {
    begin_covariance(strip);
    strip.known = 3;
    step.index = 1;
    step.previous = {Mat3::Identity(), Vec3::Zero()};
    step.camera = {Mat3::Identity(), Vec3(-1, 0, 0)};
  }
  /// By an error of one px of this intrinsic alone.
  [[nodiscard]] double depth_error(Intrinsic intrinsic) const {
    IntrinsicsCovariance lens = IntrinsicsCovariance::Zero();
    lens(static_cast<int>(intrinsic), static_cast<int>(intrinsic)) = 1;
    return depth_error_of_lens(strip, step, {640, 480, 500, 500, 319.5, 239.5, 0, 0, 0, 0}, lens, 5);
  }

  StripCovariance strip;
  StripStep step;
};

TEST(DepthErrorOfLens, ALongerFocalLengthMakesLevelGroundDeeperInProportion) {
  EXPECT_NEAR(LevelPair{}.depth_error(Intrinsic::focal_length), 1.0 / 500, 1e-12);
}

TEST(DepthErrorOfLens, APrincipalPointMovesBothRaysOfALevelPairAlike) {
  EXPECT_NEAR(LevelPair{}.depth_error(Intrinsic::centre_x), 0, 1e-12);
}

TEST(DepthErrorOfLens, ABaselineThatShrinksAsTheFocalLengthGrowsLeavesTheDepth) {
  LevelPair pair;
  // Derivative of the second centre's x by the focal length.
  pair.strip.by_intrinsics[(6 + 3) * intrinsic_count + static_cast<std::size_t>(Intrinsic::focal_length)] = -1.0 / 500;
  EXPECT_NEAR(pair.depth_error(Intrinsic::focal_length), 0, 1e-12);
}

TEST(DepthErrorOfLens, OfCamerasThatAreNotKnownIsNotKnown) {
  LevelPair pair;
  pair.strip.known = 1;
  EXPECT_EQ(pair.depth_error(Intrinsic::focal_length), 0);
}

}  // namespace
}  // namespace ilp
