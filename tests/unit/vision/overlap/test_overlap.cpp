#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "fsw/base/math.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "tests/support/strip.hpp"

namespace ilp {
namespace {

OverlapWorkspace& workspace() {
  static const auto w = std::make_unique<OverlapWorkspace>();
  return *w;
}

OverlapResult measure(const test::Image& a, const test::Image& b, const OverlapParams& params = {}) {
  OverlapResult result;
  const Status status = measure_overlap(a.view(), b.view(), params, workspace(), result);
  EXPECT_TRUE(status.ok()) << status_name(status.code);
  return result;
}

// Two views of the endless landscape; b_from_a turns and scales about the image centre.
struct Scene {
  test::Image a, b;
  Similarity2 b_from_a;
};

Scene scene(std::int32_t width, std::int32_t height, double scale, double rotation_rad, double shift_x, double shift_y,
            double gain = 1, double offset = 0, double noise = 0) {
  const double cx = 0.5 * (width - 1), cy = 0.5 * (height - 1);
  Similarity2 b_from_a{scale, rotation_rad, 0, 0};
  double x = 0, y = 0;
  test::apply(b_from_a, cx, cy, x, y);
  b_from_a.shift_x_px = cx - x + shift_x;
  b_from_a.shift_y_px = cy - y + shift_y;
  const Similarity2 world_from_a{1, 0, 1000, 2000};
  Scene s{.a = test::render_texture(width, height, world_from_a, 1, 0, noise, 1), .b_from_a = b_from_a};
  s.b =
      test::render_texture(width, height, test::compose(world_from_a, test::inverse(b_from_a)), gain, offset, noise, 2);
  return s;
}

TEST(Overlap, BothVectorWidthsMeasureTheSame) {
  const Scene s = scene(640, 480, 1.08, 0.12, 40, 70, 0.9, 8, 2);
  const OverlapResult wide = measure(s.a, s.b);
  use_vectors(VectorWidth::bytes16);
  const OverlapResult narrow = measure(s.a, s.b);
  use_vectors(widest_vectors());
  ASSERT_EQ(wide.verdict, OverlapVerdict::ok);
  EXPECT_EQ(narrow.verdict, OverlapVerdict::ok);
  EXPECT_EQ(wide.overlap, narrow.overlap);
  EXPECT_EQ(wide.ncc, narrow.ncc);
  EXPECT_EQ(wide.ncc_second, narrow.ncc_second);
  EXPECT_EQ(wide.region_ncc, narrow.region_ncc);
  EXPECT_EQ(wide.sigma_px, narrow.sigma_px);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(wide.plane_b_from_a[i], narrow.plane_b_from_a[i]) << i;
}

// Largest distance between where two similarities send the corners of a.
double corner_error(const Similarity2& p, const Similarity2& q, std::int32_t width, std::int32_t height) {
  double worst = 0;
  for (const double x : {0.0, width - 1.0}) {
    for (const double y : {0.0, height - 1.0}) {
      double px, py, qx, qy;
      test::apply(p, x, y, px, py);
      test::apply(q, x, y, qx, qy);
      worst = std::max(worst, std::hypot(px - qx, py - qy));
    }
  }
  return worst;
}

struct Case {
  const char* name;
  std::int32_t width, height;
  double scale, rotation_rad, shift_x, shift_y, gain, offset, noise;
};

class OverlapOfWarpedPair : public testing::TestWithParam<Case> {};

TEST_P(OverlapOfWarpedPair, IsMeasured) {
  const Case& c = GetParam();
  if (static_cast<std::size_t>(c.width) * static_cast<std::size_t>(c.height) > limits::max_image_pixels) {
    GTEST_SKIP() << "beyond the limits of the profile " << limits::profile;
  }
  const Scene s = scene(c.width, c.height, c.scale, c.rotation_rad, c.shift_x, c.shift_y, c.gain, c.offset, c.noise);
  const double expected = footprint_overlap(c.width, c.height, s.b_from_a);
  for (const OverlapMethod method : {OverlapMethod::ncc, OverlapMethod::sad}) {
    OverlapParams params{.method = method};
    const OverlapResult result = measure(s.a, s.b, params);
    ASSERT_EQ(result.verdict, OverlapVerdict::ok) << result.ncc << " " << result.ncc_second;
    EXPECT_NEAR(result.overlap, expected, 0.005);
    const double error = corner_error(result.b_from_a, s.b_from_a, c.width, c.height);
    EXPECT_LT(error, 1.0);
    // The corners are farther from the centre, where the shift is known best.
    EXPECT_LT(error, 0.3 + 6 * result.sigma_px);
  }
}

INSTANTIATE_TEST_SUITE_P(Synthetic, OverlapOfWarpedPair,
                         testing::Values(Case{"same_place", 640, 480, 1, 0, 0, 0, 1, 0, 2},
                                         Case{"half_overlap_along_x", 640, 480, 1, 0, 315, 0, 1, 0, 2},
                                         Case{"half_overlap_diagonal", 640, 480, 1, 0, -180, 130, 1, 0, 2},
                                         Case{"turned_right", 640, 480, 1, 0.33, 20, -60, 1, 0, 2},
                                         Case{"turned_left_and_climbing", 640, 480, 0.85, -0.17, 40, 110, 1, 0, 2},
                                         Case{"sinking", 640, 480, 1.22, 0.1, -30, 20, 1, 0, 2},
                                         Case{"exposure_changed", 640, 480, 1.02, 0.03, 60, 70, 0.6, 30, 3},
                                         Case{"noisy", 640, 480, 0.97, -0.05, 100, 20, 0.8, 0, 12},
                                         Case{"odd_size", 721, 483, 0.93, 0.15, -120, 60, 1, 5, 2},
                                         Case{"small", 130, 98, 1.05, -0.1, 25, -14, 1, 0, 1}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST(Overlap, FindsAnyAttitudeWhenAskedForAFullTurn) {
  const Scene s = scene(640, 480, 1.05, 2.6, 40, -70, 1, 0, 2);
  OverlapParams params{.max_rotation_rad = pi};
  const OverlapResult result = measure(s.a, s.b, params);
  ASSERT_EQ(result.verdict, OverlapVerdict::ok);
  EXPECT_LT(corner_error(result.b_from_a, s.b_from_a, 640, 480), 1.0);
}

TEST(Overlap, SearchesAroundThePrediction) {
  const Scene s = scene(640, 480, 0.8, -1.2, 40, -70, 1, 0, 2);
  OverlapParams params{.predicted_rotation_rad = -1.0, .predicted_scale = 0.9};
  const OverlapResult result = measure(s.a, s.b, params);
  ASSERT_EQ(result.verdict, OverlapVerdict::ok);
  EXPECT_LT(corner_error(result.b_from_a, s.b_from_a, 640, 480), 1.0);
}

TEST(Overlap, FollowsTheTiltOfTheCamera) {
  // A homography about the image centre, as a camera tilted by some ten degrees sees flat ground.
  const double about_centre[9] = {1.02, -0.12, 35, 0.10, 0.97, -60, 2.5e-4, -1.5e-4, 1};
  test::Image a(640, 480), b(640, 480);
  const auto b_from_a = [&](double x, double y, double& bx, double& by) {
    const double u = x - 319.5, v = y - 239.5;
    const double w = about_centre[6] * u + about_centre[7] * v + 1;
    bx = (about_centre[0] * u + about_centre[1] * v + about_centre[2]) / w + 319.5;
    by = (about_centre[3] * u + about_centre[4] * v + about_centre[5]) / w + 239.5;
  };
  // b is rendered on the ground, a through the homography: so the way from a to b is the one given.
  int seen = 0;
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      double bx, by;
      b_from_a(x, y, bx, by);
      seen += bx >= -0.5 && by >= -0.5 && bx <= 639.5 && by <= 479.5 ? 1 : 0;
      const auto grey = [](double v) { return static_cast<std::uint8_t>(std::clamp(v + 0.5, 0.0, 255.0)); };
      a.view().at(x, y) = grey(test::fractal_texture(bx + 700, by + 300, 5, 1));
      b.view().at(x, y) = grey(test::fractal_texture(x + 700, y + 300, 5, 1));
    }
  }
  const OverlapResult result = measure(a, b);
  ASSERT_EQ(result.verdict, OverlapVerdict::ok);
  EXPECT_NEAR(result.overlap, seen / (640.0 * 480.0), 0.004);
  for (const double x : {100.0, 319.5, 539.0}) {
    for (const double y : {120.0, 239.5, 400.0}) {
      double bx, by;
      b_from_a(x, y, bx, by);
      const double(&h)[9] = result.plane_b_from_a;
      const double w = h[6] * x + h[7] * y + h[8];
      EXPECT_NEAR((h[0] * x + h[1] * y + h[2]) / w, bx, 0.5);
      EXPECT_NEAR((h[3] * x + h[4] * y + h[5]) / w, by, 0.5);
    }
  }
}

TEST(Overlap, RepeatedGroundIsUnknown) {
  // The same 160 x 160 tile again and again: four and more places match equally well.
  test::Image a(640, 480), b(640, 480);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      const auto tile = [](int u, int v) {
        return static_cast<std::uint8_t>(std::clamp(test::fractal_texture(u % 160, v % 160, 5, 1), 0.0, 255.0));
      };
      a.view().at(x, y) = tile(x, y);
      b.view().at(x, y) = tile(x + 80, y + 80);
    }
  }
  EXPECT_EQ(measure(a, b).verdict, OverlapVerdict::overlap_unknown);
}

