// Pairs of keyframes over simulated worlds: those without common ground are never linked, and most of those with enough
// of it are. The truth are the poses and depths of the renderer.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "fsw/base/rng.hpp"
#include "tests/unit/vision/overlap/ground_texture.hpp"
#include "tests/unit/vision/place/place_images.hpp"
#include "tests/unit/vision/place/world_places.hpp"

namespace ilp {
namespace {

using test::WorldView;

struct Tally {
  int pairs = 0, linked = 0;

  [[nodiscard]] double share() const { return pairs == 0 ? 1 : static_cast<double>(linked) / pairs; }
};

/// Tiles of one ground, looked at in several places: what is seen may be any of them.
void add_tiles(std::uint64_t seed, std::vector<WorldView>& views) {
  Rng rng(seed);
  for (const double period : {55.0, 80.0, 130.0}) {
    const test::GroundTexture ground(test::Ground::fractal, seed + static_cast<std::uint64_t>(period));
    for (int k = 0; k < 4; ++k) {
      const double scale = 0.45 + 0.15 * rng.uniform(), turn = 6.28 * rng.uniform();
      const Similarity2 from_image{scale, turn, 1000 * rng.uniform(), 1000 * rng.uniform()};
      test::Exposure exposure;
      exposure.noise = 1.5;
      const test::Image image = test::look_at(ground, {period, period}, from_image, 640, 480, exposure, rng);
      views.push_back({"tiles", ++seed, false, test::features_of(image, ILP_PLACE_FEATURES), {}});
    }
  }
}

/// Each block has its own places.
std::vector<WorldView> views_of_block(int block) {
  std::vector<WorldView> views;
  std::uint64_t seed = ILP_PLACE_SEED + 100 * static_cast<std::uint64_t>(block);
  const int spots = ILP_PLACE_SPOTS;
  test::add_views({"dunes", ++seed, spots, 3, 1, ILP_PLACE_FEATURES}, views);
  for (const char* const world : {"low-sun", "long-dunes", "ripples"}) {
    test::add_views({world, ++seed, spots, 3, 0, ILP_PLACE_FEATURES}, views);
  }
  for (const char* const world : {"mars-plains", "flat", "testbed", "mars-canyon", "titan-shore"}) {
    test::add_views({world, ++seed, (spots + 1) / 4, 3, 1, ILP_PLACE_FEATURES}, views);
  }
  add_tiles(++seed, views);
  return views;
}

/// Median distance between where the verified plane leads the ground of image a and where image b shows it, px.
double error_px(const WorldView& a, const WorldView& b, const PlaceMatch& match) {
  const double* const h = match.plane_newer_from_older;
  std::vector<double> errors;
  for (const Vec3& point : a.truth.ground) {
    Vec2 from, to;
    double depth = 0;
    if (!world::sees(b.truth, point) || !world::project(a.truth, point, from, depth) ||
        !world::project(b.truth, point, to, depth)) {
      continue;
    }
    const double w = h[6] * from.x() + h[7] * from.y() + h[8];
    errors.push_back(std::hypot((h[0] * from.x() + h[1] * from.y() + h[2]) / w - to.x(),
                                (h[3] * from.x() + h[4] * from.y() + h[5]) / w - to.y()));
  }
  if (errors.empty()) return 1e9;
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

class PlaceWorlds : public testing::TestWithParam<int> {};

// Same sun or one that stands 34 degrees further, any heading, heights whose ratios are 0.7 to 1.4.
TEST_P(PlaceWorlds, OtherGroundIsNeverLinkedAndTheSameGroundIs) {
  const std::vector<WorldView> views = views_of_block(GetParam());
  int unrelated = 0;
  double most_evidence = 0;
  std::map<std::string, Tally> same_sun, further_sun;
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const WorldView &a = views[k], &b = views[i];
      const bool other_ground = test::nothing_in_common(a, b);
      const bool enough = !other_ground && test::common_ground(a, b) >= 0.3;
      if (!other_ground && !enough) continue;
      const PlaceMatch match = test::verify(a.features, b.features);
      const bool linked = match.verdict == PlaceVerdict::verified;
      if (other_ground) {
        ++unrelated;
        if (match.verdict != PlaceVerdict::ambiguous) most_evidence = std::max(most_evidence, match.evidence);
        EXPECT_FALSE(linked) << a.world << " " << a.seed << " (view " << k << ") " << b.world << " " << b.seed
                             << " (view " << i << "): evidence " << match.evidence;
        continue;
      }
      Tally& tally = (a.further_sun == b.further_sun ? same_sun : further_sun)[a.world];
      ++tally.pairs;
      tally.linked += linked ? 1 : 0;
      if (!linked) continue;
      EXPECT_LT(error_px(a, b, match), 25) << a.world << " " << a.seed << " " << k << " " << i;
    }
  }
  EXPECT_GE(unrelated, ILP_PLACE_PAIRS);
  std::printf("%d pairs without common ground, evidence up to %.1f\n", unrelated, most_evidence);
  for (const auto& [world, tally] : same_sun) {
    const Tally& further = further_sun[world];
    std::printf("%-12s same sun %d of %d, further sun %d of %d\n", world.c_str(), tally.linked, tally.pairs,
                further.linked, further.pairs);
  }
  Tally other_same, other_further;
  for (const char* const world : {"mars-plains", "flat", "testbed", "mars-canyon", "titan-shore"}) {
    other_same.pairs += same_sun[world].pairs;
    other_same.linked += same_sun[world].linked;
    other_further.pairs += further_sun[world].pairs;
    other_further.linked += further_sun[world].linked;
  }
  EXPECT_GE(other_same.share(), 0.95);
  EXPECT_GE(other_further.share(), 0.7);
  EXPECT_GE(same_sun["dunes"].share(), 0.6);
}
INSTANTIATE_TEST_SUITE_P(ILP_PLACE_SUITE, PlaceWorlds, testing::Range(0, ILP_PLACE_BLOCKS));

}  // namespace
}  // namespace ilp
