#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/place/descriptor_distance.hpp"
#include "tests/unit/vision/overlap/ground_texture.hpp"
#include "tests/unit/vision/place/place_images.hpp"

namespace ilp {
namespace {

constexpr std::int32_t width = 640, height = 480;

TEST(PlaceFeatures, AreSpreadOverLevelsAndImageAndInOrder) {
  const PlaceFeatures features = test::features_of(test::render_texture(width, height, {}, 1, 0, 1, 1));
  EXPECT_EQ(features.size(), limits::place_features);
  int levels[place_levels] = {}, quarters[4] = {};
  for (const PlaceFeature& f : features) {
    ASSERT_LT(f.level, place_levels);
    ASSERT_TRUE(f.x > 0 && f.y > 0 && f.x < width - 1 && f.y < height - 1);
    ++levels[f.level];
    ++quarters[(f.x > width / 2 ? 1 : 0) + (f.y > height / 2 ? 2 : 0)];
  }
  for (const int count : levels) EXPECT_GT(count, 10);
  for (const int count : quarters) EXPECT_GT(count, 40);
  EXPECT_TRUE(std::is_sorted(features.begin(), features.end(),
                             [](const PlaceFeature& a, const PlaceFeature& b) { return a.level < b.level; }));
}

TEST(PlaceFeatures, FourTimesAsManyAreFoundWhereTheyAreWanted) {
  const test::Image image = test::render_texture(width, height, {}, 1, 0, 1, 1);
  const PlaceFeatures few = test::features_of(image), many = test::features_of(image, limits::max_place_features);
  EXPECT_GT(many.size(), 3 * limits::place_features);
  EXPECT_LE(test::features_of(image, 100 * limits::max_place_features).size(), limits::max_place_features);
  std::size_t kept = 0;
  for (const PlaceFeature& f : few) {
    kept += std::any_of(many.begin(), many.end(),
                        [&](const PlaceFeature& g) { return std::memcmp(&f, &g, sizeof f) == 0; });
  }
  EXPECT_GT(kept, few.size() * 9 / 10);
}

TEST(PlaceFeatures, VectorsOfBothWidthsFindTheSame) {
  const test::Image image = test::render_texture(width, height, {}, 1, 0, 1, 1);
  use_vectors(VectorWidth::bytes16);
  const PlaceFeatures narrow = test::features_of(image);
  use_vectors(widest_vectors());
  const PlaceFeatures wide = test::features_of(image);
  ASSERT_EQ(narrow.size(), wide.size());
  for (std::size_t i = 0; i < wide.size(); ++i) {
    EXPECT_EQ(hamming_256(narrow[i].descriptor, wide[i].descriptor), 0) << i;
    EXPECT_TRUE(narrow[i].x == wide[i].x && narrow[i].y == wide[i].y && narrow[i].angle == wide[i].angle) << i;
  }
}

TEST(PlaceFeatures, AnImageWithoutTextureOrTooSmallHasNone) {
  test::Image image(width, height);
  std::fill(image.pixels.begin(), image.pixels.end(), std::uint8_t{77});
  EXPECT_TRUE(test::features_of(image).empty());
  EXPECT_TRUE(test::features_of(test::render_texture(40, 40, {}, 1, 0, 1, 1)).empty());
  const auto harris = std::make_unique<HarrisWorkspace>();
  const auto workspace = std::make_unique<PlaceFeatureWorkspace>();
  PlaceFeatures features;
  std::uint8_t pixel = 0;
  const GrayView huge(&pixel, limits::max_image_width + 1, limits::max_image_height);
  EXPECT_TRUE(
      find_place_features(huge, limits::place_features, *harris, *workspace, features).is(StatusCode::image_too_large));
}

// The truth is the similarity with which the second image was rendered.
struct Repeated {
  int visible = 0, found = 0, alike = 0;
  std::vector<int> distances;  ///< of the descriptors at one place
  double worst_angle = 0;      ///< median error of the angle, 256 for a full turn
};

Repeated compare(double scale, double rotation_rad, double gain, double offset) {
  const Similarity2 from_a{1, 0, 1000, 2000};
  const double re = std::cos(rotation_rad) * scale, im = std::sin(rotation_rad) * scale;
  const Similarity2 from_b{scale, rotation_rad, 1320 - re * 320 + im * 240, 2240 - im * 320 - re * 240};
  const PlaceFeatures a = test::features_of(test::render_texture(width, height, from_a, 0.55, 0, 1, 1));
  const PlaceFeatures b = test::features_of(test::render_texture(width, height, from_b, 0.55 * gain, offset, 1, 2));
  const Similarity2 b_from_a = test::compose(test::inverse(from_b), from_a);
  Repeated result;
  std::vector<double> angles;
  for (const PlaceFeature& f : a) {
    double x, y;
    test::apply(b_from_a, f.x, f.y, x, y);
    if (x < 40 || y < 40 || x > width - 40 || y > height - 40) continue;
    ++result.visible;
    const PlaceFeature* nearest = nullptr;
    int least = 257;
    for (const PlaceFeature& g : b) {
      if (std::hypot(static_cast<double>(g.x) - x, static_cast<double>(g.y) - y) > 4) continue;
      const int distance = hamming_256(f.descriptor, g.descriptor);
      if (distance < least) nearest = &g;
      least = std::min(least, distance);
    }
    if (nearest == nullptr) continue;
    ++result.found;
    result.distances.push_back(least);
    result.alike += least <= 72 ? 1 : 0;
    const double turned = nearest->angle - f.angle - b_from_a.rotation_rad * 128 / 3.14159265358979;
    angles.push_back(std::fabs(std::remainder(turned, 256)));
  }
  std::sort(angles.begin(), angles.end());
  result.worst_angle = angles.empty() ? 256 : angles[angles.size() / 2];
  return result;
}

TEST(PlaceFeatures, AreFoundAgainTurnedNearerFartherAndInOtherLight) {
  for (const double scale : {0.7, 1.0, 1.4}) {
    for (const double rotation_rad : {0.0, 0.9, 2.2, 3.1}) {
      for (const double gain : {1.0, 0.7}) {
        const Repeated r = compare(scale, rotation_rad, gain, gain < 1 ? 30 : 0);
        SCOPED_TRACE(testing::Message() << "scale " << scale << " rotation " << rotation_rad << " gain " << gain);
        EXPECT_GT(r.visible, 80);
        EXPECT_GT(r.found, r.visible / 3) << r.visible;
        EXPECT_GT(r.alike, r.visible / 6) << r.visible;
        EXPECT_LT(r.worst_angle, 10);
      }
    }
  }
}

// A comparison is relative to the angle of the texture, so that its bits are not even: on smooth ground unrelated
// features are more alike than on rough ground.
TEST(PlaceFeatures, DescriptorsOfUnrelatedGroundDiffer) {
  for (int kind = 0; kind < static_cast<int>(test::Ground::count); ++kind) {
    const auto look = [kind](std::uint64_t seed) {
      const test::GroundTexture ground(static_cast<test::Ground>(kind), seed);
      Rng rng(seed);
      return test::features_of(test::look_at(ground, {}, {0.5, 0, 300, 300}, width, height, {}, rng));
    };
    const PlaceFeatures a = look(700), b = look(701);
    double sum = 0;
    int alike = 0;
    for (const PlaceFeature& f : a) {
      for (const PlaceFeature& g : b) {
        const int distance = hamming_256(f.descriptor, g.descriptor);
        int bits = 0;
        for (int k = 0; k < 256; ++k) bits += ((f.descriptor[k / 32] ^ g.descriptor[k / 32]) >> (k % 32)) & 1U;
        ASSERT_EQ(distance, bits);
        sum += distance;
        alike += distance <= 72 ? 1 : 0;
      }
    }
    const double pairs = static_cast<double>(a.size()) * static_cast<double>(b.size());
    const bool smooth = static_cast<test::Ground>(kind) == test::Ground::fractal;
    EXPECT_GT(sum / pairs, smooth ? 70 : 100) << kind;
    EXPECT_LT(alike / pairs, smooth ? 0.6 : 0.15) << kind;
  }
}

}  // namespace
}  // namespace ilp