// Partly covered positions are normalised over what they cover: the scores are those of the definition.
TEST(CoarseSearch, ScoresAreTheCorrelationOfTheCoveredPart) {
  const auto search = std::make_unique<CoarseWorkspace>();
  std::vector<std::int16_t> pixels_a(30 * 24), pixels_b(30 * 24);
  const ImageView<std::int16_t> a(pixels_a.data(), 30, 24), b(pixels_b.data(), 30, 24);
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 30; ++x) {
      // Strong shading along x: a wrong normalisation of the part shows.
      a.at(x, y) = static_cast<std::int16_t>(
          std::clamp(0.5 * test::fractal_texture(8 * x, 8 * y, 20, 1) + 9 * x - 30, 0.0, 1023.0));
      b.at(x, y) = static_cast<std::int16_t>(
          std::clamp(0.5 * test::fractal_texture(8 * (x + 9), 8 * (y - 4), 20, 1) + 9 * x - 10, 0.0, 1023.0));
    }
  }
  OverlapParams params{.max_rotation_rad = 0, .max_scale = 1};
  CoarseCandidates candidates;
  ASSERT_TRUE(search_coarse(a, b, params, *search, candidates).ok());
  ASSERT_FALSE(candidates.empty());
  int compared = 0;
  for (const CoarseCandidate& candidate : candidates) {
    const int dx = static_cast<int>(std::lround(candidate.b_from_a.d_x)),
              dy = static_cast<int>(std::lround(candidate.b_from_a.d_y));
    // Templates between the pixels are interpolated; the definition is checked on those that are not.
    if (std::fabs(candidate.b_from_a.d_x - dx) > 0.1 || std::fabs(candidate.b_from_a.d_y - dy) > 0.1) continue;
    ++compared;
    double n = 0, p = 0, q = 0, pp = 0, qq = 0, pq = 0;
    // The template ends half a pixel inside of a: its last row and column have no partner to interpolate with.
    for (int y = 0; y < 23; ++y) {
      for (int x = 0; x < 29; ++x) {
        if (!b.contains(x + dx, y + dy)) continue;
        const double u = a.at(x, y), v = b.at(x + dx, y + dy);
        n += 1, p += u, q += v, pp += u * u, qq += v * v, pq += u * v;
      }
    }
    const double expected = (n * pq - p * q) / std::sqrt((n * pp - p * p) * (n * qq - q * q));
    EXPECT_NEAR(candidate.score, expected, 1e-4) << dx << " " << dy;
    EXPECT_GE(n, 0.45 * 29 * 23 - 1);
  }
  EXPECT_GE(compared, 1);
}

