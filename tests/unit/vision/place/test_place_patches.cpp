#include "fsw/vision/place/place_patches.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "fsw/base/rng.hpp"
#include "tests/unit/vision/overlap/ground_texture.hpp"
#include "tests/unit/vision/place/place_images.hpp"

namespace ilp {
namespace {

constexpr std::int32_t width = 640, height = 480;

test::Image look(const test::GroundTexture& ground, const Similarity2& from_image, std::uint64_t seed) {
  Rng rng(seed);
  test::Exposure exposure;
  exposure.noise = 1.5;
  return test::look_at(ground, {}, from_image, width, height, exposure, rng);
}

Similarity2 at(double x, double y, double rotation_rad, double scale) {
  const double re = scale * std::cos(rotation_rad), im = scale * std::sin(rotation_rad);
  return {scale, rotation_rad, x - re * width / 2 + im * height / 2, y - im * width / 2 - re * height / 2};
}

struct Plane {
  double h[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
};

/// The similarity, and an error of the prediction.
Plane plane_of(const Similarity2& b_from_a, double error_x, double error_y) {
  const double c = b_from_a.scale * std::cos(b_from_a.rotation_rad);
  const double s = b_from_a.scale * std::sin(b_from_a.rotation_rad);
  return {{c, -s, b_from_a.shift_x_px + error_x, s, c, b_from_a.shift_y_px + error_y, 0, 0, 1}};
}

PlacePatches keep(const test::Image& image) {
  static const auto harris = std::make_unique<HarrisWorkspace>();
  static const auto workspace = std::make_unique<PlacePatchWorkspace>();
  PlacePatches patches;
  EXPECT_TRUE(begin_place_patches(image.view(), *harris, *workspace, patches).ok());
  EXPECT_TRUE(do_all([&] { return place_patches_slice(image.view(), *harris, *workspace, patches); }).ok());
  return patches;
}

PatchSightings find(const PlacePatches& kept, const test::Image& image, const Plane& plane) {
  static const auto workspace = std::make_unique<PlacePatchWorkspace>();
  PatchSightings sightings;
  EXPECT_TRUE(find_place_patches({kept.data(), kept.size()}, image.view(), plane.h, {}, *workspace, sightings).ok());
  return sightings;
}

TEST(PlacePatches, AreFoundToASmallPartOfAPixelAtAnyHeadingAndScale) {
  const test::GroundTexture ground(test::Ground::fractal, 5);
  const Similarity2 from_a = at(500, 500, 0, 0.5);
  const PlacePatches kept = keep(look(ground, from_a, 1));
  ASSERT_GE(kept.size(), 300U);
  for (const double scale : {0.7, 1.0, 1.4}) {
    for (int turn = 0; turn < 5; ++turn) {
      const Similarity2 from_b = at(530, 480, turn * 1.1, 0.5 * scale);
      const Similarity2 b_from_a = test::compose(test::inverse(from_b), from_a);
      const PatchSightings found = find(kept, look(ground, from_b, 2), plane_of(b_from_a, 3.3, -2.6));
      std::size_t visible = 0;
      for (const PlacePatch& patch : kept) {
        double u, v;
        test::apply(b_from_a, patch.x, patch.y, u, v);
        visible += u > 40 && v > 40 && u < width - 40 && v < height - 40 ? 1 : 0;
      }
      std::vector<double> errors;
      for (const PatchSighting& seen : found) {
        const PlacePatch& patch = kept[seen.patch];
        double u, v;
        test::apply(b_from_a, patch.x, patch.y, u, v);
        errors.push_back(std::hypot(static_cast<double>(seen.x) - u, static_cast<double>(seen.y) - v));
      }
      ASSERT_GE(10 * errors.size(), 7 * std::min<std::size_t>(visible, limits::max_link_points))
          << scale << " turned " << turn;
      std::sort(errors.begin(), errors.end());
      // The ground is drawn between texels of two pixels, and features alone are off by 0.6 px.
      EXPECT_LT(errors[errors.size() / 2], 0.3) << scale << " turned " << turn;
      EXPECT_LT(errors[errors.size() * 19 / 20], 0.8) << scale << " turned " << turn;
    }
  }
}

/// Each pixel is the mean of two by two, as a camera sees it from twice as far away.
test::Image from_twice_as_far(const test::Image& fine) {
  const GrayView from = fine.view();
  test::Image coarse(from.width / 2, from.height / 2);
  for (std::int32_t y = 0; y < from.height / 2; ++y) {
    for (std::int32_t x = 0; x < from.width / 2; ++x) {
      const std::uint8_t *const top = from.row(2 * y) + 2 * x, *const bottom = from.row(2 * y + 1) + 2 * x;
      coarse.view().row(y)[x] = static_cast<std::uint8_t>((top[0] + top[1] + bottom[0] + bottom[1] + 2) / 4);
    }
  }
  return coarse;
}

// A corner is not where it was if one of the images is sharper.
TEST(PlacePatches, AreFoundWhereTheCameraIsTwiceAsNear) {
  const test::GroundTexture ground(test::Ground::fractal, 5);
  Rng rng(1);
  test::Exposure exposure;
  exposure.noise = 1.5;
  const test::Image near = test::look_at(ground, {}, {1, 0, 200, 200}, 2 * width, 2 * height, exposure, rng);
  const PlacePatches kept = keep(from_twice_as_far(near));
  const PatchSightings found = find(kept, near, {{2, 0, 3.5, 0, 2, -2.5, 0, 0, 1}});
  std::vector<double> errors;
  for (const PatchSighting& seen : found) {
    const PlacePatch& patch = kept[seen.patch];
    errors.push_back(
        std::hypot(static_cast<double>(seen.x - 2 * patch.x) - 0.5, static_cast<double>(seen.y - 2 * patch.y) - 0.5));
  }
  std::sort(errors.begin(), errors.end());
  // Without the smoothing the median is 0.099.
  ASSERT_GE(errors.size(), limits::max_link_points - 3);
  EXPECT_LT(errors[errors.size() / 2], 0.08);
  EXPECT_LT(errors[errors.size() * 19 / 20], 0.17);
}

TEST(PlacePatches, OtherGroundIsNotTakenForThem) {
  const Similarity2 from_image = at(500, 500, 0, 0.5);
  const PlacePatches kept = keep(look(test::GroundTexture(test::Ground::fractal, 5), from_image, 1));
  const test::Image other = look(test::GroundTexture(test::Ground::fractal, 6), from_image, 2);
  EXPECT_LE(20 * find(kept, other, {}).size(), kept.size());
}

TEST(PlacePatches, LieAllOverTheImageAndHoldItAboutTheirPlace) {
  const test::Image image = look(test::GroundTexture(test::Ground::fractal, 5), at(500, 500, 0, 0.5), 1);
  const PlacePatches kept = keep(image);
  std::vector<int> in_part(16, 0);
  for (const PlacePatch& patch : kept) {
    const auto x = static_cast<std::int32_t>(std::floor(patch.x)), y = static_cast<std::int32_t>(std::floor(patch.y));
    const double step = (patch.brightest - patch.darkest) / 15.0;
    for (std::int32_t row = 0; row < kept_patch_side; ++row) {
      for (std::int32_t column = 0; column < kept_patch_side; ++column) {
        const int byte = patch.steps[static_cast<std::size_t>((row * kept_patch_side + column) / 2)];
        const int steps = column % 2 == 0 ? byte & 15 : byte >> 4;
        // The place is in or right of the ninth pixel.
        ASSERT_NEAR(patch.darkest + steps * step, image.view().at(x + column - 8, y + row - 8), 0.51 * step + 1e-9);
      }
    }
    ++in_part[static_cast<std::size_t>(y * 4 / height * 4 + x * 4 / width)];
  }
  EXPECT_GE(*std::min_element(in_part.begin(), in_part.end()), 10);
}

TEST(PlacePatches, NothingIsSoughtBeyondTheBorderOrByANonsensePrediction) {
  const test::Image image = look(test::GroundTexture(test::Ground::fractal, 5), at(500, 500, 0, 0.5), 1);
  PlacePatches kept = keep(image);
  EXPECT_TRUE(find(kept, image, {{1, 0, 5000, 0, 1, 0, 0, 0, 1}}).empty());
  EXPECT_TRUE(find(kept, image, {{0, 0, 0, 0, 0, 0, 0, 0, 0}}).empty());
  EXPECT_TRUE(find(kept, image, {{50, 0, 0, 0, 50, 0, 0, 0, 1}}).empty()) << "magnified beyond the window";
  kept[0].x = std::numeric_limits<float>::quiet_NaN();
  for (const PatchSighting& seen : find(kept, image, {})) EXPECT_NE(seen.patch, 0) << "a damaged patch is left out";
  const auto workspace = std::make_unique<PlacePatchWorkspace>();
  PatchSightings sightings;
  Plane plane;
  plane.h[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(
      find_place_patches({}, image.view(), plane.h, {}, *workspace, sightings).is(StatusCode::invalid_argument));
  PatchSearchParams far{.radius_px = max_patch_search_px + 1};
  EXPECT_TRUE(
      find_place_patches({}, image.view(), Plane{}.h, far, *workspace, sightings).is(StatusCode::invalid_argument));
}

}  // namespace
}  // namespace ilp
