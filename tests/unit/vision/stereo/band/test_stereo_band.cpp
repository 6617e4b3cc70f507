// Bands of rows as jobs: whoever does them, the disparities and their errors are the matcher's own, bit by bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/vision/stereo/match/stereo_matcher.hpp"
#include "tests/support/strip.hpp"

namespace ilp::test {
namespace {

constexpr std::int32_t width = 203, height = 150;

/// Ground with steps, slopes, a blank field and noise, under masks that cut corners off.
struct Pair {
  Image left{width, height}, right{width, height};
  std::vector<std::uint8_t> left_valid, right_valid;

  explicit Pair(double nearest) : left_valid(left.pixels.size(), 255), right_valid(left.pixels.size(), 255) {
    Rng rng(7);
    const auto noisy = [&](double grey) {
      return static_cast<std::uint8_t>(std::clamp(grey + 6 * rng.uniform() - 3, 0.0, 255.0));
    };
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = 0; x < width; ++x) {
        const bool blank = x > 140 && y > 110;
        const double shift = nearest - ((x / 60 + y / 50) % 2 == 0 ? 12 : 2) + 0.02 * y;
        left.view().at(x, y) = noisy(blank ? 120 : fractal_texture(x, y, 3, 5));
        right.view().at(x, y) = noisy(blank ? 120 : fractal_texture(x + shift, y, 3, 5));
        const std::size_t k = static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x);
        if (x + y < 40) left_valid[k] = 0;
        if (width - x + y < 50 || y > height - 4) right_valid[k] = 0;
      }
    }
  }
};

struct Case {
  DisparityRange range;
  int radius;
};

struct Memory {
  StereoWorkspace matcher, elsewhere;
  StereoBandJob job;
  StereoBandWorkspace borrowed;
};
Memory& memory() {
  static const auto owned = std::make_unique<Memory>();
  return *owned;
}

using Maps = std::vector<float>;

StereoParams params_of(const Case& c) {
  StereoParams params;
  params.window_radius = c.radius;
  return params;
}

Status begin(const Pair& pair, const Case& c, const StereoParams& params, StereoMatcher& matcher, Maps& maps) {
  maps.assign(2 * pair.left.pixels.size(), 0);
  return matcher.begin(pair.left.view(), pair.right.view(), {pair.left_valid.data(), width, height},
                       {pair.right_valid.data(), width, height}, c.range, params, memory().matcher,
                       {{maps.data(), width, height}, {maps.data() + pair.left.pixels.size(), width, height}});
}

Maps matched(const Pair& pair, const Case& c) {
  Maps maps;
  StereoMatcher matcher;
  EXPECT_TRUE(begin(pair, c, params_of(c), matcher, maps).ok());
  EXPECT_TRUE(do_all([&] { return matcher.step(16); }).ok());
  return maps;
}

/// What `answer` writes as the output of each job.
template <typename Answer>
Maps matched_in_bands(const Pair& pair, const Case& c, Answer answer) {
  Memory& m = memory();
  Maps maps;
  StereoMatcher matcher;
  bool pending = begin(pair, c, params_of(c), matcher, maps).ok();
  EXPECT_TRUE(pending && matcher.match_in_bands(m.job));
  int bands = 0;
  while (pending) {
    if (matcher.wants_band()) {
      matcher.describe_band();
      answer(m.job);
      matcher.take_band();
      ++bands;
    }
    const Result<bool> stepped = matcher.step(7);
    EXPECT_TRUE(stepped.ok());
    pending = stepped.value();
  }
  EXPECT_EQ(bands, (height + stereo_band_rows - 1) / stereo_band_rows);
  return maps;
}

std::span<std::byte> unit_of(StereoBandOutput& output, std::size_t unit) {
  return std::as_writable_bytes(std::span(&output, 1)).subspan(unit * stereo_band_unit_bytes, stereo_band_unit_bytes);
}

void do_job(StereoBandJob& job) {
  for (std::size_t unit = 0; unit < stereo_band_units; ++unit) {
    compute_stereo_band_unit(job.input, unit, memory().borrowed, unit_of(job.output, unit));
  }
}

class StereoBand : public ::testing::Test {
 protected:
  void SetUp() override { StereoMatcher::lend(memory().elsewhere, memory().borrowed); }
};

