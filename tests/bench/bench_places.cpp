// Knowing ground again, 640x480: features of an image, and the index with all its places. Beside them the corners of
// the flight's own matching (bench_features, harris/1000) as the unit in which docs/budgets.md states times.
#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/place/place_feature_workspace.hpp"
#include "fsw/vision/place/place_index.hpp"
#include "fsw/vision/place/place_match_workspace.hpp"
#include "fsw/vision/place/place_patches.hpp"
#include "tests/support/strip.hpp"

namespace ilp {
namespace {

HarrisWorkspace& harris_workspace() {
  static const auto workspace = std::make_unique<HarrisWorkspace>();
  return *workspace;
}

/// Place `number` of an endless landscape.
PlaceFeatures features_at(int number, double rotation_rad, std::size_t wanted = limits::place_features) {
  static const auto workspace = std::make_unique<PlaceFeatureWorkspace>();
  const test::Image image =
      test::render_texture(640, 480, {1, rotation_rad, 1000.0 + 700 * number, 2000}, 0.7, 0, 1, 7);
  PlaceFeatures features;
  (void)find_place_features(image.view(), wanted, harris_workspace(), *workspace, features).ok();
  return features;
}

std::span<const PlaceFeature> all(const PlaceFeatures& features) {
  return {features.data(), features.size()};
}

void corners_of_matching(benchmark::State& state) {
  const test::Image image = test::render_texture(640, 480, {1, 0, 1000, 2000}, 1, 0, 1, 1);
  Corners corners;
  for (auto _ : state) benchmark::DoNotOptimize(detect_corners(image.view(), {}, harris_workspace(), corners));
}
BENCHMARK(corners_of_matching)->Unit(benchmark::kMillisecond);

void find_features(benchmark::State& state) {
  static const auto workspace = std::make_unique<PlaceFeatureWorkspace>();
  const test::Image image = test::render_texture(640, 480, {1, 0, 1000, 2000}, 1, 0, 1, 1);
  PlaceFeatures features;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        find_place_features(image.view(), limits::place_features, harris_workspace(), *workspace, features));
  }
  state.counters["features"] = static_cast<double>(features.size());
}
BENCHMARK(find_features)->Unit(benchmark::kMillisecond);

/// Distinct places by few images: some bits of each descriptor and all angles change from one to the next.
PlaceFeatures altered(const PlaceFeatures& from, std::uint64_t seed) {
  PlaceFeatures features = from;
  Rng rng(seed);
  const auto turn = static_cast<std::uint8_t>(rng.below(256));
  for (PlaceFeature& feature : features) {
    feature.angle = static_cast<std::uint8_t>(feature.angle + turn);
    for (int k = 0; k < 40; ++k) feature.descriptor[rng.below(8)] ^= 1U << rng.below(32);
  }
  return features;
}

struct FullIndex {
  static constexpr int images = 48;
  std::vector<PlaceFeatures> seen;
  std::unique_ptr<PlaceIndex> index = std::make_unique<PlaceIndex>();

  explicit FullIndex(std::size_t places) {
    for (int k = 0; k < images; ++k) seen.push_back(features_at(k, 0.1 * k));
    index->clear();
    for (std::size_t slot = 0; slot < places; ++slot) {
      (void)index->insert(slot, static_cast<std::int64_t>(slot), all(altered(seen[slot % images], slot))).ok();
    }
  }
};

void query(benchmark::State& state) {
  const FullIndex full(static_cast<std::size_t>(state.range(0)));
  const auto workspace = std::make_unique<PlaceQueryWorkspace>();
  PlaceCandidates best;
  int k = 0;
  for (auto _ : state) {
    (void)full.index->query(all(full.seen[static_cast<std::size_t>(k++ % FullIndex::images)]), limits::max_places,
                            *workspace, best);
    benchmark::DoNotOptimize(best);
  }
  state.counters["votes"] = best.empty() ? 0 : best[0].votes;
}
BENCHMARK(query)->Arg(31)->Arg(500)->Arg(limits::max_places)->Unit(benchmark::kMillisecond);

/// Takes one place out of a full index and puts another one in.
void replace(benchmark::State& state) {
  const FullIndex full(limits::max_places);
  std::size_t slot = limits::place_vocabulary_places;
  for (auto _ : state) {
    benchmark::DoNotOptimize(full.index->remove(slot));
    benchmark::DoNotOptimize(full.index->insert(slot, 5000, all(full.seen[slot % FullIndex::images])));
    slot = slot + 1 < limits::max_places ? slot + 1 : limits::place_vocabulary_places;
  }
}
BENCHMARK(replace)->Unit(benchmark::kMillisecond);