TEST(Overlap, OtherGroundIsUnknownNotANumber) {
  const test::Image a = test::render_texture(640, 480, {1, 0, 0, 0}, 1, 0, 2, 1);
  for (int k = 1; k <= 8; ++k) {
    const test::Image b = test::render_texture(640, 480, {1, 0.1 * k, 5000.0 * k, 3000}, 1, 0, 2, 2);
    const OverlapResult result = measure(a, b);
    EXPECT_EQ(result.verdict, OverlapVerdict::overlap_unknown) << k << ": " << result.ncc << " " << result.ncc_second;
  }
}

TEST(Overlap, BeyondTheSearchedRangeIsNeverConfidentAndWrong) {
  for (const double shift : {380.0, 450.0, 520.0, 600.0}) {
    const Scene s = scene(640, 480, 1, 0.05, shift, 60, 1, 0, 2);
    const OverlapResult result = measure(s.a, s.b);
    if (result.verdict == OverlapVerdict::ok) {
      EXPECT_LT(corner_error(result.b_from_a, s.b_from_a, 640, 480), 3.0) << shift;
    }
  }
}

TEST(Overlap, SaysWhyAnImageCannotTell) {
  const Scene s = scene(640, 480, 1, 0, 50, 50, 1, 0, 2);
  test::Image dark = s.b, flat = s.b, smeared = s.b;
  for (std::uint8_t& p : dark.pixels) p = static_cast<std::uint8_t>(p / 32);
  for (std::uint8_t& p : flat.pixels) p = static_cast<std::uint8_t>(120 + p % 3);
  EXPECT_EQ(measure(s.a, dark).verdict, OverlapVerdict::too_dark);
  EXPECT_EQ(measure(flat, s.a).verdict, OverlapVerdict::texture_poor);
  // Motion along x over 25 px.
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      int sum = 0;
      for (int d = -12; d <= 12; ++d) sum += s.b.view().at(std::clamp(x + d, 0, 639), y);
      smeared.view().at(x, y) = static_cast<std::uint8_t>(sum / 25);
    }
  }
  EXPECT_EQ(measure(s.a, smeared).verdict, OverlapVerdict::blurred);
  EXPECT_EQ(measure(s.a, s.b).verdict, OverlapVerdict::ok);
}

