// The masks of a strip of three views over a hill, against what the geometry says is seen for the first time.
#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <type_traits>

#include "fsw/base/checksum.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/terrain/mask.hpp"
#include "tests/unit/vision/stereo/analytic_scene.hpp"

namespace ilp::test {
namespace {

static_assert(std::is_trivially_copyable_v<Coverage>);

constexpr std::int32_t never_finer = sampling_levels;  // steps: ground that is known stays known

double hill(double x, double y) {
  return 10 * std::exp(-((x - 25) * (x - 25) + y * y) / 500) + 0.04 * x;
}

/// A strip of cameras with true depth; no matching, so that only the masks are under test.
struct Strip {
  CameraModel camera = distorting_camera();
  std::vector<RigidTransform> cameras;

  [[nodiscard]] bool seen(const Vec3& ground, std::size_t i) const {
    return inside(camera, pixel_of(camera, cameras[i], ground));
  }
  [[nodiscard]] RigidTransform step(std::size_t i) const { return compose(cameras[i + 1], inverse(cameras[i])); }
};

struct DepthImage {
  std::vector<float> inverse_depth, sigma;
  std::vector<Vec3> ground;
};

/// Carries the coverage over the step from image i, all of whose depth is claimed.
Status carry(const Strip& strip, std::size_t i, const DepthImage& depth, CoverageWorkspace& workspace,
             Coverage& coverage) {
  const CameraModel& camera = strip.camera;
  const ImageView<const float> rho(depth.inverse_depth.data(), camera.width, camera.height);
  const ImageView<const float> sigma(depth.sigma.data(), camera.width, camera.height);
  const std::vector<std::uint8_t> mask(depth.sigma.size(), 255);
  const auto now = std::make_unique<SeenCells>();
  ILP_TRY(seen_cells(rho, sigma, camera.fx, 1, *now));
  return carry_coverage(camera, {rho, sigma, {mask.data(), camera.width, camera.height}, *now}, strip.step(i),
                        workspace, coverage);
}

/// Depth of image i wherever image i + 1 sees the ground too; every `hole`-th pixel is left unmatched.
DepthImage depth_of(const Strip& strip, std::size_t i, std::uint32_t hole) {
  DepthImage d;
  Rng rng(i + 1);
  for (std::int32_t y = 0; y < strip.camera.height; ++y) {
    for (std::int32_t x = 0; x < strip.camera.width; ++x) {
      const Vec3 ground = ground_point(strip.camera, strip.cameras[i], hill, x, y);
      const bool matched = strip.seen(ground, i + 1) && rng.below(hole) != 0;
      d.ground.push_back(ground);
      d.inverse_depth.push_back(matched ? static_cast<float>(1 / (strip.cameras[i] * ground).z()) : 0.0F);
      d.sigma.push_back(matched ? 1e-4F : 0.0F);
    }
  }
  return d;
}

class NewlySeen : public ::testing::TestWithParam<std::vector<RigidTransform>> {
 protected:
  NewlySeen() { strip_.cameras = GetParam(); }
  Strip strip_;
};

TEST_P(NewlySeen, MaskIsWhatNoEarlierPairReconstructed) {
  const CameraModel& camera = strip_.camera;
  const auto workspace = std::make_unique<CoverageWorkspace>();
  const auto coverage = std::make_unique<Coverage>();
  const auto now = std::make_unique<SeenCells>();
  ASSERT_TRUE(clear_coverage(camera.width, camera.height, *coverage).ok());
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(camera.width * camera.height));
  for (std::size_t pair = 0; pair + 1 < strip_.cameras.size(); ++pair) {
    const DepthImage depth = depth_of(strip_, pair, 50);
    const ImageView<const float> rho(depth.inverse_depth.data(), camera.width, camera.height);
    const ImageView<const float> sigma(depth.sigma.data(), camera.width, camera.height);
    MaskCounts counts;
    ASSERT_TRUE(seen_cells(rho, sigma, camera.fx, 1, *now).ok());
    const ImageView<std::uint8_t> masks(mask.data(), camera.width, camera.height);
    ASSERT_TRUE(newly_seen_mask(sigma, *coverage, *now, never_finer, masks, counts).ok());
    double both = 0;
    double wanted = 0;
    double given = 0;
    for (std::size_t p = 0; p < mask.size(); ++p) {
      // Reconstructed before: visible in two consecutive earlier images.
      bool earlier = false;
      for (std::size_t k = 0; k < pair; ++k) {
        earlier = earlier || (strip_.seen(depth.ground[p], k) && strip_.seen(depth.ground[p], k + 1));
      }
      const bool fresh = depth.sigma[p] > 0 && !earlier;
      const bool is_set = mask[p] != 0;
      ASSERT_TRUE(!is_set || depth.sigma[p] > 0) << "a pixel without depth is in the mask";
      both += fresh && is_set ? 1 : 0;
      wanted += fresh ? 1 : 0;
      given += is_set ? 1 : 0;
    }
    EXPECT_EQ(given, counts.newly_seen);
    std::printf("pair %zu: newly seen %.1f %%, precision %.2f %%, recall %.2f %%\n", pair,
                100 * given / static_cast<double>(mask.size()), 100 * both / given, 100 * both / wanted);
    EXPECT_GT(both / given, pair == 0 ? 0.9999 : 0.96);
    EXPECT_GT(both / wanted, pair == 0 ? 0.9999 : 0.96);
    ASSERT_TRUE(carry_coverage(camera, {rho, sigma, masks, *now}, strip_.step(pair), *workspace, *coverage).ok());
  }
}

std::vector<RigidTransform> track(const Vec3& step, const Vec3& turn, double spin) {
  std::vector<RigidTransform> cameras;
  for (int i = 0; i < 5; ++i)
    cameras.push_back(looking_down(Vec3(0, 0, 100) + i * step, (i % 2) * turn + Vec3(0, 0, i * spin)));
  return cameras;
}

INSTANTIATE_TEST_SUITE_P(Tracks, NewlySeen,
                         ::testing::Values(track({19, 0, 0}, {0, 0, 0}, 0), track({14, 13, 1}, {0.02, -0.02, 0}, 0.15),
                                           track({-18, 3, -5}, {0, 0.03, 0}, -0.1)));

// Rows begin at any bit of the coverage, and end with any part of a cell.
TEST(NewlySeenMask, IsWhatItsDefinitionSaysAtEveryPixelOfEveryWidth) {
  Rng rng(11);
  const auto coverage = std::make_unique<Coverage>();
  const auto now = std::make_unique<SeenCells>();
  constexpr std::int32_t height = 19, finer_steps = 3;
  for (std::int32_t width = 1; width < 140; ++width) {
    ASSERT_TRUE(clear_seen_cells(width, height, *now).ok());
    *coverage = {};
    coverage->width = width;
    coverage->height = height;
    coverage->seen = *now;
    for (std::uint8_t& quality : now->quality) quality = static_cast<std::uint8_t>(rng.below(30));
    for (std::uint8_t& quality : coverage->seen.quality) quality = static_cast<std::uint8_t>(rng.below(30));
    std::vector<float> sigma(static_cast<std::size_t>(width) * height);
    for (std::size_t i = 0; i < sigma.size(); ++i) {
      sigma[i] = rng.below(4) == 0 ? 0.0F : 0.1F;
      if (rng.below(2) == 0) coverage->set(i);
    }
    for (const VectorWidth vectors : {VectorWidth::bytes16, widest_vectors()}) {
      use_vectors(vectors);
      std::vector<std::uint8_t> mask(sigma.size(), 7);
      MaskCounts counts;
      ASSERT_TRUE(newly_seen_mask({sigma.data(), width, height}, *coverage, *now, finer_steps,
                                  {mask.data(), width, height}, counts)
                      .ok());
      std::uint32_t fresh = 0;
      for (std::int32_t y = 0; y < height; ++y) {
        for (std::int32_t x = 0; x < width; ++x) {
          const std::size_t i =
              static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
          const bool known =
              coverage->at(x, y) && at_least_as_well(coverage->seen.at(x, y), now->at(x, y), finer_steps);
          const bool wanted = sigma[i] > 0 && !known;
          ASSERT_EQ(mask[i], wanted ? 255 : 0) << "width " << width << ", pixel " << x << ' ' << y;
          fresh += wanted ? 1U : 0U;
        }
      }
      EXPECT_EQ(counts.newly_seen, fresh);
    }
    use_vectors(widest_vectors());
  }
}

TEST(Coverage, EveryBitThatAnImageUsesIsInItsMemory) {
  const auto coverage = std::make_unique<Coverage>();
  ASSERT_TRUE(clear_coverage(101, 7, *coverage).ok());
  const std::uint64_t sum = checksum64(memory_of(*coverage));
  for (std::size_t pixel = 0; pixel < std::size_t{101} * 7; ++pixel) {
    coverage->bits[pixel / 64] ^= std::uint64_t{1} << pixel % 64;
    EXPECT_NE(checksum64(memory_of(*coverage)), sum) << pixel;
    coverage->bits[pixel / 64] ^= std::uint64_t{1} << pixel % 64;
  }
  coverage->seen.of(100, 6) ^= 1U;
  EXPECT_NE(checksum64(memory_of(*coverage)), sum);
  // A flipped bit of the size itself does not lead beyond the bits.
  coverage->width = 1 << 30;
  EXPECT_EQ(memory_of(*coverage).size(), sizeof(Coverage));
  coverage->width = -1;
  EXPECT_EQ(memory_of(*coverage).size(), offsetof(Coverage, bits));
}

TEST(CarryCoverage, GroundThatFailedToMatchAgainStaysCovered) {
  Strip strip{.cameras = track({15, 0, 0}, {0, 0, 0}, 0)};
  const CameraModel& camera = strip.camera;
  const auto workspace = std::make_unique<CoverageWorkspace>();
  const auto coverage = std::make_unique<Coverage>();
  ASSERT_TRUE(clear_coverage(camera.width, camera.height, *coverage).ok());
  for (std::int32_t y = 0; y < camera.height; ++y) {
    for (std::int32_t x = 0; x < camera.width; ++x) coverage->cover(x, y, seen_quality(0.3, 0.001));
  }
  DepthImage depth = depth_of(strip, 0, 1u << 30U);
  // A block in the middle lost its depth.
  for (std::int32_t y = 80; y < 160; ++y) {
    for (std::int32_t x = 120; x < 200; ++x) depth.sigma[static_cast<std::size_t>(y * camera.width + x)] = 0;
  }
  // What has depth again was known already.
  const ImageView<const float> rho(depth.inverse_depth.data(), camera.width, camera.height);
  const ImageView<const float> sigma(depth.sigma.data(), camera.width, camera.height);
  const std::vector<std::uint8_t> mask(depth.sigma.size());
  const auto now = std::make_unique<SeenCells>();
  ASSERT_TRUE(seen_cells(rho, sigma, camera.fx, 1, *now).ok());
  ASSERT_TRUE(carry_coverage(camera, {rho, sigma, {mask.data(), camera.width, camera.height}, *now}, strip.step(0),
                             *workspace, *coverage)
                  .ok());
  // The block's ground moves left by 15 units, about 45 px.
  int covered = 0;
  for (std::int32_t y = 85; y < 155; ++y) {
    for (std::int32_t x = 90; x < 140; ++x)
      covered += coverage->at(static_cast<std::size_t>(y * camera.width + x)) ? 1 : 0;
  }
  EXPECT_GT(covered, 0.99 * 70 * 50);
}

TEST(CarryCoverage, ADescentLeavesNoPixelOfGroundThatItHasReconstructedUncovered) {
  const auto workspace = std::make_unique<CoverageWorkspace>();
  const auto coverage = std::make_unique<Coverage>();
  for (const double sink : {4.0, 10.0, 15.0, 25.0}) {
    for (const double spin : {0.0, 0.3}) {
      Strip strip{.cameras = track({0, 0, -sink}, {0, 0, 0}, spin)};
      const CameraModel& camera = strip.camera;
      ASSERT_TRUE(clear_coverage(camera.width, camera.height, *coverage).ok());
      const DepthImage depth = depth_of(strip, 0, 1u << 30U);
      ASSERT_TRUE(carry(strip, 0, depth, *workspace, *coverage).ok());
      int seen = 0;
      int left = 0;
      // At the very border the middle of the other image's pixel may be outside.
      for (std::int32_t y = 2; y < camera.height - 2; ++y) {
        for (std::int32_t x = 2; x < camera.width - 2; ++x) {
          if (!strip.seen(ground_point(camera, strip.cameras[1], hill, x, y), 0)) continue;
          ++seen;
          left += coverage->at(static_cast<std::size_t>(y * camera.width + x)) ? 0 : 1;
        }
      }
      EXPECT_GT(seen, 0.8 * camera.width * camera.height);
      EXPECT_LT(left, 0.001 * seen) << "sinking by " << sink << ", turning by " << spin;
    }
  }
}

TEST(CarryCoverage, ADescendingCameraClaimsGroundAgainOnceItSeesItFinerByTheRatio) {
  const auto workspace = std::make_unique<CoverageWorkspace>();
  const auto coverage = std::make_unique<Coverage>();
  const auto now = std::make_unique<SeenCells>();
  Strip strip;
  // The height shrinks by a tenth from image to image.
  for (int i = 0; i < 14; ++i)
    strip.cameras.push_back(looking_down(Vec3(0.5 * i, 0, 100 * std::pow(0.9, i)), {0, 0, 0}));
  const CameraModel& camera = strip.camera;
  ASSERT_TRUE(clear_coverage(camera.width, camera.height, *coverage).ok());
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(camera.width * camera.height));
  const ImageView<std::uint8_t> masks(mask.data(), camera.width, camera.height);
  std::vector<double> claimed;
  for (std::size_t i = 0; i + 1 < strip.cameras.size(); ++i) {
    const DepthImage depth = depth_of(strip, i, 1u << 30U);
    const ImageView<const float> rho(depth.inverse_depth.data(), camera.width, camera.height);
    const ImageView<const float> sigma(depth.sigma.data(), camera.width, camera.height);
    ASSERT_TRUE(seen_cells(rho, sigma, camera.fx, 1, *now).ok());
    MaskCounts counts;
    ASSERT_TRUE(newly_seen_mask(sigma, *coverage, *now, sampling_steps(1.8), masks, counts).ok());
    claimed.push_back(counts.newly_seen / static_cast<double>(counts.matched));
    ASSERT_TRUE(carry_coverage(camera, {rho, sigma, masks, *now}, strip.step(i), *workspace, *coverage).ok());
  }
  EXPECT_EQ(claimed[0], 1);
  // 1 / 1.8 of the height is reached after five to six images: nothing until then but on top of the hill, everything
  // within the next ones, and not again before another factor of the same size.
  for (const std::size_t i : {1U, 2U, 3U}) EXPECT_LT(claimed[i], 0.02) << i;
  EXPECT_LT(claimed[4], 0.15) << "finer by 1.52";
  EXPECT_NEAR(claimed[4] + claimed[5] + claimed[6] + claimed[7], 1, 0.05);
  EXPECT_NEAR(claimed[8] + claimed[9] + claimed[10] + claimed[11] + claimed[12], 1, 0.1);
}

