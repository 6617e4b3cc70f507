#include "fsw/vision/overlap/wide_search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"
#include "tests/support/strip.hpp"
#include "tests/unit/vision/overlap/ground_texture.hpp"
#include "tests/unit/vision/overlap/search_widely.hpp"

namespace ilp {
namespace {

std::uint8_t pixel_of_b(const WideInput& input, std::int32_t x, std::int32_t y) {
  if (x < 0 || y < 0 || x >= input.width || y >= input.height) return 0;
  const std::int32_t plane = (y % 4) * 4 + x % 4;
  return input.b[static_cast<std::size_t>((plane * wide_plane_rows + y / 4) * wide_plane_stride + x / 4)];
}

// Bilinear in fixed point, written out from the definition; 0 where a pixel around it does not count.
std::int32_t sample_of_a(const WideInput& input, std::int64_t x, std::int64_t y) {
  if (x < 0 || y < 0 || x >= std::int64_t{input.width - 1} << 16 || y >= std::int64_t{input.height - 1} << 16) return 0;
  const std::int64_t stride = (input.width + 3) / 4 * 4;
  const std::int64_t fx = x % 65536 / 256, fy = y % 65536 / 256;
  std::int64_t sum = 0;
  for (int v = 0; v < 2; ++v) {
    for (int u = 0; u < 2; ++u) {
      const std::int64_t value = input.a[static_cast<std::size_t>((y / 65536 + v) * stride + x / 65536 + u)];
      if (value == 0) return 0;
      sum += value * (u == 1 ? fx : 256 - fx) * (v == 1 ? fy : 256 - fy);
    }
  }
  return static_cast<std::int32_t>((sum + 32768) / 65536);
}

std::uint32_t best_by_definition(const WideInput& input, const WidePose& pose, std::int32_t iy) {
  std::uint32_t best = 0;
  for (std::int32_t ix = 0; ix < pose.shifts_x; ++ix) {
    std::int64_t difference = 0, count = 0;
    for (std::int32_t j = 0; j < pose.rows; ++j) {
      for (std::int32_t i = 0; i < pose.columns; ++i) {
        const std::int32_t b = pixel_of_b(input, pose.left + 2 * ix + 4 * i, pose.top + 2 * iy + 4 * j);
        const std::int32_t a =
            b == 0 ? 0
                   : sample_of_a(input, pose.start_x + std::int64_t{pose.step_x} * i - std::int64_t{pose.step_y} * j,
                                 pose.start_y + std::int64_t{pose.step_y} * i + std::int64_t{pose.step_x} * j);
        if (a == 0) continue;
        ++count;
        difference += std::abs(a - b);
      }
    }
    const std::int64_t better = 36 * count - difference;
    if (count < pose.min_count || better <= 0 || better * better < count) continue;
    best = std::max(best, static_cast<std::uint32_t>(better * better / count * 256 + ix));
  }
  return best;
}

TEST(WideSearch, GivesTheSumsOfItsDefinition) {
  const auto input = std::make_unique<WideInput>();
  const auto workspace = std::make_unique<WideWorkspace>();
  int found = 0;
  for (std::uint32_t number = 0; number < 6; ++number) {
    make_wide_example(number, *input);
    for (std::size_t k = 0; k < wide_job_poses; k += 5) {
      std::array<std::uint32_t, wide_max_shifts> best;
      search_wide_pose(*input, k, *workspace, best);
      for (std::int32_t iy = 0; iy < wide_max_shifts; ++iy) {
        const WidePose& pose = input->poses[k];
        const bool searched = static_cast<std::int32_t>(k) < input->pose_count && iy < pose.shifts_y;
        const std::uint32_t expected = searched && iy % 5 == 0 ? best_by_definition(*input, pose, iy) : 0;
        if (searched && iy % 5 != 0) continue;
        ASSERT_EQ(best[static_cast<std::size_t>(iy)], expected) << number << " " << k << " " << iy;
        found += expected != 0 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(found, 100);
}

// Any turn, and scales from 0.75 to 1.3, which the search of the flight does not cover.
TEST(WideSearch, FindsPairsOutsideOfTheCoarseSearch) {
  constexpr std::int32_t w = 96, h = 72;
  const test::GroundTexture ground(test::Ground::craters, 72001);
  const auto workspace = std::make_unique<OverlapWorkspace>();
  int unknown = 0, decided = 0;
  for (int i = 0; i < 6; ++i) {
    Rng rng(static_cast<std::uint64_t>(i), 91);
    const Similarity2 b_from_a =
        test::with_overlap(0.65 + 0.2 * rng.uniform(), i % 2 == 0 ? 1.3 : 0.75, 1 + i * 0.7, 6 * rng.uniform(), w, h);
    const Similarity2 ground_from_a{1.5, 0.3 * i, 100.0 + 90 * i, 200};
    test::Exposure exposure;
    exposure.noise = 2;
    const test::Image a = test::look_at(ground, {}, ground_from_a, w, h, exposure, rng);
    const test::Image b =
        test::look_at(ground, {}, test::compose(ground_from_a, test::inverse(b_from_a)), w, h, exposure, rng);
    OverlapResult coarse;
    ASSERT_TRUE(measure_overlap(a.view(), b.view(), {}, *workspace, coarse).ok());
    unknown += coarse.verdict == OverlapVerdict::overlap_unknown ? 1 : 0;
    const OverlapResult found = test::search_widely(a.view(), b.view(), 0.5);
    if (found.verdict != OverlapVerdict::ok) continue;
    ++decided;
    EXPECT_NEAR(found.overlap, test::counted_overlap(b_from_a, w, h), 0.02) << i;
    EXPECT_NEAR(found.b_from_a.scale, b_from_a.scale, 0.01) << i;
  }
  EXPECT_EQ(unknown, 6);
  EXPECT_GE(decided, 5);
}

TEST(WideSearch, SaysNothingOfUnrelatedGround) {
  constexpr std::int32_t w = 96, h = 72;
  for (int i = 0; i < 6; ++i) {
    Rng rng(static_cast<std::uint64_t>(i), 92);
    const test::GroundTexture ground(static_cast<test::Ground>(i % 5), 72100);
    const test::Image a = test::look_at(ground, {}, {1.5, 0, 100, 100}, w, h, {}, rng);
    const test::Image b = test::look_at(ground, {}, {1.5, 1, 600, 600}, w, h, {}, rng);
    EXPECT_NE(test::search_widely(a.view(), b.view(), 0.5).verdict, OverlapVerdict::ok) << i;
  }
}

// A device may write anything: no content leads out of the plan.
TEST(WideSearch, PeaksOfGarbageStayWithinTheShifts) {
  const auto input = std::make_unique<WideInput>();
  const auto output = std::make_unique<WideOutput>();
  make_wide_example(3, *input);
  Rng rng(5, 5);
  for (auto& pose : output->best) {
    for (std::uint32_t& word : pose) word = rng.below(UINT32_MAX);
  }
  CoarseCandidates candidates;
  collect_wide_peaks(plan_wide_search(input->width, input->height, 0.5), 0, *input, *output, candidates);
  EXPECT_FALSE(candidates.empty());
  for (const CoarseCandidate& candidate : candidates) {
    EXPECT_LT(std::fabs(candidate.b_from_a.d_x), 2 * wide_max_shifts);
    EXPECT_LT(std::fabs(candidate.b_from_a.d_y), 2 * wide_max_shifts);
  }
}

TEST(WideSearch, RefusesImagesOfAnotherSize) {
  const auto input = std::make_unique<WideInput>();
  WidePlan plan;
  const test::Image large(200, 100), small(96, 72), other(72, 96);
  EXPECT_TRUE(prepare_wide_search(large.view(), large.view(), 0.5, *input, plan).is(StatusCode::invalid_argument));
  EXPECT_TRUE(prepare_wide_search(small.view(), other.view(), 0.5, *input, plan).is(StatusCode::image_size_changed));
}

}  // namespace
}  // namespace ilp
