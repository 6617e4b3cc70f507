#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"
#include "tests/unit/vision/features/known_pair.hpp"

namespace ilp {
namespace {

Corners detect(const test::Image& image) {
  static const auto workspace = std::make_unique<HarrisWorkspace>();
  Corners corners;
  EXPECT_TRUE(detect_corners(image.view(), {}, *workspace, corners).ok());
  return corners;
}

MatcherWorkspace& workspace() {
  static const auto w = std::make_unique<MatcherWorkspace>();
  return *w;
}

using Pair = test::KnownPair;
using test::about_centre;
using test::Plane;

struct Case {
  const char* name;
  double scale, rotation_rad, shift_x, shift_y, relief_px, gain, offset, noise;
};

class MatchesOfPair : public testing::TestWithParam<Case> {};

TEST_P(MatchesOfPair, AreManyRightAndExact) {
  const Case& c = GetParam();
  const Pair pair(about_centre(c.scale, c.rotation_rad, c.shift_x, c.shift_y),
                  {.relief_px = c.relief_px, .gain = c.gain, .offset = c.offset, .noise = c.noise});
  const Corners corners_a = detect(pair.a), corners_b = detect(pair.b);
  Matches matches;
  ASSERT_TRUE(
      match_corners(pair.a.view(), corners_a, pair.b.view(), corners_b, pair.b_from_a, {}, workspace(), matches).ok());
  std::vector<double> errors;
  std::vector<bool> used_b(corners_b.size());
  int previous = -1;
  for (const Match& m : matches) {
    EXPECT_GT(static_cast<int>(m.a), previous);
    previous = m.a;
    EXPECT_FALSE(used_b[m.b]) << "corner b matched twice";
    used_b[m.b] = true;
    EXPECT_LE(std::hypot(m.xb - corners_b[m.b].x, m.yb - corners_b[m.b].y), 3.01);
    EXPECT_TRUE(m.score >= 0.7F && m.score <= 1);
    errors.push_back(pair.error(corners_a[m.a].x, corners_a[m.a].y, m.xb, m.yb));
  }
  ASSERT_GE(errors.size(), 250U);
  std::sort(errors.begin(), errors.end());
  const auto right = static_cast<double>(std::lower_bound(errors.begin(), errors.end(), 1.0) - errors.begin());
  EXPECT_GT(right / static_cast<double>(errors.size()), 0.98);
  EXPECT_LT(errors[errors.size() / 2], 0.025 + 0.035 * c.noise / c.gain);
  EXPECT_LT(errors[errors.size() * 95 / 100], 0.06 + 0.09 * c.noise / c.gain);
}

INSTANTIATE_TEST_SUITE_P(Synthetic, MatchesOfPair,
                         testing::Values(Case{"shifted", 1, 0, 80, -35.5, 0, 1, 0, 1},
                                         Case{"turned_half_round", 1, 3.0, 20, 10, 4, 1, 0, 1},
                                         Case{"climbing", 0.86, 0.17, 15, 70, 6, 1, 0, 1},
                                         Case{"sinking", 1.15, -0.12, -20, 30, 6, 1, 0, 1},
                                         Case{"rough", 1, 0.03, 60, 40, 20, 1, 0, 1},
                                         Case{"exposure_and_noise", 0.97, 0.05, 50, 60, 5, 0.6, 40, 1.5}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST(Matcher, TrackingFindsWhatTheDetectorMissed) {
  const Pair pair(about_centre(0.9, 0.1, 30, 60), {.relief_px = 12, .gain = 0.8, .offset = 10});
  const Corners corners_a = detect(pair.a), detected_b = detect(pair.b);
  const Plane plane(pair.b_from_a);
  Matches detected, tracked;
  Corners corners_b = detected_b;
  ASSERT_TRUE(match_corners_by_plane(pair.a.view(), corners_a, pair.b.view(), detected_b, plane.b_from_a, {},
                                     workspace(), detected)
                  .ok());
  ASSERT_TRUE(match_and_track_corners(pair.a.view(), corners_a, pair.b.view(), corners_b, plane.b_from_a, {},
                                      workspace(), tracked)
                  .ok());

  int visible = 0;
  for (const Corner& corner : corners_a) {
    visible += pair.visible(corner.x, corner.y) ? 1 : 0;
  }
  EXPECT_GT(static_cast<int>(tracked.size()), visible * 8 / 10);
  EXPECT_GT(tracked.size(), detected.size() * 5 / 4);
  std::vector<bool> used_b(corners_b.size());
  std::vector<double> errors;
  for (const Match& m : tracked) {
    EXPECT_FALSE(used_b[m.b]);
    used_b[m.b] = true;
    errors.push_back(pair.error(corners_a[m.a].x, corners_a[m.a].y, m.xb, m.yb));
    if (m.b >= detected_b.size()) {
      EXPECT_EQ(corners_b[m.b].x, m.xb);
      EXPECT_EQ(corners_b[m.b].response, 0);
    }
  }
  ASSERT_FALSE(errors.empty());
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.08);
  EXPECT_LT(errors[errors.size() * 95 / 100], 0.25);
  // What was detected stays what it was.
  for (std::size_t i = 0; i < detected_b.size(); ++i) EXPECT_EQ(corners_b[i].x, detected_b[i].x);
  EXPECT_EQ(corners_b.size() - detected_b.size(),
            static_cast<std::size_t>(std::count_if(tracked.begin(), tracked.end(),
                                                   [&](const Match& m) { return m.b >= detected_b.size(); })));
}

TEST(Matcher, TrackingStopsAtTheCapacity) {
  const Pair pair(about_centre(1, 0, 20, 10), {});
  const Corners corners_a = detect(pair.a);
  Corners corners_b;
  // Corners in a flat frame around the image cannot match, but fill the list up to three free places.
  for (std::size_t i = 0; i + 3 < corners_b.capacity(); ++i) {
    const Corner filler{1, 1, 0.1F};
    ASSERT_TRUE(corners_b.push_back(i < 60 ? Corner{corners_a[i].x + 20, corners_a[i].y + 10, 1} : filler));
  }
  Matches matches;
  const Plane plane({1, 0, 20, 10});
  ASSERT_TRUE(match_and_track_corners(pair.a.view(), corners_a, pair.b.view(), corners_b, plane.b_from_a, {},
                                      workspace(), matches)
                  .ok());
  EXPECT_TRUE(corners_b.full());
  EXPECT_GT(matches.size(), 40U);
  EXPECT_LE(matches.size(), 63U);
}

// Six keyframes; each match starts where the previous match ended, as a track does.
TEST(Matcher, TracksAreLongAndDoNotDrift) {
  constexpr std::size_t frames = 6;
  std::vector<test::Image> images;
  std::vector<Similarity2> world_from_image;
  for (std::size_t k = 0; k < frames; ++k) {
    const double t = static_cast<double>(k);
    world_from_image.push_back(
        test::compose({1, 0, 2000, 900}, about_centre(1 + 0.02 * t, 0.05 * t, 31.3 * t, 44.7 * t)));
    images.push_back(test::render_texture(640, 480, world_from_image[k], 1, 0, 1, k));
  }
  // Where on the ground the track of each corner of the latest image began, if it began in the first image.
  struct Origin {
    bool known = false;
    double x = 0, y = 0;
  };
  Corners at = detect(images[0]);
  std::vector<Origin> origins(at.size());
  int visible = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    origins[i].known = true;
    test::apply(world_from_image[0], at[i].x, at[i].y, origins[i].x, origins[i].y);
    double x, y;
    test::apply(test::inverse(world_from_image[frames - 1]), origins[i].x, origins[i].y, x, y);
    visible += x > 12 && y > 12 && x < 627 && y < 467 ? 1 : 0;
  }
  for (std::size_t k = 0; k + 1 < frames; ++k) {
    Corners next = detect(images[k + 1]);
    const Plane plane(test::compose(test::inverse(world_from_image[k + 1]), world_from_image[k]));
    Matches matches;
    ASSERT_TRUE(match_and_track_corners(images[k].view(), at, images[k + 1].view(), next, plane.b_from_a, {},
                                        workspace(), matches)
                    .ok());
    std::vector<Origin> carried(next.size());
    for (const Match& m : matches) {
      carried[m.b] = origins[m.a];
      next[m.b].x = m.xb;
      next[m.b].y = m.yb;
    }
    at = next;
    origins = carried;
  }
  std::vector<double> drift;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (!origins[i].known) continue;
    double x, y;
    test::apply(test::inverse(world_from_image[frames - 1]), origins[i].x, origins[i].y, x, y);
    drift.push_back(std::hypot(at[i].x - x, at[i].y - y));
  }
  EXPECT_GT(static_cast<int>(drift.size()), visible * 6 / 10) << visible;
  ASSERT_FALSE(drift.empty());
  std::sort(drift.begin(), drift.end());
  EXPECT_LT(drift[drift.size() / 2], 0.12);
  EXPECT_LT(drift[drift.size() * 9 / 10], 0.3);
}

TEST(Matcher, RepeatedPatternIsAmbiguousNotMatched) {
  // One tile of texture, 32 px wide, again and again: every corner has twins within the search radius.
  test::Image image(640, 480);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      image.view().at(x, y) =
          static_cast<std::uint8_t>(std::clamp(test::fractal_texture(x % 32, y % 32, 5, 1), 0.0, 255.0));
    }
  }
  const Corners corners = detect(image);
  ASSERT_GT(corners.size(), 100U);
  Matches matches;
  ASSERT_TRUE(match_corners(image.view(), corners, image.view(), corners, {}, {}, workspace(), matches).ok());
  EXPECT_LT(matches.size(), corners.size() / 20);
}

