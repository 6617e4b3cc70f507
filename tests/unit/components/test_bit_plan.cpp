#include <gtest/gtest.h>

#include "fsw/components/bit_plan.hpp"

namespace ilp {
namespace {

constexpr std::size_t pixels = 640 * 480;

TEST(BitPlanTest, ARicherImageNeverGetsFewerBytes) {
  const MissionParameters mission;
  for (const ProductKind kind : {ProductKind::image, ProductKind::depth}) {
    for (const std::uint32_t newly_seen : {1U, 500U, 20'000U, 60'000U, 307'200U}) {
      std::uint32_t before = 0;
      double priority = -1;
      for (int i = 0; i <= 1000; ++i) {
        const BitPlan plan = plan_bits(mission, kind, i / 1000.0, newly_seen, pixels);
        EXPECT_GE(plan.grant_bytes, before) << "index " << i / 1000.0 << ", newly seen " << newly_seen;
        EXPECT_GT(plan.priority, priority);
        before = plan.grant_bytes;
        priority = plan.priority;
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
        const BitPlan plan = plan_bits(mission, kind, richness, newly_seen, pixels);
        EXPECT_GE(plan.grant_bytes, before) << "index " << richness << ", newly seen " << newly_seen;
        before = plan.grant_bytes;
      }
    }
  }
}

TEST(BitPlanTest, BitsPerNewPixelRunFromTheFloorToTheCeiling) {
  MissionParameters mission;
  mission.thumbnail_below = 0;
  constexpr std::uint32_t newly_seen = 100'000;
  const auto bits_per_pixel = [&](ProductKind kind, double richness) {
    // Two areas: what does not depend on the area cancels.
    const double large = plan_bits(mission, kind, richness, 2 * newly_seen, pixels).grant_bytes;
    const double small = plan_bits(mission, kind, richness, newly_seen, pixels).grant_bytes;
    return 8 * (large - small) / newly_seen;
  };
  EXPECT_NEAR(bits_per_pixel(ProductKind::image, 0), mission.image_bpp_floor, 1e-3);
  EXPECT_NEAR(bits_per_pixel(ProductKind::image, 1), mission.image_bpp_ceiling, 1e-3);
  EXPECT_NEAR(bits_per_pixel(ProductKind::depth, 0), mission.depth_bpp_floor, 1e-3);
  EXPECT_NEAR(bits_per_pixel(ProductKind::depth, 1), mission.depth_bpp_ceiling, 1e-3);
  EXPECT_NEAR(bits_per_pixel(ProductKind::depth, 0.5), (mission.depth_bpp_floor + mission.depth_bpp_ceiling) / 2, 1e-3);
}

TEST(BitPlanTest, DullImagesAndThoseOfOldGroundAreThumbnails) {
  const MissionParameters mission;
  EXPECT_EQ(plan_bits(mission, ProductKind::image, 0.04, 60'000, pixels).scheme, ProductScheme::thumbnail);
  EXPECT_EQ(plan_bits(mission, ProductKind::image, 0.06, 60'000, pixels).scheme, ProductScheme::lossy_region);
  EXPECT_EQ(plan_bits(mission, ProductKind::image, 0.9, 0, pixels).scheme, ProductScheme::thumbnail);
  EXPECT_EQ(plan_bits(mission, ProductKind::depth, 0.04, 60'000, pixels).scheme, ProductScheme::lossy_region);
  EXPECT_GT(plan_bits(mission, ProductKind::image, 0.9, 0, pixels).grant_bytes, 2000U);
  EXPECT_LT(plan_bits(mission, ProductKind::image, 0.9, 0, pixels).grant_bytes, 6000U);
}

TEST(BitPlanTest, DepthGoesBeforeItsImageAndBehindARicherOne) {
  const MissionParameters mission;
  const double image = plan_bits(mission, ProductKind::image, 0.5, 60'000, pixels).priority;
  const double depth = plan_bits(mission, ProductKind::depth, 0.5, 60'000, pixels).priority;
  const double richer = plan_bits(mission, ProductKind::image, 0.502, 60'000, pixels).priority;
  EXPECT_GT(depth, image);
  EXPECT_LT(depth, richer);
}

TEST(BitPlanTest, NoGrantExceedsWhatAProductMayTake) {
  MissionParameters mission;
  mission.depth_bpp_ceiling = 16;
  mission.image_bpp_ceiling = 16;
  constexpr auto all = static_cast<std::uint32_t>(limits::max_image_pixels);
  for (const ProductKind kind : {ProductKind::image, ProductKind::depth}) {
    EXPECT_LE(plan_bits(mission, kind, 1, all, limits::max_image_pixels).grant_bytes, limits::max_product_bytes);
  }
}

}  // namespace
}  // namespace ilp
