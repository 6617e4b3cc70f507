// Qualities of seen ground against the numbers that made them, and the rule by which a later view is better.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <type_traits>
#include <vector>

#include "fsw/vision/terrain/seen_cells.hpp"
#include "fsw/vision/terrain/sigma_map.hpp"

namespace ilp::test {
namespace {

static_assert(std::is_trivially_copyable_v<SeenCells>);

constexpr double focal_px = 500;

TEST(SeenQuality, ALaterViewIsBetterOnlyIfItIsFinerByTheRatioAndItsErrorOfDistanceIsSmaller) {
  const std::int32_t steps = sampling_steps(1.8);
  const std::uint8_t seen = seen_quality(0.1, 0.002);
  EXPECT_TRUE(at_least_as_well(seen, seen, steps));
  EXPECT_TRUE(at_least_as_well(seen, seen_quality(0.1 / 1.3, 0.002), steps)) << "not finer enough";
  EXPECT_FALSE(at_least_as_well(seen, seen_quality(0.1 / 2.2, 0.002), steps)) << "half the error in metres";
  EXPECT_TRUE(at_least_as_well(seen, seen_quality(0.1 / 2, 0.015), steps)) << "finer, but the distance is uncertain";
  EXPECT_TRUE(at_least_as_well(seen, seen_quality(0.4, 0.0001), steps)) << "coarser";
  // What was seen with an error of 1.5 % is replaced by what is twice as fine, and not by what is as fine.
  const std::uint8_t badly = seen_quality(0.1, 0.015);
  EXPECT_FALSE(at_least_as_well(badly, seen_quality(0.05, 0.015), steps));
  EXPECT_TRUE(at_least_as_well(badly, seen_quality(0.1, 0.001), steps));
}

TEST(SeenQuality, UnknownGroundIsNeverKnownWellAndAViewWithoutGroundIsNeverBetter) {
  EXPECT_FALSE(at_least_as_well(0, seen_quality(0.1, 0.001), 3));
  EXPECT_FALSE(at_least_as_well(0, 0, 3));
  EXPECT_TRUE(at_least_as_well(seen_quality(0.1, 0.001), 0, 3));
  for (const double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(seen_quality(bad, 0.001), 0);
    EXPECT_EQ(seen_quality(0.1, bad), 0);
  }
}

TEST(SeenQuality, TheRuleIsTheSameInEveryUnitOfLengthAndUpToARatioOfThirty) {
  const std::int32_t steps = sampling_steps(1.8);
  for (double unit = 1e-6; unit < 1e6; unit *= 1.7) {
    const std::uint8_t seen = seen_quality(unit, 0.002);
    ASSERT_NE(seen, 0);
    for (const double finer : {2.2, 5.0, 30.0}) {
      EXPECT_FALSE(at_least_as_well(seen, seen_quality(unit / finer, 0.002), steps)) << unit << ", " << finer;
      EXPECT_TRUE(at_least_as_well(seen_quality(unit / finer, 0.002), seen, steps)) << unit << ", " << finer;
    }
  }
}

// The ratio is known, so that nothing is rounded: neither at the ratio of claims nor in another unit of length.
TEST(SeenQuality, WithARatioFromTheGeometryTheGroundIsClaimedFromThatRatioOn) {
  for (const double unit : {1.0, 3.258, 1e-4}) {
    const std::uint8_t seen = seen_quality(0.1, 0.002), now = seen_quality(0.1 * unit, 0.002);
    for (const double known : {0.5, 1.0, 1.42, 1.68, 1.79}) EXPECT_TRUE(at_least_as_well(seen, now, known, 1.8));
    for (const double finer : {1.81, 2.0, 300.0}) EXPECT_FALSE(at_least_as_well(seen, now, finer, 1.8));
  }
  const std::uint8_t well = seen_quality(0.1, 0.002), badly = seen_quality(0.1, 0.009);
  EXPECT_TRUE(at_least_as_well(well, badly, 3.9, 1.8)) << "two classes worse, and less than four times as near";
  EXPECT_FALSE(at_least_as_well(well, badly, 4.1, 1.8));
  EXPECT_FALSE(at_least_as_well(badly, well, 1.81, 1.8));
  EXPECT_FALSE(at_least_as_well(0, well, 1, 1.8)) << "never seen";
  EXPECT_FALSE(at_least_as_well(well, 0, 2, 1.8));
  EXPECT_TRUE(at_least_as_well(well, 0, 1, 1.8));
}

/// A plane that sinks to the right, seen from above: exact depth at every pixel but those in a corner.
struct Plane {
  static constexpr std::int32_t width = 100, height = 61;
  std::vector<float> inverse_depth, sigma;

  explicit Plane(double relative_sigma) {
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = 0; x < width; ++x) {
        const bool matched = x < 80 || y < 40;
        const double inverse = 1 / distance(x);
        inverse_depth.push_back(matched ? static_cast<float>(inverse) : 0.0F);
        sigma.push_back(matched ? static_cast<float>(relative_sigma * inverse) : 0.0F);
      }
    }
  }
  static double distance(double x) { return 50 + 2 * x; }
  [[nodiscard]] ImageView<const float> inverse_depths() const { return {inverse_depth.data(), width, height}; }
  [[nodiscard]] ImageView<const float> sigmas() const { return {sigma.data(), width, height}; }
};

