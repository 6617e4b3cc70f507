// Depth errors and estimated sigmas: what was put in comes out.

#include "sim/tools/score/dense_score.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sim/host/colmap.hpp"
#include "sim/tools/score/score_json.hpp"
#include "tests/unit/host/scratch_folder.hpp"
#include "tests/unit/tools/score/strip_scene.hpp"

namespace ilp::score {
namespace {

using test::StripScene;

DenseScore score_of(const StripScene& scene, const std::filesystem::path& truth = {}) {
  DenseOptions options{.truth = truth, .target_overlap = 0.8};
  return score_dense(scene.flight, scene.truth, options);
}

TEST(DenseScore, PerfectProductsHaveNoErrors) {
  const test::ScratchFolder folder;
  world::write_height_grid(StripScene::true_heights(), folder.path());
  const StripScene scene;
  const DenseScore score = score_of(scene, folder.path());
  EXPECT_TRUE(score.remarks.empty());
  // 130 columns of the first pair, 30 of each of the three later ones.
  EXPECT_EQ(score.depth.strip_scale.count, (130U + 3 * 30U) * 120U);
  EXPECT_NEAR(score.depth.flying_height, 100, 1e-9);
  for (const ErrorPercent& errors :
       {score.depth.strip_scale, score.depth.own_scale, score.depth.height, score.height}) {
    EXPECT_GT(errors.count, 0U);
    EXPECT_NEAR(errors.bias, 0, 1e-4);
    EXPECT_NEAR(errors.p95, 0, 1e-4);
  }
  EXPECT_FALSE(score.depth.metric_scale.has_value());
  EXPECT_EQ(score.mask.precision(), 1);
  EXPECT_EQ(score.mask.recall(), 1);
  EXPECT_EQ(score.mask.completeness(), 1);
  EXPECT_EQ(score.mask.double_coded_share(), 0);
  EXPECT_NEAR(score.strips.at(1).aligned.true_from_strip.scale, scene.unit, 1e-9);
}

TEST(DenseScore, InjectedErrorsOfDepthAreRecovered) {
  StripScene scene;
  // 1 % too deep everywhere, and every tenth row 6 % more.
  scene.distort([](std::size_t, int, int row) { return row % 10 == 0 ? 1.07 : 1.01; });
  const DepthScore score = score_of(scene).depth;
  EXPECT_NEAR(score.strip_scale.bias, 1, 1e-3);
  EXPECT_NEAR(score.strip_scale.median, 1, 1e-3);
  EXPECT_NEAR(score.strip_scale.p95, 7, 1e-3);
  EXPECT_NEAR(score.own_scale.median, 0, 1e-3);  // its scale forgives what all have in common
  EXPECT_NEAR(score.own_scale.p95, 100 * (1.07 / 1.01 - 1), 1e-3);
  EXPECT_NEAR(score.height.bias, -1, 1e-3);  // deeper is lower
}

TEST(DenseScore, KnownScaleIsNotEstimatedAgain) {
  StripScene scene({0, 30, 60, 90, 120}, 0.97);  // its metres are 3 % short
  for (std::size_t k = 0; k < scene.x.size(); ++k) scene.keyframe(k).pose->scale_source = ScaleSource::altimeter;
  const test::ScratchFolder folder;
  world::write_height_grid(StripScene::true_heights(), folder.path());
  const DenseScore score = score_of(scene, folder.path());
  const double expected = 100 * (1 / 0.97 - 1);
  EXPECT_NEAR(score.depth.strip_scale.median, 0, 1e-4);
  ASSERT_TRUE(score.depth.metric_scale.has_value());
  EXPECT_NEAR(score.depth.metric_scale->bias, expected, 1e-3);
  EXPECT_NEAR(score.height.median, 0, 1e-4);
  ASSERT_TRUE(score.metric_height.has_value());
  EXPECT_NEAR(score.metric_height->bias, -expected, 1e-3);
  scene.keyframe(2).pose->scale_source = ScaleSource::first_baseline;
  EXPECT_FALSE(score_of(scene).depth.metric_scale.has_value());
}

/// Normal errors of inverse depth, `times` as large as the sigma that the records state.
DepthScore with_noise(double times) {
  StripScene scene;
  const double sigma = 2e-4 * scene.unit;  // 2 % of the inverse depth
  const double disparity_px = 500;
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, times * sigma);
  for (std::size_t k = 0; k < scene.x.size(); ++k) {
    // A part of the estimated sigma comes from the coding.
    DepthRecord& record = *scene.keyframe(k).depth;
    record.disparity_per_inverse_depth_px = disparity_px;
    record.step = std::sqrt(12.0) * 0.6 * sigma;
    record.median_sigma_px = 0.8 * sigma * disparity_px;
    for (float& inverse : scene.keyframe(k).inverse_depth.samples) {
      if (inverse > 0) inverse = static_cast<float>(inverse + normal(random));
    }
  }
  return score_of(scene).depth;
}

TEST(DenseScore, HonestSigmasHoldTheirShares) {
  const DepthScore honest = with_noise(1);
  EXPECT_NEAR(honest.sigma.within_1, 0.683, 0.01);
  EXPECT_NEAR(honest.sigma.within_2, 0.954, 0.005);
  EXPECT_NEAR(honest.sigma.squared, 1, 0.03);
  EXPECT_NEAR(honest.sigma.squared_robust, 1, 0.05);
  EXPECT_NEAR(honest.own_sigma.squared, 1, 0.03);
  const DepthScore boasting = with_noise(2);
  EXPECT_NEAR(boasting.sigma.within_1, 0.383, 0.01);
  EXPECT_NEAR(boasting.sigma.squared, 4, 0.15);
}

TEST(DenseScore, ErrorsOfThePosesAreJudgedByWhatTheStepStates) {
  // Along the baseline, which is 2 % too long: every depth of the pair scales with it.
  StripScene scene;
  const double baseline = 30 / scene.unit;
  for (std::size_t k = 0; k < scene.x.size(); ++k) {
    DepthRecord& record = *scene.keyframe(k).depth;
    record.disparity_per_inverse_depth_px = 500;
    record.step = 1e-9;
    record.median_sigma_px = 1e-6;
    scene.keyframe(k).pose->step_covariance[9] = std::pow(0.02 * baseline, 2);
    scene.keyframe(k).pose->step_covariance[20] = 1e-18;
    for (float& inverse : scene.keyframe(k).inverse_depth.samples) inverse /= 1.03F;
  }
  const DepthScore score = score_of(scene).depth;
  EXPECT_NEAR(score.sigma.within_2, 0, 1e-6);
  EXPECT_NEAR(score.sigma_with_poses.within_1, 0, 1e-6);
  EXPECT_NEAR(score.sigma_with_poses.within_2, 1, 1e-6);
}

TEST(DenseScore, DepthsWithoutStatedSigmaAreNotJudgedByIt) {
  const DepthScore score = score_of(StripScene()).depth;
  EXPECT_EQ(score.sigma.count, 0U);
  EXPECT_TRUE(std::isnan(score.sigma.within_1));
}

TEST(DenseScore, SummaryAndJsonTellWhatIsKnownAndNullForTheRest) {
  StripScene scene;
  scene.distort([](std::size_t, int, int) { return 1.02; });
  const test::ScratchFolder folder;
  const DenseScore score = score_of(scene, folder.path());  // no heights in there
  ASSERT_EQ(score.remarks.size(), 1U);
  EXPECT_TRUE(test::says(score.remarks[0], "height.pgw: cannot be read"));
  const std::map<std::string, double> summary = dense_summary(score);
  EXPECT_EQ(summary.size(), 37U);
  EXPECT_NEAR(summary.at("depth_median_percent"), 2, 1e-3);
  EXPECT_NEAR(summary.at("overlap_true_mean"), 130.0 / 160, 1e-3);
  EXPECT_TRUE(std::isnan(summary.at("height_bias_percent")));
  const auto json = nlohmann::ordered_json::parse(dense_json(score).dump());
  EXPECT_NEAR(json.at("depth").at("strip_scale").at("bias_percent").get<double>(), 2, 1e-3);
  EXPECT_TRUE(json.at("height").at("median_percent").is_null());
  EXPECT_EQ(json.at("keyframes").size(), 5U);
  EXPECT_TRUE(json.at("keyframes").at(4).at("depth").is_null());
  EXPECT_EQ(json.at("overlap").at("achieved").size(), 4U);
}

TEST(DenseScore, TruthIsThatOfTheTrueCamera) {
  StripScene scene;
  const CameraModel camera = *scene.flight.camera;
  scene.flight.camera->fx *= 2;
  scene.flight.camera->fy *= 2;
  EXPECT_NEAR(dense_summary(score_of(scene)).at("overlap_true_mean"), 1 - 60.0 / 160, 1e-3);
  const test::ScratchFolder folder;
  std::filesystem::create_directories(folder / "colmap");
  host::write_colmap_camera(folder / "colmap" / "cameras.txt", camera);
  EXPECT_NEAR(dense_summary(score_of(scene, folder.path())).at("overlap_true_mean"), 1 - 30.0 / 160, 1e-3);
}

TEST(DenseScore, FlightsThatLeftNothingAreScoredAsSuch) {
  const test::TableReference nothing;
  const DenseScore empty = score_dense(intake::Flight(), nothing, {});
  EXPECT_EQ(empty.remarks.size(), 1U);
  for (const auto& [key, value] : dense_summary(empty)) EXPECT_TRUE(std::isnan(value)) << key;
  // A flight whose truth is another's.
  const StripScene scene;
  EXPECT_TRUE(score_dense(scene.flight, nothing, {}).strips.empty());
  // Truth of another size.
  StripScene other;
  for (auto& [name, depth] : other.truth.depths) depth = host::Raster<float>(80, 60, 100);
  EXPECT_EQ(score_of(other).depth.strip_scale.count, 0U);
}

}  // namespace
}  // namespace ilp::score