TEST(Overlap, RefusesBadArguments) {
  const test::Image a(640, 480), small(320, 240), tiny(40, 30);
  OverlapResult result;
  OverlapParams params;
  EXPECT_TRUE(measure_overlap(a.view(), small.view(), params, workspace(), result).is(StatusCode::image_size_changed));
  EXPECT_TRUE(measure_overlap(tiny.view(), tiny.view(), params, workspace(), result).is(StatusCode::invalid_argument));
  params.max_scale = 3;
  EXPECT_TRUE(measure_overlap(a.view(), a.view(), params, workspace(), result).is(StatusCode::invalid_argument));
  params = {};
  params.max_rotation_rad = std::nan("");
  EXPECT_TRUE(measure_overlap(a.view(), a.view(), params, workspace(), result).is(StatusCode::invalid_argument));
}

TEST(Overlap, AnswersTheSameWhateverWasMeasuredBefore) {
  const Scene s = scene(640, 480, 0.9, 0.12, 90, -40, 1, 0, 2);
  const Scene other = scene(401, 363, 1.1, -0.2, 10, 40, 1, 0, 2);
  const OverlapResult first = measure(s.a, s.b);
  (void)measure(other.a, other.b);
  const OverlapResult second = measure(s.a, s.b);
  EXPECT_EQ(first.overlap, second.overlap);
  EXPECT_EQ(first.b_from_a.shift_x_px, second.b_from_a.shift_x_px);
  EXPECT_EQ(first.ncc_second, second.ncc_second);
}

}  // namespace
}  // namespace ilp
