// Recorded flights: matches against the epipolar geometry of reference cameras from other software. The prediction is
// our own overlap check, as in flight.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"
#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "tests/support/strip.hpp"

namespace ilp {
namespace {

class MatchesOfStrip : public testing::TestWithParam<const char*> {};

void expect_on_epipolar_lines(const test::StripImage& a, const test::StripImage& b, const Corners& corners_a,
                              const Matches& matches, double least) {
  std::vector<double> errors;
  for (const Match& m : matches) {
    errors.push_back(test::epipolar_distance(a, b, corners_a[m.a].x, corners_a[m.a].y, m.xb, m.yb));
  }
  std::sort(errors.begin(), errors.end());
  ASSERT_GE(static_cast<double>(errors.size()), least) << a.name;
  const auto count = static_cast<double>(errors.size());
  const double share =
      static_cast<double>(std::lower_bound(errors.begin(), errors.end(), 1.0) - errors.begin()) / count;
  const double median = errors[errors.size() / 2];
  EXPECT_GT(share, 0.97) << a.name;
  EXPECT_LT(median, 0.16) << a.name;
  printf("%s %s: %zu matches, %.1f %% within 1 px, median %.3f px\n", a.name.c_str(), b.name.c_str(), errors.size(),
         100 * share, median);
}

TEST_P(MatchesOfStrip, LieOnTheEpipolarLines) {
  const std::string folder = GetParam();
  const auto images = test::read_strip(folder);
  if (images.empty()) GTEST_SKIP() << "no data in " << test::data_root << folder;
  if (static_cast<std::size_t>(images[0].camera.width) * static_cast<std::size_t>(images[0].camera.height) >
      limits::max_image_pixels) {
    GTEST_SKIP() << "beyond the limits of the profile " << limits::profile;
  }
  const auto overlap_workspace = std::make_unique<OverlapWorkspace>();
  const auto harris_workspace = std::make_unique<HarrisWorkspace>();
  const auto matcher_workspace = std::make_unique<MatcherWorkspace>();
  Corners corners_a, corners_b;
  test::Image a = test::read_strip_image(folder, images[0].name);
  ASSERT_TRUE(detect_corners(a.view(), {}, *harris_workspace, corners_a).ok());
  for (std::size_t i = 0; i + 1 < images.size(); ++i) {
    const test::Image b = test::read_strip_image(folder, images[i + 1].name);
    ASSERT_TRUE(detect_corners(b.view(), {}, *harris_workspace, corners_b).ok());
    OverlapParams params{.min_overlap = 0.35};
    OverlapResult overlap;
    ASSERT_TRUE(measure_overlap(a.view(), b.view(), params, *overlap_workspace, overlap).ok());
    ASSERT_EQ(overlap.verdict, OverlapVerdict::ok) << images[i].name;
    Matches matches;
    ASSERT_TRUE(match_corners_by_plane(a.view(), corners_a, b.view(), corners_b, overlap.plane_b_from_a, {},
                                       *matcher_workspace, matches)
                    .ok());
    // A thousand corners, of which the overlap is seen twice and more than four in ten detected twice.
    expect_on_epipolar_lines(images[i], images[i + 1], corners_a, matches, 420 * overlap.overlap);

    Corners longer_b = corners_b;
    ASSERT_TRUE(match_and_track_corners(a.view(), corners_a, b.view(), longer_b, overlap.plane_b_from_a, {},
                                        *matcher_workspace, matches)
                    .ok());
    expect_on_epipolar_lines(images[i], images[i + 1], corners_a, matches, 800 * overlap.overlap);
    a = b;
    corners_a = corners_b;
  }
}

INSTANTIATE_TEST_SUITE_P(Recorded, MatchesOfStrip,
                         testing::Values("aerial_caliterra_a", "aerial_caliterra_climb", "aerial_coal_oil_point"),
                         [](const auto& tested) { return std::string(tested.param); });

}  // namespace
}  // namespace ilp