TEST(DropUncertainDepths, TakesAwayWhatHasALargerSigmaThanItsShareOfTheDistanceAndNothingElse) {
  std::vector<float> inverse{0.01F, 0.01F, 0.0F, -0.01F};
  std::vector<float> sigma{0.0001F, 0.0003F, 0.0001F, 0.0001F};
  drop_uncertain_depths(0.02, {{inverse.data(), 4, 1}, {sigma.data(), 4, 1}, {}});
  EXPECT_EQ(inverse, (std::vector<float>{0.01F, 0, 0, 0}));
  EXPECT_EQ(sigma, (std::vector<float>{0.0001F, 0, 0, 0}));
}

TEST(CarryCoverage, RefusesSizesThatDoNotFit) {
  const auto workspace = std::make_unique<CoverageWorkspace>();
  const auto coverage = std::make_unique<Coverage>();
  EXPECT_EQ(clear_coverage(limits::max_image_width + 1, 10, *coverage).code, StatusCode::image_too_large);
  ASSERT_TRUE(clear_coverage(320, 240, *coverage).ok());
  std::vector<float> depth(100 * 100);
  std::vector<std::uint8_t> mask(100 * 100);
  const auto now = std::make_unique<SeenCells>();
  const ImageView<const float> map(depth.data(), 100, 100);
  const PairGround ground{map, map, {mask.data(), 100, 100}, *now};
  EXPECT_EQ(carry_coverage(distorting_camera(), ground, {}, *workspace, *coverage).code, StatusCode::invalid_argument);
  MaskCounts counts;
  EXPECT_EQ(newly_seen_mask(map, *coverage, *now, 3, {mask.data(), 100, 100}, counts).code,
            StatusCode::invalid_argument);
}

}  // namespace
}  // namespace ilp::test