TEST(Matcher, OtherGroundGivesHardlyAMatch) {
  const test::Image a = test::render_texture(640, 480, {1, 0, 0, 0}, 1, 0, 2, 1);
  const test::Image b = test::render_texture(640, 480, {1, 0, 9000, 0}, 1, 0, 2, 2);
  const Corners corners_a = detect(a), corners_b = detect(b);
  Matches matches;
  ASSERT_TRUE(match_corners(a.view(), corners_a, b.view(), corners_b, {}, {}, workspace(), matches).ok());
  EXPECT_LT(matches.size(), corners_a.size() / 30);
}

TEST(Matcher, SearchesNoFartherThanTheRadius) {
  const Pair pair(about_centre(1, 0, 40, 0), {.noise = 2});
  const Corners corners_a = detect(pair.a), corners_b = detect(pair.b);
  Matches matches;
  MatcherParams params{.search_radius_px = 30};
  ASSERT_TRUE(match_corners(pair.a.view(), corners_a, pair.b.view(), corners_b, {}, params, workspace(), matches).ok());
  EXPECT_LT(matches.size(), corners_a.size() / 30);
  params.search_radius_px = 45;
  ASSERT_TRUE(match_corners(pair.a.view(), corners_a, pair.b.view(), corners_b, {}, params, workspace(), matches).ok());
  EXPECT_GT(matches.size(), 250U);
}