/// Both are of one class of sigma and at most one level of sampling apart.
void expect_near(std::uint8_t quality, std::uint8_t wanted) {
  ASSERT_NE(quality, 0);
  EXPECT_EQ((quality - 1) % 4, (wanted - 1) % 4);
  EXPECT_TRUE(at_least_as_well(quality, wanted, 2) && at_least_as_well(wanted, quality, 2));
}

TEST(SeenCells, OfAPlaneHaveItsSamplingAndSigmaAndNoneWithoutDepth) {
  const auto cells = std::make_unique<SeenCells>();
  const Plane plane(0.0043);
  ASSERT_TRUE(seen_cells(plane.inverse_depths(), plane.sigmas(), focal_px, 32, *cells).ok());
  EXPECT_EQ(cells->columns, 13);
  EXPECT_EQ(cells->rows, 8);
  for (std::int32_t y = 4; y < 56; y += 8) {
    for (std::int32_t x = 4; x < 96; x += 8) {
      if (x >= 80 && y >= 40) {
        EXPECT_EQ(cells->at(x, y), 0);
      } else {
        expect_near(cells->at(x, y), seen_quality(Plane::distance(x - 0.5) / focal_px, 0.0043));
      }
    }
  }
  // The last row of cells has five rows of pixels, 40 of them per cell.
  EXPECT_NE(cells->at(0, 60), 0);
  ASSERT_TRUE(seen_cells(plane.inverse_depths(), plane.sigmas(), focal_px, 41, *cells).ok());
  EXPECT_EQ(cells->at(0, 60), 0);
}

TEST(SeenCells, FromStoredMapsAreThoseOfTheDepthItself) {
  const Plane plane(0.0043);
  constexpr double baseline = 20;
  std::vector<std::uint8_t> mask(plane.sigma.size(), 255), sigma_codes(plane.sigma.size());
  // Left of column 16 the ground was matched, but an earlier keyframe has claimed it.
  for (std::int32_t y = 0; y < Plane::height; ++y) std::fill_n(mask.data() + y * Plane::width, 16, std::uint8_t{0});
  const ImageView<std::uint8_t> masks(mask.data(), Plane::width, Plane::height);
  std::vector<std::uint16_t> codes(plane.sigma.size());
  StoredDepth stored{.disparity_per_inverse_depth_px = focal_px * baseline};
  ASSERT_TRUE(
      choose_depth_coding(plane.inverse_depths(), plane.sigmas(), masks, focal_px, baseline, 16, stored.coding).ok());
  ASSERT_TRUE(encode_depth(plane.inverse_depths(), plane.sigmas(), masks, stored.coding,
                           {codes.data(), Plane::width, Plane::height})
                  .ok());
  std::vector<std::uint64_t> supported(static_cast<std::size_t>(supported_words(Plane::width) * Plane::height));
  std::vector<float> sigma = plane.sigma;
  EXPECT_EQ(code_sigma({{},
                        {sigma.data(), Plane::width, Plane::height},
                        {supported.data(), supported_words(Plane::width), Plane::height}},
                       stored.disparity_per_inverse_depth_px, sigma_codes.data()),
            0U);
  stored.codes = {codes.data(), Plane::width, Plane::height};
  stored.sigma_codes = {sigma_codes.data(), Plane::width, Plane::height};
  const auto cells = std::make_unique<SeenCells>();
  ASSERT_TRUE(seen_cells(stored, focal_px, 32, *cells).ok());
  for (std::int32_t y = 4; y < 56; y += 8) {
    EXPECT_NE(cells->at(4, y), 0) << "known, with the sampling of the mean depth";
    for (std::int32_t x = 20; x < 80; x += 8) {
      expect_near(cells->at(x, y), seen_quality(Plane::distance(x - 0.5) / focal_px, 0.0043));
    }
  }
}

TEST(SeenCells, RefuseWhatDoesNotFit) {
  const auto cells = std::make_unique<SeenCells>();
  const Plane plane(0.001);
  EXPECT_EQ(clear_seen_cells(limits::max_image_width + 1, 10, *cells).code, StatusCode::image_too_large);
  const ImageView<const float> smaller(plane.sigma.data(), 10, 10);
  EXPECT_EQ(seen_cells(plane.inverse_depths(), smaller, focal_px, 32, *cells).code, StatusCode::invalid_argument);
  EXPECT_EQ(seen_cells(plane.inverse_depths(), plane.sigmas(), 0, 32, *cells).code, StatusCode::invalid_argument);
  EXPECT_EQ(seen_cells(StoredDepth{}, focal_px, 32, *cells).code, StatusCode::invalid_argument);
}

}  // namespace
}  // namespace ilp::test
