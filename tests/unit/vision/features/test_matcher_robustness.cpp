// Matching and tracking as a flight does it, under what a flight brings: any yaw, climbs and descents, a change of
// exposure, clipped parts of the image, things that move.
#include <gtest/gtest.h>

#include <memory>

#include "fsw/base/argument.hpp"
#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"
#include "tests/unit/vision/features/known_pair.hpp"

namespace ilp {
namespace {

using test::about_centre;
using test::KnownPair;

struct Tracked {
  Corners corners_a, corners_b;
  Matches matches;

  Tracked(const test::Image& a, const test::Image& b, const Similarity2& predicted) {
    const auto harris = std::make_unique<HarrisWorkspace>();
    const auto matcher = std::make_unique<MatcherWorkspace>();
    EXPECT_TRUE(detect_corners(a.view(), {}, *harris, corners_a).ok());
    EXPECT_TRUE(detect_corners(b.view(), {}, *harris, corners_b).ok());
    EXPECT_TRUE(match_and_track_corners(a.view(), corners_a, b.view(), corners_b, test::Plane(predicted).b_from_a, {},
                                        *matcher, matches)
                    .ok());
  }
};

struct Quality {
  int visible = 0, matched = 0, wrong = 0;
  double median_px = 0, p95_px = 0;
};

/// `counts` says which places of image b are judged.
template <typename Counts>
Quality judge(const KnownPair& pair, const Tracked& tracked, Counts counts) {
  Quality q;
  for (const Corner& c : tracked.corners_a) q.visible += pair.visible(c.x, c.y) ? 1 : 0;
  std::vector<double> errors;
  for (const Match& m : tracked.matches) {
    if (!counts(static_cast<double>(m.xb), static_cast<double>(m.yb))) continue;
    errors.push_back(pair.error(tracked.corners_a[m.a].x, tracked.corners_a[m.a].y, m.xb, m.yb));
    q.wrong += errors.back() > 1 ? 1 : 0;
  }
  std::sort(errors.begin(), errors.end());
  q.matched = static_cast<int>(errors.size());
  if (errors.empty()) return q;
  q.median_px = errors[errors.size() / 2];
  q.p95_px = errors[errors.size() * 95 / 100];
  return q;
}

Quality judge(const KnownPair& pair, const Tracked& tracked) {
  return judge(pair, tracked, [](double, double) { return true; });
}

/// Predictions have errors: a degree, two per cent, six pixels.
Similarity2 disturbed(const KnownPair& pair) {
  Similarity2 s = pair.b_from_a;
  s.rotation_rad += 0.017;
  s.scale *= 1.02;
  double x, y, u, v;
  test::apply(pair.b_from_a, 319.5, 239.5, x, y);
  test::apply(s, 319.5, 239.5, u, v);
  s.shift_x_px += x - u + 5;
  s.shift_y_px += y - v - 4;
  return s;
}

class AnyYaw : public testing::TestWithParam<int> {};

TEST_P(AnyYaw, IsMatchedAlike) {
  const KnownPair pair(about_centre(1, GetParam() * 3.14159265358979 / 180, 12, -20), {.relief_px = 4});
  const Tracked tracked(pair.a, pair.b, disturbed(pair));
  const Quality q = judge(pair, tracked);
  EXPECT_GT(q.visible, 500);
  EXPECT_GT(q.matched, q.visible * 8 / 10);
  EXPECT_LE(q.wrong, q.matched / 100);
  EXPECT_LT(q.median_px, 0.08);
  EXPECT_LT(q.p95_px, 0.25);
}

INSTANTIATE_TEST_SUITE_P(Degrees, AnyYaw, testing::Values(-157, -90, -45, 23, 68, 112, 135, 180));

class AnyScale : public testing::TestWithParam<int> {};

TEST_P(AnyScale, IsMatched) {
  const double scale = GetParam() / 100.0;
  const KnownPair pair(about_centre(scale, 0.3, 8, -15), {.relief_px = 4});
  const Tracked tracked(pair.a, pair.b, disturbed(pair));
  const Quality q = judge(pair, tracked);
  EXPECT_GT(q.visible, 350);
  EXPECT_GT(q.matched, q.visible * 7 / 10);
  EXPECT_LE(q.wrong, q.matched / 50);
  EXPECT_LT(q.median_px, 0.1);
  EXPECT_LT(q.p95_px, 0.3);
}

INSTANTIATE_TEST_SUITE_P(Percent, AnyScale, testing::Values(70, 80, 90, 111, 125, 140));

TEST(Exposure, HalfAndDoubleAreMatchedAlike) {
  for (const double gain : {0.35, 1.4}) {
    const KnownPair pair(about_centre(0.97, 0.2, 40, 30), {.relief_px = 5, .gain_a = 0.7, .gain = gain});
    const Tracked tracked(pair.a, pair.b, disturbed(pair));
    const Quality q = judge(pair, tracked);
    EXPECT_GT(q.matched, q.visible * 8 / 10) << gain;
    EXPECT_LE(q.wrong, q.matched / 100) << gain;
    EXPECT_LT(q.median_px, 0.12) << gain;
  }
}

TEST(Exposure, HazeThatTakesContrastAndAddsLightIsMatchedAlike) {
  for (const double gain : {0.5, 1.0}) {
    KnownPair pair(about_centre(0.97, 0.2, 40, 30), {.relief_px = 5, .gain_a = 0.7, .gain = 0.7 * gain});
    for (std::uint8_t& value : pair.b.pixels) value = static_cast<std::uint8_t>(std::min(255, value + 60));
    const Tracked tracked(pair.a, pair.b, disturbed(pair));
    const Quality q = judge(pair, tracked);
    EXPECT_GT(q.matched, q.visible * 8 / 10) << gain;
    EXPECT_LE(q.wrong, q.matched / 100) << gain;
    EXPECT_LT(q.median_px, 0.12) << gain;
  }
}

TEST(Exposure, ClippedPartsAreNotMatchedWrongly) {
  // A third of image b is white.
  const KnownPair pair(about_centre(1, 0.1, 40, 30), {.relief_px = 5, .gain_a = 0.9, .gain = 1.8});
  const auto white = std::count(pair.b.pixels.begin(), pair.b.pixels.end(), std::uint8_t{255});
  EXPECT_GT(white, 640 * 480 / 4);
  const Tracked tracked(pair.a, pair.b, disturbed(pair));
  const Quality q = judge(pair, tracked);
  EXPECT_GT(q.matched, q.visible / 3);
  EXPECT_LE(q.wrong, q.matched / 100);
  EXPECT_LT(q.median_px, 0.12);
}

// The sun's reflection stays where it is in the image while the ground moves below it by 20 px: its edge is the
// strongest corner there is and belongs to nothing on the ground.
TEST(Exposure, AGlintIsNotTrackedAsGround) {
  KnownPair pair(about_centre(1, 0.05, 16, 12), {.relief_px = 3});
  for (test::Image* image : {&pair.a, &pair.b}) {
    for (int y = 0; y < 480; ++y) {
      for (int x = 0; x < 640; ++x) {
        // With bays, so that the edge has corners.
        const double angle = std::atan2(y - 200.0, x - 400.0);
        if (std::hypot(x - 400.0, y - 200.0) < 90 + 8 * std::sin(9 * angle)) image->view().at(x, y) = 255;
      }
    }
  }
  const Tracked tracked(pair.a, pair.b, disturbed(pair));
  const Quality q = judge(pair, tracked);
  EXPECT_GT(q.matched, q.visible * 6 / 10);
  EXPECT_LE(q.wrong, q.matched / 100);
}

TEST(MovingTexture, SpoilsNothingElse) {
  const KnownPair pair(about_centre(1, 0.1, 50, 20), {.relief_px = 5, .moving_share = 0.05});
  const Tracked tracked(pair.a, pair.b, disturbed(pair));
  int moving = 0;
  for (int y = 20; y < 480; y += 40) {
    for (int x = 20; x < 640; x += 40) moving += pair.moves(x, y) ? 1 : 0;
  }
  EXPECT_GE(moving, 6);  // of 192
  const Quality all = judge(pair, tracked);
  // Where no part of the patch has moved.
  const Quality still = judge(pair, tracked, [&](double x, double y) {
    return !pair.moves(x - 10, y - 10) && !pair.moves(x + 10, y - 10) && !pair.moves(x - 10, y + 10) &&
           !pair.moves(x + 10, y + 10);
  });
  printf("moving: %d of %d, %d wrong; still: %d, %d wrong, p95 %.3f\n", all.matched, all.visible, all.wrong,
         still.matched, still.wrong, still.p95_px);
  EXPECT_GT(all.matched, all.visible * 7 / 10);
  EXPECT_LE(all.wrong, all.matched * 7 / 100);
  EXPECT_LE(still.wrong, still.matched / 100);
  EXPECT_LT(still.p95_px, 0.25);
}

TEST(BadInput, IdenticalImagesMatchWithoutMotion) {
  const KnownPair pair(Similarity2{}, {});
  const Tracked tracked(pair.a, pair.a, {});
  EXPECT_GT(tracked.matches.size(), 950U);
  for (const Match& m : tracked.matches) {
    EXPECT_NEAR(m.xb, tracked.corners_a[m.a].x, 2e-3F);
    EXPECT_NEAR(m.yb, tracked.corners_a[m.a].y, 2e-3F);
  }
}

TEST(BadInput, BlankImagesGiveNoMatchAndNoError) {
  const KnownPair pair(Similarity2{}, {});
  test::Image blank(640, 480);
  for (const int grey : {0, 90, 255}) {
    std::fill(blank.pixels.begin(), blank.pixels.end(), static_cast<std::uint8_t>(grey));
    EXPECT_TRUE(Tracked(pair.a, blank, {}).matches.empty());
    EXPECT_TRUE(Tracked(blank, pair.a, {}).matches.empty());
    EXPECT_TRUE(Tracked(blank, blank, {}).matches.empty());
  }
}

TEST(BadInput, APredictionThatIsNotFiniteIsRefusedByNumber) {
  const test::Image image(64, 64);
  const auto matcher = std::make_unique<MatcherWorkspace>();
  Corners corners;
  ASSERT_TRUE(corners.push_back({32, 32, 1}));
  Matches matches;
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    for (int i = 0; i < 9; ++i) {
      test::Plane plane(Similarity2{});
      plane.b_from_a[i] = bad;
      const Status status =
          match_and_track_corners(image.view(), corners, image.view(), corners, plane.b_from_a, {}, *matcher, matches);
      EXPECT_TRUE(status.is(StatusCode::invalid_argument));
      EXPECT_EQ(static_cast<Argument>(status.a), Argument::homography);
    }
  }
  const MatcherParams params{.min_score = std::nanf("")};
  const Status status = match_and_track_corners(image.view(), corners, image.view(), corners,
                                                test::Plane(Similarity2{}).b_from_a, params, *matcher, matches);
  EXPECT_TRUE(status.is(StatusCode::invalid_argument));
  EXPECT_EQ(static_cast<Argument>(status.a), Argument::match_parameters);
}

// A track whose position was lost: not a number, and far outside.
TEST(BadInput, CornersThatAreNowhereAreLeftOut) {
  const KnownPair pair(Similarity2{}, {});
  const auto matcher = std::make_unique<MatcherWorkspace>();
  Corners corners_a, corners_b;
  const auto harris = std::make_unique<HarrisWorkspace>();
  ASSERT_TRUE(detect_corners(pair.a.view(), {}, *harris, corners_a).ok());
  corners_b = corners_a;
  for (Corners* corners : {&corners_a, &corners_b}) {
    (*corners)[3].x = std::nanf("");
    (*corners)[4].y = 1e30F;
    (*corners)[5].x = -1e30F;
  }
  Matches matches;
  ASSERT_TRUE(match_and_track_corners(pair.a.view(), corners_a, pair.a.view(), corners_b,
                                      test::Plane(Similarity2{}).b_from_a, {}, *matcher, matches)
                  .ok());
  EXPECT_GT(matches.size(), 900U);
  for (const Match& m : matches) {
    EXPECT_TRUE(m.a < 3 || m.a > 5);
    EXPECT_TRUE(m.b < 3 || m.b > 5);
  }
}

}  // namespace
}  // namespace ilp