/// The place with which the vocabulary becomes complete.
void complete_vocabulary(benchmark::State& state) {
  const FullIndex nearly(limits::place_vocabulary_places - 1);
  const auto index = std::make_unique<PlaceIndex>();
  for (auto _ : state) {
    state.PauseTiming();
    *index = *nearly.index;
    state.ResumeTiming();
    benchmark::DoNotOptimize(index->insert(limits::place_vocabulary_places - 1, 5000, all(nearly.seen.back())));
  }
}
BENCHMARK(complete_vocabulary)->Unit(benchmark::kMillisecond);

/// Arguments: shift along x, px; beyond 640 the two images have nothing in common; features of each.
void verify(benchmark::State& state) {
  static const auto workspace = std::make_unique<PlaceMatchWorkspace>();
  static const auto features_workspace = std::make_unique<PlaceFeatureWorkspace>();
  const auto wanted = static_cast<std::size_t>(state.range(1));
  const PlaceFeatures older = features_at(3, 0, wanted);
  const test::Image image =
      test::render_texture(640, 480, {1.1, 0.4, 3100.0 + static_cast<double>(state.range(0)), 2000}, 0.7, 0, 1, 7);
  PlaceFeatures newer;
  (void)find_place_features(image.view(), wanted, harris_workspace(), *features_workspace, newer).ok();
  PlaceMatch match;
  for (auto _ : state) {
    benchmark::DoNotOptimize(verify_place(all(older), all(newer), least_place_evidence, *workspace, match));
  }
  state.SetLabel(name_of(match.verdict));
  state.counters["pairs"] = static_cast<double>(match.pairs.size());
}
BENCHMARK(verify)
    ->Args({0, limits::place_features})
    ->Args({5000, limits::place_features})
    ->Args({0, limits::max_place_features})
    ->Args({5000, limits::max_place_features})
    ->Unit(benchmark::kMillisecond);

Status all_patches(GrayView image, PlacePatchWorkspace& workspace, PlacePatches& patches) {
  ILP_TRY(begin_place_patches(image, harris_workspace(), workspace, patches));
  return do_all([&] { return place_patches_slice(image, harris_workspace(), workspace, patches); });
}

/// What a keyframe costs that is linked with nothing, and what each link costs.
void take_patches(benchmark::State& state) {
  static const auto workspace = std::make_unique<PlacePatchWorkspace>();
  const test::Image image = test::render_texture(640, 480, {1, 0, 1000, 2000}, 1, 0, 1, 1);
  PlacePatches patches;
  for (auto _ : state) benchmark::DoNotOptimize(all_patches(image.view(), *workspace, patches));
  state.counters["patches"] = static_cast<double>(patches.size());
}
BENCHMARK(take_patches)->Unit(benchmark::kMillisecond);

/// Argument: shift along x, px.
void find_patches(benchmark::State& state) {
  static const auto workspace = std::make_unique<PlacePatchWorkspace>();
  const test::Image older = test::render_texture(640, 480, {1, 0, 3100, 2000}, 0.7, 0, 1, 7);
  const auto shift = static_cast<double>(state.range(0));
  const test::Image newer = test::render_texture(640, 480, {1, 0, 3100 + shift, 2000}, 0.7, 0, 1, 8);
  PlacePatches patches;
  (void)all_patches(older.view(), *workspace, patches).ok();
  const double plane[9] = {1, 0, 3 - shift, 0, 1, -2, 0, 0, 1};
  PatchSightings sightings;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        find_place_patches({patches.data(), patches.size()}, newer.view(), plane, {}, *workspace, sightings));
  }
  state.counters["found"] = static_cast<double>(sightings.size());
}
BENCHMARK(find_patches)->Arg(0)->Arg(300)->Unit(benchmark::kMillisecond);

/// The newer image shows the middle of the older one twice as fine, and is smoothed about each patch.
void find_patches_twice_as_near(benchmark::State& state) {
  static const auto workspace = std::make_unique<PlacePatchWorkspace>();
  const test::Image older = test::render_texture(640, 480, {1, 0, 3100, 2000}, 0.7, 0, 1, 7);
  const test::Image newer = test::render_texture(640, 480, {0.5, 0, 3260, 2120}, 0.7, 0, 1, 8);
  PlacePatches patches;
  (void)all_patches(older.view(), *workspace, patches).ok();
  const double plane[9] = {2, 0, -317, 0, 2, -242, 0, 0, 1};
  PatchSightings sightings;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        find_place_patches({patches.data(), patches.size()}, newer.view(), plane, {}, *workspace, sightings));
  }
  state.counters["found"] = static_cast<double>(sightings.size());
}
BENCHMARK(find_patches_twice_as_near)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ilp

BENCHMARK_MAIN();
