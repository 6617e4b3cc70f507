// Recorded flights against overlaps from homographies fitted to SIFT matches by other software (READMEs of the data).
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "tests/support/strip.hpp"

namespace ilp {
namespace {

struct Strip {
  const char* folder;
  std::vector<double> overlaps;
};

class OverlapOfStrip : public testing::TestWithParam<Strip> {};

TEST_P(OverlapOfStrip, AgreesWithTheReference) {
  const Strip& strip = GetParam();
  const std::vector<test::StripImage> images = test::read_strip(strip.folder);
  if (images.empty()) GTEST_SKIP() << "no data in " << test::data_root << strip.folder;
  if (static_cast<std::size_t>(images[0].camera.width) * static_cast<std::size_t>(images[0].camera.height) >
      limits::max_image_pixels) {
    GTEST_SKIP() << "beyond the limits of the profile " << limits::profile;
  }
  ASSERT_EQ(images.size(), strip.overlaps.size() + 1);
  const auto workspace = std::make_unique<OverlapWorkspace>();
  test::Image a = test::read_strip_image(strip.folder, images[0].name);
  for (std::size_t i = 0; i < strip.overlaps.size(); ++i) {
    const test::Image b = test::read_strip_image(strip.folder, images[i + 1].name);
    ASSERT_FALSE(a.empty() || b.empty());
    for (const OverlapMethod method : {OverlapMethod::ncc, OverlapMethod::sad}) {
      OverlapParams params{.method = method};
      OverlapResult result;
      ASSERT_TRUE(measure_overlap(a.view(), b.view(), params, *workspace, result).ok());
      // Overlaps below the smallest that is searched may be unknown, but not wrong.
      if (result.verdict != OverlapVerdict::ok && strip.overlaps[i] < params.min_overlap) continue;
      EXPECT_EQ(result.verdict, OverlapVerdict::ok) << images[i].name;
      EXPECT_NEAR(result.overlap, strip.overlaps[i], 0.03) << images[i].name;
    }
    a = b;
  }
}

// Pairs of images of the dunes whose cameras are farther apart than the ground that one image shows.
TEST(OverlapOfDistantImages, IsUnknown) {
  const auto images = test::read_strip("aerial_coal_oil_point");
  if (images.empty()) GTEST_SKIP() << "no data in " << test::data_root;
  if (static_cast<std::size_t>(images[0].camera.width) * static_cast<std::size_t>(images[0].camera.height) >
      limits::max_image_pixels) {
    GTEST_SKIP() << "beyond the limits of the profile " << limits::profile;
  }
  const auto workspace = std::make_unique<OverlapWorkspace>();
  int tried = 0;
  for (std::size_t i = 0; i + 12 < images.size(); ++i) {
    const test::StripImage &p = images[i], &q = images[i + 12];
    const double seen = std::max(p.centre[2], q.centre[2]) * std::hypot(p.camera.width, p.camera.height) / p.camera.fx;
    if (std::hypot(p.centre[0] - q.centre[0], p.centre[1] - q.centre[1]) < 1.1 * seen) continue;
    const test::Image a = test::read_strip_image("aerial_coal_oil_point", p.name);
    const test::Image b = test::read_strip_image("aerial_coal_oil_point", q.name);
    OverlapResult result;
    ASSERT_TRUE(measure_overlap(a.view(), b.view(), {}, *workspace, result).ok());
    EXPECT_EQ(result.verdict, OverlapVerdict::overlap_unknown) << p.name << " " << q.name << " " << result.ncc;
    ++tried;
  }
  EXPECT_GE(tried, 5);
}

INSTANTIATE_TEST_SUITE_P(Recorded, OverlapOfStrip,
                         testing::Values(Strip{"aerial_caliterra_a", {0.932, 0.907, 0.827, 0.843, 0.824, 0.844}},
                                         Strip{"aerial_caliterra_climb", {0.814, 0.800, 0.795, 0.811, 0.874, 0.829}},
                                         Strip{"aerial_coal_oil_point",
                                               {0.65, 0.58, 0.39, 0.59, 0.70, 0.92, 0.69, 0.61, 0.52, 0.84,
                                                0.94, 0.53, 0.87, 0.87, 0.55, 0.85, 0.66, 0.62, 0.40, 0.81}}),
                         [](const auto& tested) { return std::string(tested.param.folder); });

}  // namespace
}  // namespace ilp
