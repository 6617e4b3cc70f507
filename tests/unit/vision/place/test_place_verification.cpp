#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "fsw/base/rng.hpp"
#include "tests/unit/vision/overlap/ground_texture.hpp"
#include "tests/unit/vision/place/place_images.hpp"

namespace ilp {
namespace {

constexpr std::int32_t width = 640, height = 480;

/// Looks at a ground with 1024 x 1024 texels, each about two pixels wide.
test::Image look(const test::GroundTexture& ground, const Similarity2& from_image, const test::Tiling& tiling,
                 std::uint64_t seed) {
  Rng rng(seed);
  test::Exposure exposure;
  exposure.noise = 1.5;
  return test::look_at(ground, tiling, from_image, width, height, exposure, rng);
}

Similarity2 at(double x, double y, double rotation_rad, double scale = 0.5) {
  const double re = scale * std::cos(rotation_rad), im = scale * std::sin(rotation_rad);
  return {scale, rotation_rad, x - re * width / 2 + im * height / 2, y - im * width / 2 - re * height / 2};
}

TEST(PlaceVerification, KnowsTheSameGroundAtAnyHeadingAndTellsWhereItLies) {
  const test::GroundTexture ground(test::Ground::fractal, 5);
  const Similarity2 from_a = at(500, 500, 0);
  const PlaceFeatures a = test::features_of(look(ground, from_a, {}, 1));
  int pairs = 0, verified = 0;
  for (const double scale : {0.7, 1.0, 1.4}) {
    for (int turn = 0; turn < 7; ++turn) {
      const double rotation_rad = turn * 3.14159 / 6;
      const Similarity2 from_b = at(560, 450, rotation_rad, 0.5 * scale);
      const PlaceMatch match = test::verify(a, test::features_of(look(ground, from_b, {}, 2)));
      ++pairs;
      if (match.verdict != PlaceVerdict::verified) continue;
      ++verified;
      const Similarity2 b_from_a = test::compose(test::inverse(from_b), from_a);
      EXPECT_NEAR(match.newer_from_older.scale, b_from_a.scale, 0.02 * b_from_a.scale);
      EXPECT_LT(std::fabs(std::remainder(match.newer_from_older.rotation_rad - b_from_a.rotation_rad, 6.2831853)),
                0.02);
      const double* const h = match.plane_newer_from_older;
      for (const PlacePair& pair : match.pairs) {
        const double x = a[pair.older].x, y = a[pair.older].y, w = h[6] * x + h[7] * y + h[8];
        double u, v;
        test::apply(b_from_a, x, y, u, v);
        EXPECT_LT(std::hypot((h[0] * x + h[1] * y + h[2]) / w - u, (h[3] * x + h[4] * y + h[5]) / w - v), 5);
      }
      for (std::size_t k = 1; k < match.pairs.size(); ++k) EXPECT_LT(match.pairs[k - 1].older, match.pairs[k].older);
    }
  }
  EXPECT_EQ(verified, pairs);
}

TEST(PlaceVerification, TheSameImageIsTheSamePlace) {
  const PlaceFeatures a =
      test::features_of(look(test::GroundTexture(test::Ground::fractal, 5), at(500, 500, 0), {}, 1));
  const PlaceMatch match = test::verify(a, a);
  EXPECT_EQ(match.verdict, PlaceVerdict::verified);
  EXPECT_GT(match.pairs.size(), a.size() / 4);
  EXPECT_NEAR(match.newer_from_older.scale, 1, 1e-6);
  EXPECT_NEAR(match.newer_from_older.shift_x_px, 0, 1e-3);
}

TEST(PlaceVerification, UnrelatedGroundOfAnyKindIsNeverLinked) {
  std::vector<PlaceFeatures> places;
  for (int kind = 0; kind < static_cast<int>(test::Ground::count); ++kind) {
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
      const test::GroundTexture ground(static_cast<test::Ground>(kind), 700 + seed);
      places.push_back(test::features_of(look(ground, at(400, 500, 0.4 * static_cast<double>(seed)), {}, seed)));
    }
  }
  int checks = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k, ++checks) {
      const PlaceMatch match = test::verify(places[k], places[i]);
      EXPECT_NE(match.verdict, PlaceVerdict::verified) << k << " " << i << " evidence " << match.evidence;
    }
  }
  EXPECT_EQ(checks, 780);
}

// Tiles: what is seen may be any of them, so that the answer is no, even where the images overlap.
TEST(PlaceVerification, GroundThatRepeatsItselfIsNeverLinked) {
  int checks = 0;
  for (const double period : {60.0, 90.0, 130.0}) {
    for (std::uint64_t seed = 0; seed < 2; ++seed) {
      const test::GroundTexture ground(test::Ground::fractal, 800 + seed);
      const test::Tiling tiling{period, seed == 0 ? period : 0};
      const PlaceFeatures a = test::features_of(look(ground, at(300, 300, 0), tiling, 1));
      for (const double shift : {0.0, 0.4 * period, 1.3 * period, 2.5 * period}) {
        const PlaceFeatures b = test::features_of(look(ground, at(300 + shift, 300, 0.2), tiling, 2));
        const PlaceMatch match = test::verify(a, b);
        EXPECT_NE(match.verdict, PlaceVerdict::verified) << period << " " << shift << " rival " << match.rival_share;
        ++checks;
      }
    }
  }
  EXPECT_EQ(checks, 24);
}

