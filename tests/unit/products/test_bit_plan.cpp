#include <gtest/gtest.h>

#include "fsw/products/bit_plan.hpp"

namespace ilp {
namespace {

constexpr std::size_t pixels = 640 * 480;

BitPlan plan(const MissionParameters& mission, ProductKind kind, double richness, std::uint32_t newly_seen,
             double budget_bytes = 0, double rank = 0.5) {
  return plan_bits(mission, kind, {richness, newly_seen, pixels, budget_bytes, budget_bytes, rank});
}

TEST(BitPlanTest, ARicherImageNeverGetsFewerBytes) {
  MissionParameters mission;
  mission.thumbnail_share = 0.3;
  mission.lossless_share = 0.2;
  for (const ProductKind kind : {ProductKind::image, ProductKind::depth}) {
    for (const double budget : {0.0, 5000.0, 12'000.0, 1e5}) {
      for (const std::uint32_t newly_seen : {1U, 500U, 20'000U, 60'000U, 307'200U}) {
        std::uint32_t before = 0;
        double priority = -1;
        for (int i = 0; i <= 1000; ++i) {
          const BitPlan bits = plan(mission, kind, i / 1000.0, newly_seen, budget, i / 1000.0);
          EXPECT_GE(bits.grant_bytes, before) << "index " << i / 1000.0 << ", newly seen " << newly_seen;
          EXPECT_GT(bits.priority, priority);
          before = bits.grant_bytes;
          priority = bits.priority;
        }
      }
    }
  }
}

TEST(BitPlanTest, MoreNewGroundNeverGetsFewerBytes) {
  const MissionParameters mission;
  for (const ProductKind kind : {ProductKind::image, ProductKind::depth}) {
    for (const double richness : {0.0, 0.04, 0.06, 0.5, 1.0}) {
      std::uint32_t before = 0;
      for (std::uint32_t newly_seen = 0; newly_seen <= pixels; newly_seen += 997) {
        const BitPlan bits = plan(mission, kind, richness, newly_seen);
        EXPECT_GE(bits.grant_bytes, before) << "index " << richness << ", newly seen " << newly_seen;
        before = bits.grant_bytes;
      }
    }
  }
}

TEST(BitPlanTest, BitsPerNewPixelRunFromTheFloorToTheCeiling) {
  MissionParameters mission;
  constexpr std::uint32_t newly_seen = 100'000;
  const auto bits_per_pixel = [&](ProductKind kind, double richness) {
    // Two areas: what does not depend on the area cancels.
    const double large = plan(mission, kind, richness, 2 * newly_seen).grant_bytes;
    const double small = plan(mission, kind, richness, newly_seen).grant_bytes;
    return 8 * (large - small) / newly_seen;
  };
  EXPECT_NEAR(bits_per_pixel(ProductKind::image, 0), mission.image_bpp_floor, 1e-3);
  EXPECT_NEAR(bits_per_pixel(ProductKind::image, 1), mission.image_bpp_ceiling, 1e-3);
  EXPECT_NEAR(bits_per_pixel(ProductKind::depth, 0), mission.depth_bpp_floor, 1e-3);
  EXPECT_NEAR(bits_per_pixel(ProductKind::depth, 1), mission.depth_bpp_ceiling, 1e-3);
  EXPECT_NEAR(bits_per_pixel(ProductKind::depth, 0.5), (mission.depth_bpp_floor + mission.depth_bpp_ceiling) / 2, 1e-3);
}

TEST(BitPlanTest, OverANarrowLinkDullImagesAreThumbnails) {
  MissionParameters mission;
  const auto image = [&](double budget, double rank, std::uint32_t newly_seen = 60'000) {
    return plan(mission, ProductKind::image, 0.4, newly_seen, budget, rank).scheme;
  };
  constexpr double narrow = 6000;  // the floors alone take 6700
  mission.thumbnail_share = 0;
  EXPECT_EQ(image(narrow, 0), ProductScheme::lossy_region) << "off";
  mission.thumbnail_share = 0.2;
  EXPECT_EQ(image(narrow, 0.19), ProductScheme::thumbnail);
  EXPECT_EQ(image(narrow, 0.2), ProductScheme::lossy_region);
  EXPECT_EQ(image(8000, 0.19), ProductScheme::thumbnail);
  EXPECT_EQ(image(9000, 0.19), ProductScheme::lossy_region);
  EXPECT_EQ(image(0, 0.19), ProductScheme::lossy_region) << "a link without a limit";
  EXPECT_EQ(image(narrow, 0.19, 1000), ProductScheme::lossy_region) << "without loss it is smaller than a thumbnail";
  EXPECT_EQ(plan(mission, ProductKind::depth, 0.4, 60'000, narrow, 0.19).scheme, ProductScheme::lossy_region);
}

TEST(BitPlanTest, OldGroundIsGrantedNothingAndALittleNewGroundWhatItTakesWithoutLoss) {
  const MissionParameters mission;
  for (const ProductKind kind : {ProductKind::image, ProductKind::depth}) {
    EXPECT_EQ(plan(mission, kind, 0.9, 0).grant_bytes, 0U);
  }
  const std::uint32_t headers = plan(mission, ProductKind::image, 0.9, 1).grant_bytes;
  EXPECT_LT(headers, 1600U);
  EXPECT_NEAR(plan(mission, ProductKind::image, 0.9, 1001).grant_bytes, headers + 1000 * 9 / 8, 2);
  EXPECT_GT(plan(mission, ProductKind::image, 0.1, 5000).grant_bytes, 3500U) << "as many as a thumbnail";
}

TEST(BitPlanTest, DepthGoesBeforeItsImageAndBehindARicherOne) {
  const MissionParameters mission;
  const double image = plan(mission, ProductKind::image, 0.5, 60'000).priority;
  const double depth = plan(mission, ProductKind::depth, 0.5, 60'000).priority;
  const double richer = plan(mission, ProductKind::image, 0.502, 60'000).priority;
  EXPECT_GT(depth, image);
  EXPECT_LT(depth, richer);
}

TEST(BitPlanTest, AFasterLinkNeverGivesFewerBytesAndAnAmpleOneAsManyAsNoLimit) {
  MissionParameters mission;
  mission.thumbnail_share = 0.3;
  mission.lossless_share = 0.3;
  for (const ProductKind kind : {ProductKind::image, ProductKind::depth}) {
    for (const double richness : {0.0, 0.06, 0.5, 1.0}) {
      for (const std::uint32_t newly_seen : {0U, 20'000U, 60'000U, 307'200U}) {
        std::uint32_t before = 0;
        for (double budget = 1; budget < 1e6; budget *= 1.1) {
          const std::uint32_t bytes = plan(mission, kind, richness, newly_seen, budget, richness).grant_bytes;
          EXPECT_GE(bytes, before);
          before = bytes;
        }
        EXPECT_EQ(before, plan(mission, kind, richness, newly_seen, 0, richness).grant_bytes);
      }
    }
  }
}

// What a keyframe of middle index and ordinary area is granted follows the link, between floor and ceiling.
TEST(BitPlanTest, GrantsFollowTheLink) {
  const MissionParameters mission;
  const auto ordinary = static_cast<std::uint32_t>((1 - mission.target_overlap) * static_cast<double>(pixels));
  const auto both = [&](double budget) {
    return plan(mission, ProductKind::image, 0.5, ordinary, budget).grant_bytes +
           plan(mission, ProductKind::depth, 0.5, ordinary, budget).grant_bytes;
  };
  for (const double budget : {7000.0, 9000.0, 12000.0}) EXPECT_NEAR(both(budget), 2 * budget, 4) << budget;
  EXPECT_EQ(both(10), both(1000)) << "the floor";
}

TEST(BitPlanTest, TheRichestAreExactWhereTheLinkAllowsIt) {
  MissionParameters mission;
  EXPECT_EQ(plan(mission, ProductKind::image, 0.7, 60'000, 0, 1).scheme, ProductScheme::lossy_region) << "off";
  mission.lossless_share = 0.25;
  EXPECT_EQ(plan(mission, ProductKind::image, 0.7, 60'000, 0, 0.75).scheme, ProductScheme::lossy_region);
  EXPECT_EQ(plan(mission, ProductKind::image, 0.7, 60'000, 0, 0.76).scheme, ProductScheme::lossless_region);
  EXPECT_GE(plan(mission, ProductKind::image, 0.7, 60'000, 0, 0.76).grant_bytes, 60'000U);
  EXPECT_EQ(plan(mission, ProductKind::image, 0.7, 60'000, 5000, 0.76).scheme, ProductScheme::lossy_region);
  EXPECT_EQ(plan(mission, ProductKind::image, 0.7, 60'000, 1e6, 0.76).scheme, ProductScheme::lossless_region);
  EXPECT_EQ(plan(mission, ProductKind::depth, 0.7, 60'000, 0, 0.76).scheme, ProductScheme::lossy_region);
}

TEST(BitPlanTest, TheLinksShareCountsContactOnly) {
  MissionParameters mission;
  mission.link_bytes_per_s = 1000;
  EXPECT_DOUBLE_EQ(link_budget_bytes(mission, 4), 4000);
  mission.pass_period_s = 5000;
  mission.pass_length_s = 500;
  EXPECT_DOUBLE_EQ(link_budget_bytes(mission, 4), 400);
  EXPECT_EQ(link_budget_bytes(mission, 0), 0);
  EXPECT_EQ(link_budget_bytes(mission, -3), 0);
}

TEST(BitPlanTest, NoGrantExceedsWhatAProductMayTake) {
  MissionParameters mission;
  mission.depth_bpp_ceiling = 16;
  mission.image_bpp_ceiling = 16;
  constexpr auto all = static_cast<std::uint32_t>(limits::max_image_pixels);
  for (const ProductKind kind : {ProductKind::image, ProductKind::depth}) {
    EXPECT_LE(plan_bits(mission, kind, {1, all, limits::max_image_pixels, 0}).grant_bytes, limits::max_product_bytes);
  }
}

}  // namespace
}  // namespace ilp
