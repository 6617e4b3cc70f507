// Registration over simulated worlds, whose truth is known: how many keyframes are fixed, how well, and that ground
// which is not there never is.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "fsw/base/math.hpp"
#include "tests/unit/vision/map/map_world.hpp"

namespace ilp::test {
namespace {

constexpr int keyframes = ILP_MAP_KEYFRAMES;
constexpr int false_windows = ILP_MAP_FALSE_WINDOWS;  // of each keyframe and kind
constexpr std::uint64_t first_seed = ILP_MAP_SEED;

struct Ground {
  const char* world;
  double ratio;       // map pixels in image pixels
  double sun_offset;  // degrees
  double least_share;
  double median_px, most_px;  // of the ground's error; the second of 95 %
};

void PrintTo(const Ground& ground, std::ostream* out) {
  *out << ground.world << ", " << ground.ratio << " image pixels, suns " << ground.sun_offset << " degrees apart";
}

OrbitalMap map_of(const MapWorld& world, double ratio, double sun_offset_deg) {
  OrbitalMapParams params;
  params.pixel_m = ratio * world.image_pixel_m();
  params.seed = first_seed;
  return world.map(sun_offset_deg * pi / 180, params);
}

class ILP_MAP_SUITE : public testing::TestWithParam<Ground> {};

TEST_P(ILP_MAP_SUITE, KeyframesAreFixedWhereTheyAre) {
  const Ground& ground = GetParam();
  const MapWorld world(ground.world, first_seed);
  const OrbitalMap map = map_of(world, ground.ratio, ground.sun_offset);
  Rng rng(first_seed, 3);
  WindowStore store;
  MapTrial trial;
  MapTally tally;
  for (int k = 0; k < keyframes; ++k) {
    world.look_anywhere({}, rng, trial);
    const MapPlan plan = plan_of(trial, map);
    tally.add(register_on_map(trial, plan, store.fill(map, plan), world.sun()), trial, plan.pixel_m);
  }
  EXPECT_EQ(tally.wrong, 0);
  EXPECT_GE(tally.fixed, std::floor(ground.least_share * tally.trials));
  EXPECT_LE(tally.ground_quantile(0.5), ground.median_px);
  EXPECT_LE(tally.ground_quantile(0.95), ground.most_px);
  RecordProperty("fixed", tally.fixed);
  std::printf("%s ratio %.1f sun %.0f: fixed %d of %d, wrong %d, ground %.2f and %.2f px, NEES / 3 %.2f\n",
              ground.world, ground.ratio, ground.sun_offset, tally.fixed, tally.trials, tally.wrong,
              tally.ground_quantile(0.5), tally.ground_quantile(0.95), tally.mean_nees());
  EXPECT_GT(tally.mean_nees(), 0.25);
  EXPECT_LT(tally.mean_nees(), 2.5);
}

#ifdef ILP_MAP_LONG
const Ground recall_grounds[] = {{"mars-plains", 1.4, 34, 0.95, 0.35, 0.8}, {"mars-plains", 3, 34, 0.95, 0.35, 0.8},
                                 {"mars-plains", 5, 34, 0.95, 0.35, 0.8},   {"mars-canyon", 0.9, 34, 0.95, 0.35, 0.8},
                                 {"mars-canyon", 3, 34, 0.95, 0.35, 0.8},   {"mars-canyon", 5, 34, 0.95, 0.35, 0.8},
                                 {"dunes", 1.4, 34, 0.95, 0.35, 0.8},       {"dunes", 3, 34, 0.95, 0.35, 0.8},
                                 {"dunes", 5, 34, 0.95, 0.35, 0.8},         {"mars-plains", 10, 34, 0.9, 0.35, 0.8},
                                 {"mars-canyon", 10, 34, 0.9, 0.35, 0.8},   {"dunes", 10, 34, 0.9, 0.35, 0.8},
                                 {"mars-plains", 1.4, 90, 0.95, 0.6, 1.5},  {"mars-plains", 3, 90, 0.95, 0.6, 1.5},
                                 {"mars-plains", 3, 180, 0.95, 0.6, 1.5},   {"mars-canyon", 0.9, 90, 0.95, 0.6, 1.5},
                                 {"mars-canyon", 3, 90, 0.95, 0.6, 1.5},    {"mars-canyon", 3, 180, 0.95, 0.6, 1.5}};
const Ground false_grounds[] = {{"mars-plains", 4.5, 34, 0, 0, 0}, {"mars-plains", 10, 90, 0, 0, 0},
                                {"dunes", 4.5, 34, 0, 0, 0},       {"dunes", 10, 34, 0, 0, 0},
                                {"dunes", 4.5, 90, 0, 0, 0},       {"dunes", 10, 0, 0, 0, 0},
                                {"mars-canyon", 4.5, 34, 0, 0, 0}, {"mars-canyon", 10, 90, 0, 0, 0}};
#else
const Ground recall_grounds[] = {{"mars-plains", 5, 34, 1, 0.35, 0.8},
                                 {"mars-plains", 3, 90, 1, 0.6, 1.5},
                                 {"mars-canyon", 3, 180, 1, 0.6, 1.5},
                                 {"dunes", 5, 34, 0.75, 0.35, 0.8}};
const Ground false_grounds[] = {{"dunes", 4.5, 34, 0, 0, 0}, {"mars-plains", 10, 90, 0, 0, 0}};
#endif

INSTANTIATE_TEST_SUITE_P(Recall, ILP_MAP_SUITE, testing::ValuesIn(recall_grounds));

/// Where a window of a false trial is taken from.
enum class Lie { other_seed, other_seed_mirrored, own_mirrored, elsewhere, outside_window };
constexpr Lie lies[] = {Lie::other_seed, Lie::other_seed_mirrored, Lie::own_mirrored, Lie::elsewhere,
                        Lie::outside_window};

double between(double low, double high, Rng& rng) {
  return low + (high - low) * rng.uniform();
}

/// The shift of the window, px, so that the place of the keyframe is not in it, nor at its edge.
Vec2 leave_window(Lie lie, const MapPlan& plan, Rng& rng) {
  const double reach = plan.search_px;
  // At least 1 px beyond the window, along one of the axes.
  const double least = lie == Lie::outside_window ? reach + 1 : 2.5 * reach;
  const double most = lie == Lie::outside_window ? 2.5 * reach : 5 * reach;
  const double far = between(least, most, rng) * (rng.below(2) == 0 ? 1 : -1), any = between(-most, most, rng);
  return rng.below(2) == 0 ? Vec2(far, any) : Vec2(any, far);
}

class ILP_MAP_FALSE_SUITE : public testing::TestWithParam<Ground> {};

TEST_P(ILP_MAP_FALSE_SUITE, GroundThatIsNotThereIsNeverFixed) {
  const Ground& ground = GetParam();
  const MapWorld world(ground.world, first_seed + 1);
  const OrbitalMap own = map_of(world, ground.ratio, ground.sun_offset);
  const OrbitalMap other = map_of(MapWorld(ground.world, first_seed + 2), ground.ratio, ground.sun_offset);
  const OrbitalMap own_mirrored = mirrored(own), other_mirrored = mirrored(other);
  Rng rng(first_seed, 4);
  WindowStore store;
  MapTrial trial;
  int trials[5] = {}, fixed[5] = {};
  double evidence[5] = {-100, -100, -100, -100, -100};
  for (int k = 0; k < keyframes; ++k) {
    world.look_anywhere({}, rng, trial);
    for (int n = 0; n < false_windows; ++n) {
      for (const Lie lie : lies) {
        const MapPlan plan = plan_of(trial, own);
        const Vec2 truth = true_shift_px(world, trial, plan);
        Vec2 moved;  // of the window's content
        const OrbitalMap* map = &own;
        if (lie == Lie::elsewhere || lie == Lie::outside_window) {
          moved = truth - leave_window(lie, plan, rng);
        } else {
          map = lie == Lie::other_seed ? &other : (lie == Lie::own_mirrored ? &own_mirrored : &other_mirrored);
          moved = Vec2(between(-60, 60, rng), between(-60, 60, rng));
        }
        const double pixel = plan.pixel_m;
        const MapWindow window = store.fill(*map, plan, std::round(moved.x()) * pixel, std::round(moved.y()) * pixel);
        const MapFixResult result = register_on_map(trial, plan, window, world.sun());
        const auto kind = static_cast<std::size_t>(lie);
        if (result.verdict == MapVerdict::no_map || result.verdict == MapVerdict::no_texture) continue;
        ++trials[kind];
        fixed[kind] += result.verdict == MapVerdict::fixed ? 1 : 0;
        const bool at_edge =
            std::max(std::fabs(result.shift_px[0]), std::fabs(result.shift_px[1])) > plan.search_px - map_edge_px;
        if (result.quarters >= 3 && !at_edge) evidence[kind] = std::max(evidence[kind], result.evidence);
      }
    }
  }
  for (const Lie lie : lies) {
    const auto kind = static_cast<std::size_t>(lie);
    EXPECT_EQ(fixed[kind], 0) << "lie " << kind;
    std::printf("%s ratio %.1f sun %.0f lie %zu: %d false of %d, largest evidence %.1f\n", ground.world, ground.ratio,
                ground.sun_offset, kind, fixed[kind], trials[kind], evidence[kind]);
  }
}

INSTANTIATE_TEST_SUITE_P(False, ILP_MAP_FALSE_SUITE, testing::ValuesIn(false_grounds));

}  // namespace
}  // namespace ilp::test