// The same at any scale, angle and place, also with many features. Each pair of views has a pattern of its own.
class PlaceTiles : public testing::TestWithParam<std::size_t> {};

TEST_P(PlaceTiles, SeenFromAnywhereAreNeverLinked) {
  for (int pattern = 0; pattern < 20; ++pattern) {
    Rng rng(static_cast<std::uint64_t>(3000 + pattern));
    const double period = pattern % 2 == 0 ? 55 : 55 + 75 * rng.uniform();
    const test::GroundTexture ground(test::Ground::fractal, static_cast<std::uint64_t>(3000 + pattern));
    std::vector<PlaceFeatures> views;
    for (std::uint64_t k = 0; k < 3; ++k) {
      const double scale = 0.45 + 0.15 * rng.uniform(), turn = 6.28 * rng.uniform();
      const Similarity2 from_image{scale, turn, 1000 * rng.uniform(), 1000 * rng.uniform()};
      views.push_back(test::features_of(look(ground, from_image, {period, period}, k), GetParam()));
    }
    for (std::size_t i = 0; i < views.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        const PlaceMatch match = test::verify(views[k], views[i]);
        EXPECT_NE(match.verdict, PlaceVerdict::verified)
            << "pattern " << pattern << " of period " << period << ", views " << k << " and " << i << ", evidence "
            << match.evidence << ", of the best other place " << match.rival_share;
      }
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Features, PlaceTiles, testing::Values(limits::place_features, limits::max_place_features));

/// Rows of crop: a wave across them, and noise that is the field's own.
test::Image furrows(double period_px, double angle_rad, std::uint64_t field, std::uint64_t noise) {
  test::Image image =
      test::render_texture(width, height, {1, 0, 5000.0 * static_cast<double>(field), 0}, 0.25, 0, 1, noise);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      const double wave = std::sin((x * std::cos(angle_rad) + y * std::sin(angle_rad)) * 6.2831853 / period_px);
      std::uint8_t& p = image.view().at(x, y);
      p = static_cast<std::uint8_t>(std::clamp(p + 45 * wave, 0.0, 255.0));
    }
  }
  return image;
}

TEST(PlaceVerification, FurrowsOfOtherFieldsAreNeverLinked) {
  std::vector<PlaceFeatures> fields;
  for (std::uint64_t k = 0; k < 12; ++k) {
    const double period_px = k % 3 == 0 ? 9 : k % 3 == 1 ? 16 : 30;
    fields.push_back(test::features_of(furrows(period_px, 0.3 * static_cast<double>(k % 4), k, k)));
  }
  for (std::size_t i = 0; i < fields.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      EXPECT_NE(test::verify(fields[k], fields[i]).verdict, PlaceVerdict::verified) << k << " " << i;
    }
  }
}

// The camera's own pattern, the same in both images, over ground without texture.
TEST(PlaceVerification, VignettingAndNoiseAreNoGround) {
  const auto sky = [](std::uint64_t seed) {
    test::Image image(width, height);
    Rng rng(seed);
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = 0; x < width; ++x) {
        const double r2 = (std::pow(x - 320, 2) + std::pow(y - 240, 2)) / 160000;
        image.view().at(x, y) = static_cast<std::uint8_t>(120 - 30 * r2 + 4 * test::gaussian(rng));
      }
    }
    return test::features_of(image);
  };
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    EXPECT_NE(test::verify(sky(seed), sky(seed + 100)).verdict, PlaceVerdict::verified) << seed;
  }
}

TEST(PlaceVerification, AMirroredImageIsAnotherPlace) {
  const test::GroundTexture ground(test::Ground::craters, 5);
  const test::Image image = look(ground, at(500, 500, 0), {}, 1);
  test::Image mirrored = image;
  for (std::int32_t y = 0; y < height; ++y) {
    std::reverse_copy(image.view().row(y), image.view().row(y) + width, mirrored.view().row(y));
  }
  EXPECT_NE(test::verify(test::features_of(image), test::features_of(mirrored)).verdict, PlaceVerdict::verified);
}

TEST(PlaceVerification, TooFewFeaturesAreToldAndTooManyRefused) {
  const PlaceFeatures a = test::features_of(test::render_texture(width, height, {}, 1, 0, 1, 1));
  EXPECT_EQ(test::verify(a, {}).verdict, PlaceVerdict::too_few_features);
  const std::vector<PlaceFeature> many(limits::max_place_features + 1);
  const auto workspace = std::make_unique<PlaceMatchWorkspace>();
  PlaceMatch match;
  EXPECT_TRUE(
      verify_place(many, test::all(a), least_place_evidence, *workspace, match).is(StatusCode::invalid_argument));
  // All descriptors alike: everything matches, so that nothing does.
  const std::vector<PlaceFeature> same(limits::max_place_features);
  ASSERT_TRUE(verify_place(same, same, least_place_evidence, *workspace, match).ok());
  EXPECT_NE(match.verdict, PlaceVerdict::verified);
}

}  // namespace
}  // namespace ilp