TEST(Matcher, RefusesBadArgumentsAndBearsEmptyLists) {
  const test::Image image = test::render_texture(160, 120, {}, 1, 0, 2, 1);
  const Corners corners = detect(image), nothing;
  Matches matches;
  MatcherParams params{.patch_side_px = 14};
  EXPECT_TRUE(match_corners(image.view(), corners, image.view(), corners, {}, params, workspace(), matches)
                  .is(StatusCode::invalid_argument));
  params = {};
  Similarity2 wild{.shift_x_px = std::nan("")};
  EXPECT_TRUE(match_corners(image.view(), corners, image.view(), corners, wild, params, workspace(), matches)
                  .is(StatusCode::invalid_argument));
  EXPECT_TRUE(match_corners(image.view(), corners, image.view(), nothing, {}, params, workspace(), matches).ok());
  EXPECT_TRUE(match_corners(image.view(), nothing, image.view(), corners, {}, params, workspace(), matches).ok());
  EXPECT_TRUE(matches.empty());
  // Corners outside of the image, as a caller's mistake or a track leaving the image may give them, are not matched.
  Corners outside;
  ASSERT_TRUE(outside.push_back({-50, 10, 1}) && outside.push_back({1e9F, 1e9F, 1}));
  EXPECT_TRUE(match_corners(image.view(), outside, image.view(), outside, {}, params, workspace(), matches).ok());
  EXPECT_TRUE(matches.empty());
}

}  // namespace
}  // namespace ilp
