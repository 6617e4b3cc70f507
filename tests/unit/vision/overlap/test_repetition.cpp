#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "fsw/base/math.hpp"
#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "tests/unit/vision/overlap/ground_texture.hpp"

namespace ilp {
namespace {

double repetition_of(const test::GroundTexture& ground, const test::Tiling& tiling, double rotation_rad) {
  static const auto workspace = std::make_unique<OverlapWorkspace>();
  static const auto keyframe = std::make_unique<OverlapTemplate>();
  Rng rng(1);
  test::Exposure exposure;
  exposure.noise = 3;
  const test::Image image = test::look_at(ground, tiling, {1, rotation_rad, 40, 70}, 320, 240, exposure, rng);
  EXPECT_TRUE(prepare_overlap(image.view(), *keyframe, *workspace).ok());
  return keyframe->repetition;
}

TEST(Repetition, SeesPeriodsFromAFewPixelsToHalfTheImage) {
  for (const auto kind : {test::Ground::fractal, test::Ground::cells, test::Ground::boulders}) {
    const test::GroundTexture ground(kind, 3);
    for (const double turn : {0.0, 0.5}) {
      for (const double period : {12.0, 25.0, 60.0, 110.0}) {
        EXPECT_GT(repetition_of(ground, {period, period}, turn), 0.75) << period << " " << turn;
      }
    }
  }
}

TEST(Repetition, IsLowOnGroundThatDoesNotRepeat) {
  for (const auto kind : {test::Ground::fractal, test::Ground::craters, test::Ground::cells, test::Ground::boulders}) {
    EXPECT_LT(repetition_of(test::GroundTexture(kind, 3), {}, 0.2), 0.6);
  }
}

// A furrow matches itself anywhere along itself: one unknown of the shift is free.
TEST(Repetition, CountsStripes) {
  EXPECT_GT(repetition_of(test::GroundTexture(test::Ground::fractal, 3), {0, 0.5}, 0.4), 0.75);
}

}  // namespace
}  // namespace ilp