TEST_F(StereoBand, PairsHaveTheBytesOfTheMatcher) {
  // One block of disparities, searches that the coarse map narrows, ground nearer and farther than infinity's, and the
  // most that a job takes.
  for (const Case& c : {Case{{0, 11}, 2}, Case{{5, 51}, 1}, Case{{0, 63}, 2}, Case{{-40, 59}, 3}, Case{{0, 127}, 4}}) {
    SCOPED_TRACE(testing::Message() << c.range.min_px << " to " << c.range.max_px << ", radius " << c.radius);
    const Pair pair(std::min(c.range.max_px - 4, 45));
    const Maps own = matched(pair, c), bands = matched_in_bands(pair, c, do_job);
    const auto differs = std::mismatch(own.begin(), own.end(), bands.begin()).first - own.begin();
    EXPECT_EQ(differs, static_cast<std::ptrdiff_t>(own.size())) << "row " << differs % (width * height) / width;
    const auto found = std::count_if(own.begin(), own.begin() + width * height, [](float d) { return d != 0; });
    EXPECT_GT(found, width * height / 3);
  }
}

TEST_F(StereoBand, UnitsHaveTheSameBytesInAnyOrder) {
  const auto input = std::make_unique<StereoBandInput>();
  const auto in_order = std::make_unique<StereoBandOutput>(), any = std::make_unique<StereoBandOutput>();
  for (std::uint32_t number = 0; number < 8; ++number) {
    make_stereo_band_example(number, memory().borrowed, *input);
    for (std::size_t unit = 0; unit < stereo_band_units; ++unit) {
      compute_stereo_band_unit(*input, unit, memory().borrowed, unit_of(*in_order, unit));
    }
    for (std::size_t k = 0; k < stereo_band_units; ++k) {
      const std::size_t unit = (k * 37 + number) % stereo_band_units;
      compute_stereo_band_unit(*input, unit, memory().borrowed, unit_of(*any, unit));
    }
    EXPECT_EQ(std::memcmp(in_order.get(), any.get(), sizeof *any), 0) << number;
  }
}

TEST_F(StereoBand, JobsForgetTheOneBefore) {
  const auto first = std::make_unique<StereoBandInput>(), second = std::make_unique<StereoBandInput>();
  make_stereo_band_example(3, memory().borrowed, *first);
  make_stereo_band_example(4, memory().borrowed, *second);
  std::vector<std::byte> fresh(stereo_band_unit_bytes), after(stereo_band_unit_bytes);
  compute_stereo_band_unit(*second, 1, memory().borrowed, fresh);
  // The second job lies where the first one lay, and the next row of the first one is the row that is asked for.
  const auto place = std::make_unique<StereoBandInput>(*first);
  compute_stereo_band_unit(*place, 0, memory().borrowed, after);
  *place = *second;
  compute_stereo_band_unit(*place, 1, memory().borrowed, after);
  EXPECT_EQ(fresh, after);
}

TEST_F(StereoBand, PairsThatJobsDoNotMatchAreMatchedWithoutThem) {
  const Pair pair(45);
  Maps maps;
  StereoMatcher matcher;
  const Case wide{{0, stereo_band_disparities}, 2}, narrow{{0, 63}, 2};
  ASSERT_TRUE(begin(pair, wide, params_of(wide), matcher, maps).ok());
  EXPECT_FALSE(matcher.match_in_bands(memory().job));
  StereoParams ordered = params_of(narrow);
  ordered.matcher = StereoMatcherChoice::ordered_scanline;
  ASSERT_TRUE(begin(pair, narrow, ordered, matcher, maps).ok());
  EXPECT_FALSE(matcher.match_in_bands(memory().job));
  ASSERT_TRUE(do_all([&] { return matcher.step(16); }).ok());
  EXPECT_FALSE(matcher.wants_band());
}

TEST_F(StereoBand, AnAnswerOfRubbishStaysInItsPlace) {
  Rng rng(5);
  const Case c{{0, 63}, 2};
  const Maps maps = matched_in_bands(Pair(45), c, [&](StereoBandJob& job) {
    for (std::byte& byte : std::as_writable_bytes(std::span(&job.output, 1))) byte = static_cast<std::byte>(rng.next());
  });
  for (std::size_t i = 0; i < maps.size() / 2; ++i) {
    ASSERT_GE(maps[i], -1) << i;
    ASSERT_LE(maps[i], 64) << i;
  }
}

}  // namespace
}  // namespace ilp::test
