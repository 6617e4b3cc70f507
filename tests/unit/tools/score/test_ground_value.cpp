// What the ground holds of a made-up flight: every share is counted by hand.

#include "sim/tools/score/ground_value.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sim/host/image_io.hpp"
#include "tests/unit/host/scratch_folder.hpp"
#include "tests/unit/tools/score/strip_scene.hpp"

namespace ilp::score {
namespace {

using test::StripScene;
constexpr float none = std::numeric_limits<float>::quiet_NaN();

TEST(GroundValue, CoverageAndKnownShareAreOfAllGroundThatWasSeen) {
  world::HeightGrid truth{0, 0, 1, host::Raster<float>(10, 10, 0)};
  for (int i = 0; i < 10; ++i) truth.height_m.at(i, 9) = std::numeric_limits<float>::infinity();
  host::Raster<float> first(10, 10, none), second(10, 10, none);
  for (int i = 0; i < 10; ++i) {
    first.at(i, 0) = 0.09F;   // of 100 m: right within 0.1 %
    first.at(i, 1) = -0.11F;  // not quite
    second.at(i, 1) = 0;      // the first strip stands
    second.at(i, 2) = 0.15F;  // of 200 m: right
    second.at(i, 9) = 0;      // unknown
  }
  const GroundValue value = score_ground(truth, {{&first, 100}, {&second, 200}});
  EXPECT_EQ(value.cells, 90U);
  EXPECT_DOUBLE_EQ(value.coverage(), 30.0 / 90);
  EXPECT_DOUBLE_EQ(value.known_share(), 20.0 / 90);
  EXPECT_TRUE(std::isnan(value.feature_share()));
}

TEST(GroundValue, GroundWithoutHeightIsNeverRight) {
  world::HeightGrid truth{0, 0, 1, host::Raster<float>(10, 10, 0)};
  host::Raster<float> map(10, 10, none);
  for (int i = 0; i < 49; ++i)
    map.samples[static_cast<std::size_t>(i)] = 0.01F * static_cast<float>(i % 2 == 0 ? i : -i);
  EXPECT_TRUE(std::isnan(score_ground(truth, {{&map, 100}}).half_percent)) << "less than half has come down";
  map.samples[70] = -0.7F;
  map.samples[71] = 0.9F;
  EXPECT_NEAR(score_ground(truth, {{&map, 100}}).half_percent, 0.7, 1e-6) << "the fiftieth of a hundred cells";
}

TEST(GroundValue, ErrorsOfTheGroundsShapeAreFreeOfWhatBendsTheWholeMap) {
  world::HeightGrid truth{0, 0, 1, host::Raster<float>(200, 200, 0)};
  host::Raster<float> bent(200, 200, none), rough(200, 200, none);
  for (int j = 20; j < 200; ++j) {
    for (int i = 0; i < 200; ++i) {
      bent.at(i, j) = 5.0F + 0.02F * static_cast<float>(i) - 0.01F * static_cast<float>(j);
      rough.at(i, j) = bent.at(i, j) + ((i + j) % 2 == 0 ? 0.3F : -0.3F);
    }
  }
  const GroundValue smooth = score_ground(truth, {{&bent, 100}});
  EXPECT_LT(smooth.relief_median_percent, 1e-4) << "a plane is its own mean";
  EXPECT_GT(smooth.relief_p95_percent, 0.0) << "but not at the border";
  EXPECT_NEAR(smooth.known_relief_share(), 0.9, 0.02) << "all but what has no height, and the map's border";
  EXPECT_NEAR(score_ground(truth, {{&rough, 100}}).relief_median_percent, 0.3, 0.01);
  EXPECT_LT(score_ground(truth, {{&rough, 100}}).known_relief_share(), 0.05);
  EXPECT_NEAR(score_ground(truth, {{&rough, 200}}).relief_median_percent, 0.15, 0.005) << "seen from higher up";
  EXPECT_TRUE(std::isnan(score_ground(truth, {}).relief_median_percent));
}

/// Level ground flown over with images that are off by a number of grey values each.
class FeatureTest : public testing::Test {
 protected:
  FeatureTest() { map = host::Raster<float>(truth.height_m.width, truth.height_m.height, 0); }
  void set_image(std::size_t k, int off) {
    intake::Keyframe& keyframe = scene.keyframe(k);
    keyframe.image = host::Raster<std::uint8_t>(StripScene::width, StripScene::height, 100);
    host::Raster<std::uint8_t> original(StripScene::width, StripScene::height, 0);
    for (std::size_t i = 0; i < original.samples.size(); ++i) {
      original.samples[i] = static_cast<std::uint8_t>(100 + (i % 2 == 0 ? off : -off));
    }
    host::write_pgm(folder / keyframe.name, original.view());
  }
  GroundValue score(const world::PlantedFeature& feature) {
    TrueFrames frames(scene.truth, *scene.flight.camera);
    GroundValue value;
    score_features({feature}, scene.flight, truth, {{&map, 100}}, frames, folder.path(), value);
    return value;
  }

  test::ScratchFolder folder;
  StripScene scene;
  world::HeightGrid truth = StripScene::true_heights();
  host::Raster<float> map;
  const world::PlantedFeature crater{world::FeatureKind::crater, 0, 0, 12};
};

TEST_F(FeatureTest, IsJudgedInTheImageThatShowsItBest) {
  EXPECT_EQ(score(crater).features, 1U);
  EXPECT_EQ(score(crater).seen, 0U) << "no image came down";
  set_image(0, 50);
  EXPECT_EQ(score(crater).seen, 0U);
  set_image(1, 7);  // 31.2 dB
  GroundValue value = score(crater);
  EXPECT_EQ(value.seen, 1U);
  EXPECT_EQ(value.seen_well, 0U);
  EXPECT_NEAR(value.feature_squares, 49, 1e-9);
  set_image(2, 4);  // 36.1 dB
  value = score(crater);
  EXPECT_EQ(value.seen_well, 1U);
  EXPECT_NEAR(value.feature_squares, 16, 1e-9);
}

TEST_F(FeatureTest, NeedsHeightsToo) {
  set_image(0, 2);
  for (int j = 0; j < truth.height_m.height; ++j) {
    for (int i = 0; i < truth.height_m.width; ++i) {
      if (truth.x0 + i < -3) map.at(i, j) = none;  // more than a fifth of the disc
    }
  }
  EXPECT_EQ(score(crater).features, 1U);
  EXPECT_EQ(score(crater).seen, 0U);
}

TEST_F(FeatureTest, ThatNoFrameCouldSeeOrThatAreSingleStonesDoNotCount) {
  for (std::size_t k = 0; k < scene.x.size(); ++k) set_image(k, 2);
  EXPECT_EQ(score({world::FeatureKind::rock, 0, 0, 12}).features, 0U);
  EXPECT_EQ(score({world::FeatureKind::crater, 900, 0, 12}).features, 0U) << "beyond the true heights";
  const GroundValue aside = score({world::FeatureKind::crater, 0, 100, 12});
  EXPECT_EQ(aside.features, 1U);
  EXPECT_EQ(aside.seen, 0U) << "no image shows it";
}

}  // namespace
}  // namespace ilp::score
